// SPDX-License-Identifier: BSD-3-Clause
// glTF 2: a scene of many parts, joined to one mesh.
//
// Steps:
// 1. the JSON, its extensions, buffers and materials
// 2. check the scene's nodes; sum up the claims of their meshes, before memory is taken
// 3. append each mesh, at each of its places, to one mesh
// 4. bake pictures, or keep colours; convert to floats if these are as fine as the file's numbers.
#include "filters/convert/ForeignMesh.h"
#include "filters/convert/JoinParts.h"
#include "filters/convert/gltf/GltfAccessors.h"
#include "filters/convert/gltf/GltfBuffers.h"
#include "filters/convert/gltf/GltfDocument.h"
#include "filters/convert/gltf/GltfMaterials.h"
#include "filters/convert/gltf/GltfMeshes.h"
#include "filters/convert/gltf/GltfNodes.h"
#include "filters/core/VectorMath.h"
#include "filters/texture/BakeTextures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

namespace kdstream
{
namespace
{

using Json = nlohmann::json;

constexpr Color white{ 1, 1, 1, 1 };

// Whether floats would lose precision of the part: they would leave it fewer than 2^16 steps along
// its longest side, and its own numbers are finer.
bool NeedsDoubles(const Box& local, const Box& placed, const GltfPlace& place)
{
  constexpr double leastSteps = 0x1p16, stepsOfFloats = 0x1p23, asFine = 4;
  double largest = 0, largestLocal = 0, side = 0, scale = 0;
  for (std::size_t k = 0; k < 3; ++k)
  {
    largest = std::max({ largest, std::abs(placed.lo[k]), std::abs(placed.hi[k]) });
    largestLocal = std::max({ largestLocal, std::abs(local.lo[k]), std::abs(local.hi[k]) });
    side = std::max(side, placed.hi[k] - placed.lo[k]);
    scale = std::max(scale, Length(place.axes[k]));
  }
  return side * stepsOfFloats < leastSteps * largest && largest > asFine * scale * largestLocal;
}

const AttributeInfo normalsInfo{ "Normals", AttributeType::Float32, AttributeAssociation::Point,
  3 };

class GltfScene
{
public:
  GltfScene(const GltfDocument& document, const GltfBuffers& buffers,
    const std::filesystem::path& file, const TextureOptions& textures)
    : Document(document)
    , Nodes(document)
    , Materials(ReadGltfMaterials(document, buffers, file))
    , Textures(textures)
  {
    this->IsTextured = textures.bake && !this->Materials.pictures.empty();
  }

  const std::vector<PictureSource>& Pictures() const { return this->Materials.pictures; }

  Result<ForeignMesh> Read(GltfBuffers& buffers, const Execution& execution)
  {
    KDSTREAM_TRY(this->Nodes.Open());
    GltfMeshes meshes(this->Document, buffers, this->Materials.materials);
    KDSTREAM_TRY(this->AddClaims(meshes, buffers));
    this->ChooseArrays();
    KDSTREAM_TRY(this->AppendMeshes(meshes, buffers, execution));
    this->RoundToFloats();
    this->WarnOfAll();
    this->Joined.tolerance = this->Document.tolerance;
    this->Joined.tolerance.Add(meshes.Dropped());
    if (this->IsTextured && !this->Joined.mesh.points.empty())
    {
      KDSTREAM_TRY(this->Bake(execution));
    }
    else if (!this->IsTextured && this->Claims.coloured > 0)
    {
      AddColors(this->Joined.mesh, this->Colors);
    }
    return std::move(this->Joined);
  }

private:
  // How often each mesh stands in the scene, and what all of that makes.
  Status AddClaims(const GltfMeshes& meshes, GltfBuffers& buffers)
  {
    std::map<std::size_t, GltfMeshes::Claims> known;
    KDSTREAM_TRY(this->Nodes.ForEachMesh(buffers,
      [&](std::size_t node, const GltfPlace&) -> Status
      {
        const std::size_t mesh = this->MeshOf(node);
        if (this->Uses[mesh]++ == 0)
        {
          Result<GltfMeshes::Claims> claims = meshes.ClaimsOf(mesh);
          KDSTREAM_TRY(claims);
          known[mesh] = std::move(*claims);
        }
        this->Claims.Add(known[mesh]);
        if (this->Claims.zeros > 4 * GltfAccessor::mostZeros)
        {
          return Error{ ErrorCode::LimitExceeded,
            "its nodes show more than " + std::to_string(4 * GltfAccessor::mostZeros) +
              " elements of accessors without a bufferView, no bytes of which are in the file",
            {}, {}, Remedy::Repair };
        }
        constexpr std::uint64_t most = noVertex - 1;
        return this->Claims.points <= most && this->Claims.triangles <= most
                 ? Status{}
                 : Status(Error{ ErrorCode::LimitExceeded,
                     "its nodes show more than " + std::to_string(most) +
                       " points or triangles, more than can be read: show its meshes less often",
                     {}, {}, Remedy::Told });
      }));
    return {};
  }

  std::size_t MeshOf(std::size_t node) const
  {
    return IndexIn(Member(this->Document.json, "meshes"),
      Member(Member(this->Document.json, "nodes")[node], "mesh"));
  }

  Status AppendMeshes(GltfMeshes& meshes, GltfBuffers& buffers, const Execution& execution)
  {
    std::map<std::size_t, std::vector<GltfPart>> kept; // of meshes that come again
    std::size_t placed = 0;
    const auto total = static_cast<double>(std::max<std::uint64_t>(1, this->Claims.points));
    return this->Nodes.ForEachMesh(buffers,
      [&](std::size_t node, const GltfPlace& place) -> Status
      {
        constexpr std::size_t often = 256;
        if (placed++ % often == 0)
        {
          KDSTREAM_TRY(execution.Report("read", double(this->Joined.mesh.points.size()) / total));
        }
        const std::size_t mesh = this->MeshOf(node);
        const Json& weights = Member(Member(this->Document.json, "nodes")[node], "weights");
        const auto found = weights.is_null() ? kept.find(mesh) : kept.end();
        std::vector<GltfPart> read;
        if (found == kept.end())
        {
          Result<std::vector<GltfPart>> parts = meshes.PartsOf(mesh, weights);
          KDSTREAM_TRY(parts);
          read = std::move(*parts);
        }
        for (const GltfPart& part : found == kept.end() ? read : found->second)
        {
          KDSTREAM_TRY(this->AppendPart(part, node, place, buffers));
        }
        if (--this->Uses[mesh] == 0)
        {
          kept.erase(mesh);
        }
        else if (found == kept.end() && weights.is_null())
        {
          kept.emplace(mesh, std::move(read));
        }
        return {};
      });
  }

  Status AppendPart(
    const GltfPart& part, std::size_t node, const GltfPlace& place, GltfBuffers& buffers)
  {
    const Json& skins = Member(this->Document.json, "skins");
    const Json& skin = Member(Member(this->Document.json, "nodes")[node], "skin");
    if (skin.is_null() || part.jointsOfPoint == 0)
    {
      return this->Append(part, place);
    }
    const std::size_t number = IndexIn(skins, skin);
    if (number == CountOf(skins))
    {
      return Error{ ErrorCode::InvalidInput,
        "node " + std::to_string(node) + " " + NamesNone("skin", skin, skins) };
    }
    GltfPart moved = part;
    KDSTREAM_TRY(ApplyGltfSkin(this->Document, buffers, this->Nodes, number, moved));
    return this->Append(moved, GltfPlace{});
  }

  Status Append(const GltfPart& part, const GltfPlace& place)
  {
    Mesh& mesh = this->Joined.mesh;
    const std::size_t first = mesh.points.size();
    if (part.points.size() >= noVertex - first) // more than was claimed: Draco's
    {
      return Error{ ErrorCode::LimitExceeded, "more than 4294967294 points; as many can be read" };
    }
    const bool isMoved = !(place == GltfPlace{});
    this->AppendPoints(part, place, isMoved);
    const bool isMirrored = isMoved && place.Determinant() < 0;
    const auto offset = static_cast<VertexId>(first);
    for (const Triangle& t : part.triangles)
    {
      mesh.triangles.push_back(
        { t[0] + offset, t[isMirrored ? 2 : 1] + offset, t[isMirrored ? 1 : 2] + offset });
    }
    for (Attribute& array : mesh.attributes)
    {
      if (array.Info() == normalsInfo)
      {
        AppendNormals(part.normals, place, array);
      }
      else if (const Attribute* const from = FindAttribute(part.arrays, array))
      {
        array.values.insert(array.values.end(), from->values.begin(), from->values.end());
      }
    }
    this->Lines += part.lines;
    this->IsPosed = this->IsPosed || part.jointsOfPoint > 0;
    this->IsTextured ? this->AppendTextured(part, first) : this->AppendColors(part);
    return {};
  }

  static void AppendNormals(
    const std::vector<Vec3>& normals, const GltfPlace& place, Attribute& array)
  {
    std::size_t tuple = array.TupleCount();
    array.values.resize(array.values.size() + normals.size() * array.TupleSize());
    for (const Vec3& normal : normals)
    {
      const Vec3 turned = place.OfNormal(normal);
      for (std::size_t k = 0; k < 3; ++k)
      {
        array.Set(tuple, k, turned[k]);
      }
      ++tuple;
    }
  }

  void AppendPoints(const GltfPart& part, const GltfPlace& place, bool isMoved)
  {
    std::vector<Vec3>& points = this->Joined.mesh.points;
    if (!isMoved)
    {
      std::transform(
        part.points.begin(), part.points.end(), std::back_inserter(points), WithPositiveZeros);
      return;
    }
    Box local, placed;
    bool areFloats = true;
    for (const Vec3& point : part.points)
    {
      const Vec3 at = place.Of(point);
      local.Add(point);
      placed.Add(at);
      areFloats = areFloats && std::all_of(at.begin(), at.end(),
                                 [](double value) { return double(float(value)) == value; });
      points.push_back(at);
    }
    this->AreDoubles = this->AreDoubles || (!areFloats && NeedsDoubles(local, placed, place));
  }

  // Colours of the points: the part's own, times the material's.
  void AppendColors(const GltfPart& part)
  {
    if (this->Claims.coloured == 0)
    {
      return;
    }
    const TexturedMaterial paint = part.material < this->Materials.materials.size()
                                     ? this->Materials.materials[part.material].paint
                                     : TexturedMaterial{};
    for (std::size_t i = 0; i < part.points.size(); ++i)
    {
      const Color own = part.colors.empty() ? white : part.colors[i];
      std::array<double, 4> channels{};
      for (std::size_t k = 0; k < 4; ++k)
      {
        const double light = own[k] * paint.factor[k];
        channels[k] = std::clamp(k < 3 ? FromLinear(light) : light, 0.0, 1.0);
      }
      channels[3] = paint.opaque ? 1 : channels[3];
      this->Colors.push_back(channels);
    }
  }

  // What pictures paint: coordinates and material of each triangle, and colours that multiply it.
  void AppendTextured(const GltfPart& part, std::size_t first)
  {
    const bool hasMaterial = part.material < this->Materials.materials.size();
    std::vector<Triangle>& triangles = this->Joined.mesh.triangles;
    for (std::size_t t = triangles.size() - part.triangles.size(); t < triangles.size(); ++t)
    {
      std::array<PictureCoordinate, 3>& corners = this->Textured.corners.emplace_back();
      for (std::size_t k = 0; k < 3; ++k)
      {
        corners[k] =
          part.pictures.empty() ? noPictureCoordinate : part.pictures[triangles[t][k] - first];
      }
      this->Textured.materialOf.push_back(
        static_cast<std::uint32_t>(hasMaterial ? part.material : this->Materials.materials.size()));
    }
    this->Colors.resize(this->Joined.mesh.points.size(), white);
    std::copy(part.colors.begin(), part.colors.end(),
      this->Colors.begin() + static_cast<std::ptrdiff_t>(first));
    this->IsTinted = this->IsTinted || std::any_of(part.colors.begin(), part.colors.end(),
                                         [](const Color& color) { return color != white; });
  }

  void RoundToFloats()
  {
    Mesh& mesh = this->Joined.mesh;
    mesh.scalarType = this->AreDoubles ? ScalarType::Float64 : ScalarType::Float32;
    for (std::size_t i = 0; i < mesh.points.size() && !this->AreDoubles; ++i)
    {
      for (double& value : mesh.points[i])
      {
        value = double(float(value));
      }
    }
  }

  void WarnOfAll()
  {
    std::vector<std::string>& warnings = this->Joined.warnings;
    warnings.insert(warnings.end(), this->Nodes.Notes().begin(), this->Nodes.Notes().end());
    if (this->Claims.parts == 0)
    {
      warnings.emplace_back("no node of its scene shows a mesh that has points");
    }
    if (this->Lines > 0)
    {
      warnings.push_back("left out: " + std::to_string(this->Lines) +
                         (this->Lines == 1 ? " line cell" : " line cells") + "; their points stay");
    }
    if (this->IsPosed || CountOf(Member(this->Document.json, "animations")) > 0)
    {
      warnings.emplace_back(
        "skins and animations are not carried: the mesh is in the pose that its nodes have");
    }
    // Of a file without pictures looks are not reported one by one.
    if (!Member(this->Document.json, "images").is_null() ||
        !Member(this->Document.json, "textures").is_null())
    {
      warnings.insert(
        warnings.end(), this->Materials.warnings.begin(), this->Materials.warnings.end());
    }
    if (!this->IsTextured && !this->Materials.pictures.empty())
    {
      warnings.emplace_back("pictures are left out");
    }
  }

  // Arrays that all parts have; where pictures paint, their coordinates are used up.
  void ChooseArrays()
  {
    for (const auto& [info, count] : this->Claims.arrays)
    {
      if (this->IsTextured && RoleOf(info) == AttributeRole::TextureCoordinates)
      {
        continue;
      }
      if (count < this->Claims.parts)
      {
        this->Joined.warnings.push_back(
          "array \"" + info.name + "\" is dropped: not all parts have it");
        continue;
      }
      static_cast<AttributeInfo&>(this->Joined.mesh.attributes.emplace_back()) = info;
    }
  }

  Status Bake(const Execution& execution)
  {
    for (const GltfMaterial& material : this->Materials.materials)
    {
      this->Textured.materials.push_back(material.paint);
    }
    this->Textured.materials.push_back({}); // of parts without one
    this->Textured.pictures = std::move(this->Materials.pictures);
    this->Textured.mesh = std::move(this->Joined.mesh);
    TextureOptions used = this->Textures;
    if (this->IsTinted && !used.textureFolder.empty())
    {
      used.textureFolder.clear();
      this->Joined.warnings.emplace_back(
        "colours of vertices are multiplied in: the pictures themselves are not kept");
    }
    Result<BakeReport> report = BakeAndKeepTextures(this->Textured, used, execution);
    KDSTREAM_TRY(report);
    this->Joined.mesh = std::move(this->Textured.mesh);
    this->MultiplyByOwn(this->Joined.mesh.attributes);
    this->Joined.warnings.insert(
      this->Joined.warnings.end(), report->warnings.begin(), report->warnings.end());
    this->Joined.baked = std::move(*report);
    return {};
  }

  // REQUIRES: the colours were baked.
  void MultiplyByOwn(std::vector<Attribute>& arrays) const
  {
    Attribute& colors = *std::find_if(arrays.begin(), arrays.end(),
      [](const Attribute& array) { return RoleOf(array) == AttributeRole::Colors; });
    for (std::size_t i = 0; this->IsTinted && i < this->Colors.size(); ++i)
    {
      for (std::size_t k = 0; k < colors.components; ++k)
      {
        const auto byte = static_cast<std::size_t>(colors.Get(i, k));
        colors.Set(i, k,
          k < 3 ? ByteOfLinear(LinearOfBytes()[byte] * this->Colors[i][k])
                : double(byte) * std::clamp(this->Colors[i][k], 0.0, 1.0));
      }
    }
  }

  const GltfDocument& Document;
  GltfNodes Nodes;
  GltfMaterials Materials;
  const TextureOptions& Textures;
  bool IsTextured = false;

  std::map<std::size_t, std::size_t> Uses; // of meshes
  GltfMeshes::Claims Claims;

  ForeignMesh Joined;
  std::vector<Color> Colors; // of the points; where pictures paint, what multiplies them
  TexturedMesh Textured;
  std::size_t Lines = 0;
  bool AreDoubles = false, IsPosed = false;
  bool IsTinted = false; // by colours that are not white, as modellers write where none is painted
};

}

Result<ForeignMesh> ReadGltf(
  const std::filesystem::path& file, const TextureOptions& textures, const Execution& execution)
{
  KDSTREAM_TRY(execution.Report("read", 0));
  const Result<GltfDocument> document = ReadGltfDocument(file);
  KDSTREAM_TRY(document);
  std::optional<std::string> notRead;
  KDSTREAM_TRY(CheckGltfExtensions(document->json, notRead));
  GltfBuffers buffers = GltfBuffers::Open(*document, file);
  GltfScene scene(*document, buffers, file, textures);
  std::vector<std::filesystem::path> named = buffers.Files();
  for (const PictureSource& picture : scene.Pictures())
  {
    if (!picture.file.empty() && picture.file != file)
    {
      named.push_back(picture.file);
    }
  }
  Result<ForeignMesh> read = scene.Read(buffers, execution);
  if (!read && buffers.Missing())
  {
    return *buffers.Missing();
  }
  KDSTREAM_TRY(read);
  for (const std::size_t number : buffers.WrongOnes())
  {
    read->warnings.push_back(
      "buffer " + std::to_string(number) + " cannot be read, but no geometry needs it");
  }
  read->named = std::move(named);
  if (notRead)
  {
    read->warnings.push_back(std::move(*notRead));
  }
  return read;
}

}
