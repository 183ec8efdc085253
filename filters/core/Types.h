// SPDX-License-Identifier: BSD-3-Clause
// The few plain types that everything shares: points, triangles, boxes, resolutions.
#pragma once

#include "filters/core/Attribute.h"

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace kdstream
{

// Number of a vertex inside one mesh held in memory. A mesh has at most 2^32 - 2 vertices.
using VertexId = std::uint32_t;
inline constexpr VertexId noVertex = std::numeric_limits<VertexId>::max();

using Vec3 = std::array<double, 3>;
using Triangle = std::array<VertexId, 3>;

// Whether two corners are the same vertex.
constexpr bool IsDegenerate(const Triangle& t)
{
  return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

// Heap number of a node of the k-d tree: root 1, children 2i and 2i + 1, depth d holds 2^d …
// 2^(d+1) - 1.
using NodeId = std::uint32_t;

constexpr unsigned DepthOfNode(NodeId node)
{
  unsigned depth = 0;
  while (node > 1)
  {
    node >>= 1;
    ++depth;
  }
  return depth;
}

// The axis-aligned box of a set of points; empty (lo > hi) until something is added.
struct Box
{
  Vec3 lo{ std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
    std::numeric_limits<double>::infinity() };
  Vec3 hi{ -std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
    -std::numeric_limits<double>::infinity() };

  bool Empty() const { return this->lo[0] > this->hi[0]; }
  void Add(const Vec3& p)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      this->lo[k] = p[k] < this->lo[k] ? p[k] : this->lo[k];
      this->hi[k] = p[k] > this->hi[k] ? p[k] : this->hi[k];
    }
  }
  void Add(const Box& other)
  {
    if (!other.Empty())
    {
      this->Add(other.lo);
      this->Add(other.hi);
    }
  }
  bool operator==(const Box&) const = default;
};

// The type in which the input stores its coordinates; lossless pieces keep it.
enum class ScalarType : std::uint8_t
{
  Float32 = 0,
  Float64 = 1
};

enum class PrimitiveType : std::uint8_t
{
  Points = 0,
  Triangles = 1
};

// A level d, or the original, which is finer than every level. Ordered from coarse to fine.
class Resolution
{
public:
  static constexpr std::uint8_t maximumLevel = 62;

  constexpr Resolution() = default;
  static constexpr Resolution Level(unsigned depth)
  {
    return Resolution(static_cast<std::uint8_t>(depth));
  }
  static constexpr Resolution Original() { return Resolution(maximumLevel + 1); }

  constexpr bool IsOriginal() const { return this->Value == maximumLevel + 1; }
  // REQUIRES: !IsOriginal().
  constexpr unsigned Depth() const { return this->Value; }
  constexpr auto operator<=>(const Resolution&) const = default;

private:
  explicit constexpr Resolution(std::uint8_t value)
    : Value(value)
  {
  }
  std::uint8_t Value = 0;
};

// A triangle mesh, or a point cloud if it has no triangles. Coordinates are doubles, whatever type
// they had in the file: a double holds every float exactly.
struct Mesh
{
  std::vector<Vec3> points;
  std::vector<Triangle> triangles;
  ScalarType scalarType = ScalarType::Float32;
  std::vector<Attribute> attributes{}; // a tuple for each point, or for each triangle
};

}
