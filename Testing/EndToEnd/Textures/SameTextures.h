// SPDX-License-Identifier: BSD-3-Clause
// Compares two textured meshes, triangle by triangle: places, coordinates, and the texels that
// triangles use.
#pragma once

#include "Testing/EndToEnd/Textures/TexturedFiles.h"
#include "filters/core/BitCast.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace kdstream::fixtures
{

// A corner of a triangle: its place, and the bits of its coordinates.
using TexturedCorner = std::pair<Vec3, std::uint64_t>;
using TexturedTriangle = std::array<TexturedCorner, 3>;

// The bits of a coordinate; 0 if it is not finite, because NaN has no unique bits.
inline std::uint64_t BitsOf(const PictureCoordinate& corner)
{
  return std::isfinite(corner[0]) && std::isfinite(corner[1]) ? BitCast<std::uint64_t>(corner) : 0;
}

// The corners of a triangle, rotated so that the least corner comes first.
inline TexturedTriangle Turned(const TexturedMesh& textured, std::size_t t)
{
  TexturedTriangle triangle;
  for (std::size_t k = 0; k < 3; ++k)
  {
    triangle[k] = { textured.mesh.points[textured.mesh.triangles[t][k]],
      BitsOf(textured.corners[t][k]) };
  }
  std::rotate(triangle.begin(), std::min_element(triangle.begin(), triangle.end()), triangle.end());
  return triangle;
}

inline bool IsTextured(const TexturedMesh& textured, std::size_t t)
{
  return textured.materials[textured.materialOf[t]].picture != noPicture &&
         std::all_of(textured.corners[t].begin(), textured.corners[t].end(),
           [](const PictureCoordinate& corner) { return BitsOf(corner) != 0; });
}

// Compares the texels in a triangle; both files have the same coordinates. Returns the number of
// texels compared.
inline std::size_t CompareTexels(const TexturedMesh& before, std::size_t t,
  const std::vector<Picture>& from, const TexturedMesh& after, const std::vector<Picture>& to,
  std::size_t other)
{
  const TexturedMaterial& a = before.materials[before.materialOf[t]];
  const TexturedMaterial& b = after.materials[after.materialOf[other]];
  std::size_t looked = 0;
  for (std::size_t i = 0; i <= 5; ++i)
  {
    for (std::size_t j = 0; i + j <= 5; ++j, ++looked)
    {
      double u = 0, v = 0;
      const std::array<double, 3> shares{ double(i) / 5, double(j) / 5, double(5 - i - j) / 5 };
      for (std::size_t k = 0; k < 3; ++k)
      {
        u += shares[k] * double(before.corners[t][k][0]);
        v += shares[k] * double(before.corners[t][k][1]);
      }
      const Texel expected = PictureTexels(from[a.picture]).At(PlaceOf(a, u, v), a.wrapU, a.wrapV);
      EXPECT_EQ(PictureTexels(to[b.picture]).At(PlaceOf(b, u, v), b.wrapU, b.wrapV), expected);
    }
  }
  return looked;
}

// Compares every coordinate bit for bit, and every texel that a triangle uses.
inline void ExpectSameTextures(const TexturedMesh& before, const TexturedMesh& after)
{
  ASSERT_EQ(before.mesh.triangles.size(), after.mesh.triangles.size());
  std::map<TexturedTriangle, std::size_t> found;
  for (std::size_t t = 0; t < after.mesh.triangles.size(); ++t)
  {
    found.emplace(Turned(after, t), t);
  }
  const std::vector<Picture> from = PicturesOf(before), to = PicturesOf(after);
  std::size_t looked = 0;
  for (std::size_t t = 0; t < before.mesh.triangles.size(); ++t)
  {
    const auto same = found.find(Turned(before, t));
    ASSERT_NE(same, found.end()) << "triangle " << t;
    ASSERT_EQ(IsTextured(before, t), IsTextured(after, same->second));
    if (IsTextured(before, t))
    {
      looked += CompareTexels(before, t, from, after, to, same->second);
    }
  }
  EXPECT_GT(looked, 10 * before.mesh.triangles.size());
}

}
