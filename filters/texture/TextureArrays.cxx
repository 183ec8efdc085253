// SPDX-License-Identifier: BSD-3-Clause
#include "filters/texture/TextureArrays.h"

#include "filters/codec/ByteStream.h"
#include "filters/core/BitCast.h"

#include <algorithm>

namespace kdstream
{
namespace
{

void AppendNumber(std::uint32_t bits, std::vector<std::uint8_t>& bytes)
{
  for (int i = 0; i < 4; ++i, bits >>= 8)
  {
    bytes.push_back(static_cast<std::uint8_t>(bits));
  }
}

std::uint32_t NumberAt(const std::uint8_t* bytes)
{
  return std::uint32_t{ bytes[0] } | std::uint32_t{ bytes[1] } << 8 |
         std::uint32_t{ bytes[2] } << 16 | std::uint32_t{ bytes[3] } << 24;
}

Attribute EmptyArray(std::string_view name, AttributeType type, std::uint8_t components)
{
  return { { std::string(name), type, AttributeAssociation::Cell, components }, {} };
}

}

void AddTextureArrays(TexturedMesh& textured)
{
  Attribute corners = EmptyArray(textureCornersName, AttributeType::Float32, 6);
  Attribute materials = EmptyArray(textureMaterialName, AttributeType::UInt32, 1);
  corners.values.reserve(textured.corners.size() * corners.TupleSize());
  materials.values.reserve(textured.materialOf.size() * materials.TupleSize());
  for (std::size_t t = 0; t < textured.corners.size(); ++t)
  {
    for (const PictureCoordinate& corner : textured.corners[t])
    {
      AppendNumber(BitCast<std::uint32_t>(corner[0]), corners.values);
      AppendNumber(BitCast<std::uint32_t>(corner[1]), corners.values);
    }
    AppendNumber(textured.materialOf[t], materials.values);
  }
  std::vector<Attribute>& arrays = textured.mesh.attributes;
  std::erase_if(arrays,
    [](const Attribute& array)
    {
      return array.association == AttributeAssociation::Cell &&
             (array.name == textureCornersName || array.name == textureMaterialName);
    });
  arrays.push_back(std::move(corners));
  arrays.push_back(std::move(materials));
}

std::optional<TexturedTriangles> TakeTextureArrays(Piece& piece, std::size_t materials)
{
  TexturedTriangles texturedTriangles;
  texturedTriangles.triangles = piece.triangles;
  const std::size_t count = piece.triangles.size();
  std::size_t found = 0;
  for (const Attribute& array : piece.attributes)
  {
    if (!IsTextureArray(array) || array.TupleCount() != count)
    {
      continue;
    }
    ++found;
    const std::uint8_t* bytes = array.values.data();
    for (std::size_t t = 0; t < count; ++t)
    {
      if (!IsOfCorners(array))
      {
        texturedTriangles.materialOf.push_back(NumberAt(bytes));
        bytes += 4;
        continue;
      }
      for (PictureCoordinate& corner : texturedTriangles.corners.emplace_back())
      {
        corner = { BitCast<float>(NumberAt(bytes)), BitCast<float>(NumberAt(bytes + 4)) };
        bytes += 8;
      }
    }
  }
  std::erase_if(piece.attributes, IsTextureArray);
  const bool known =
    std::all_of(texturedTriangles.materialOf.begin(), texturedTriangles.materialOf.end(),
      [&](std::uint32_t material) { return material < materials; });
  return found == 2 && known ? std::optional(std::move(texturedTriangles)) : std::nullopt;
}

}
