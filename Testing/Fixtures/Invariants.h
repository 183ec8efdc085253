// SPDX-License-Identifier: BSD-3-Clause
// Functions by which tests compare meshes.
#pragma once

#include "filters/core/Types.h"
#include "filters/core/VectorMath.h"
#include "filters/core/levels/ClusterLevels.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

namespace kdstream::fixtures
{

// The signed volume of a closed mesh: above 0 if its triangles face outwards.
inline double VolumeOf(const Mesh& mesh)
{
  double volume = 0;
  for (const Triangle& t : mesh.triangles)
  {
    const Vec3 a = Minus(mesh.points[t[0]], mesh.points[0]);
    volume += Dot(a, Cross(Minus(mesh.points[t[1]], mesh.points[0]),
                       Minus(mesh.points[t[2]], mesh.points[0]))) /
              6;
  }
  return volume;
}

inline double AreaOf(const Mesh& mesh)
{
  double area = 0;
  for (const Triangle& t : mesh.triangles)
  {
    const Vec3& a = mesh.points[t[0]];
    area += Length(Cross(Minus(mesh.points[t[1]], a), Minus(mesh.points[t[2]], a))) / 2;
  }
  return area;
}

inline Box BoxOf(const Mesh& mesh)
{
  Box box;
  for (const Vec3& point : mesh.points)
  {
    box.Add(point);
  }
  return box;
}

using PointBits = std::array<std::uint64_t, 3>;

inline PointBits BitsOf(const Vec3& p)
{
  return { std::bit_cast<std::uint64_t>(p[0]), std::bit_cast<std::uint64_t>(p[1]),
    std::bit_cast<std::uint64_t>(p[2]) };
}

// The multiset of a mesh's coordinates, bit for bit.
inline std::vector<PointBits> PointMultiset(const Mesh& mesh)
{
  std::vector<PointBits> bits;
  for (const Vec3& p : mesh.points)
  {
    bits.push_back(BitsOf(p));
  }
  std::sort(bits.begin(), bits.end());
  return bits;
}

// The multiset of a mesh's triangles as coordinates. Each triangle is rotated to a fixed start, so
// orientation counts.
inline std::vector<std::array<PointBits, 3>> TriangleMultiset(const Mesh& mesh)
{
  std::vector<std::array<PointBits, 3>> triangles;
  for (const Triangle& t : mesh.triangles)
  {
    const PointBits a = BitsOf(mesh.points[t[0]]), b = BitsOf(mesh.points[t[1]]),
                    c = BitsOf(mesh.points[t[2]]);
    triangles.push_back(
      std::min({ std::array{ a, b, c }, std::array{ b, c, a }, std::array{ c, a, b } }));
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

using Edge = std::pair<VertexId, VertexId>;

// The edges that are used by exactly one triangle.
inline std::vector<Edge> BoundaryEdges(const std::vector<Triangle>& triangles)
{
  std::map<Edge, unsigned> uses;
  for (const Triangle& t : triangles)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      ++uses[std::minmax(t[k], t[(k + 1) % 3])];
    }
  }
  std::vector<Edge> boundary;
  for (const auto& [edge, count] : uses)
  {
    if (count == 1)
    {
      boundary.push_back(edge);
    }
  }
  return boundary;
}

}
