// SPDX-License-Identifier: BSD-3-Clause
#include "filters/texture/PictureTiles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>

namespace kdstream
{
namespace
{

constexpr std::string_view mark = "<udim>";

// The position of the mark in the name; npos if there is none.
std::size_t MarkIn(const std::string& name)
{
  const auto at = std::search(name.begin(), name.end(), mark.begin(), mark.end(),
    [](char a, char b) { return (a >= 'A' && a <= 'Z' ? char(a - 'A' + 'a') : a) == b; });
  return at == name.end() ? std::string::npos : static_cast<std::size_t>(at - name.begin());
}

std::string Numbered(std::string name, int tile)
{
  const std::size_t at = MarkIn(name);
  return at == std::string::npos ? name : name.replace(at, mark.size(), std::to_string(tile));
}

// The column, and the row from below, of a triangle's tile; -1 if it has no tile.
std::array<int, 2> TileOf(
  const TextureTransform& m, const std::array<PictureCoordinate, 3>& corners)
{
  double u = 0, v = 0;
  for (const PictureCoordinate& c : corners)
  {
    u += (m.u[0] * c[0] + m.u[1] * c[1] + m.u[2]) / 3;
    v += (1 - (m.v[0] * c[0] + m.v[1] * c[1] + m.v[2])) / 3;
  }
  const bool inside = u >= 0 && u < 10 && v >= 0 && v < 100; // false for NaN
  return inside ? std::array<int, 2>{ int(std::floor(u)), int(std::floor(v)) }
                : std::array<int, 2>{ -1, -1 };
}

}

bool HasTiles(const std::string& name)
{
  return MarkIn(name) != std::string::npos;
}

void SplitTiles(TexturedMesh& textured)
{
  std::map<std::pair<std::uint32_t, int>, std::uint32_t> materials, pictures; // by number and tile
  const std::size_t given = textured.materials.size();
  std::vector<bool> tiled(given);
  for (std::size_t i = 0; i < given; ++i)
  {
    const std::uint32_t picture = textured.materials[i].picture;
    tiled[i] = picture != noPicture && HasTiles(textured.pictures[picture].file.string());
  }
  for (std::size_t t = 0; t < textured.materialOf.size(); ++t)
  {
    const std::uint32_t material = textured.materialOf[t];
    if (!tiled[material])
    {
      continue;
    }
    const std::array<int, 2> at =
      TileOf(textured.materials[material].transform, textured.corners[t]);
    const int tile = at[0] < 0 ? 0 : 1001 + at[0] + 10 * at[1];
    const auto [known, added] = materials.try_emplace(
      { material, tile }, static_cast<std::uint32_t>(textured.materials.size()));
    if (added)
    {
      TexturedMaterial own = textured.materials[material];
      own.wrapU = own.wrapV = TextureWrap::Clamp;
      own.transform.u[2] -= at[0];
      own.transform.v[2] += at[1];
      const auto [picture, fresh] = pictures.try_emplace(
        { own.picture, tile }, static_cast<std::uint32_t>(textured.pictures.size()));
      if (tile != 0 && fresh)
      {
        PictureSource source = textured.pictures[own.picture];
        source.file = Numbered(source.file.string(), tile);
        source.name = Numbered(source.name, tile);
        textured.pictures.push_back(std::move(source));
      }
      own.picture = tile == 0 ? noPicture : picture->second;
      textured.materials.push_back(std::move(own));
    }
    textured.materialOf[t] = known->second;
  }
}

}
