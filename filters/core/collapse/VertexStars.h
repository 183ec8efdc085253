// SPDX-License-Identifier: BSD-3-Clause
// The triangles around each vertex of a mesh while its edges collapse. Only for EdgeCollapse.
#pragma once

#include "filters/core/Types.h"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace kdstream
{

// A corner of a triangle: 3 × triangle + index of the corner (0-2).
using Corner = std::uint32_t;

// A triangle around a vertex: its corner there, and the other two vertices, in the triangle's
// order.
struct StarSide
{
  VertexId first, second;
  Corner corner;
};

// The triangles around the ends u and v of an edge.
struct EdgeStar
{
  struct Facing
  {
    VertexId vertex;
    Corner corner;
  };

  std::vector<StarSide> sides; // of the triangles at u, then of those at v
  std::size_t ofU = 0;         // how many of `sides` are u's
  std::vector<Facing> facing;  // the third corner of each triangle that has both
};

// Keeps a list of corners for each vertex. A triangle has three different vertices; otherwise any
// triangles are allowed.
class VertexStars
{
public:
  VertexStars(std::vector<Triangle> triangles, std::size_t vertices);

  std::size_t TriangleCount() const { return this->Live; }
  // The number of list entries visited so far in order to remove corners.
  std::uint64_t Steps() const { return this->Passed; }
  // How many triangles a vertex has.
  std::uint32_t Degree(VertexId v) const { return this->Degrees[v]; }
  // Calls visit(side) for each triangle of a vertex.
  template <class Visit>
  void ForEachSide(VertexId v, const Visit& visit) const;
  // Whether test(side) is true for any triangle of a vertex; stops at the first.
  template <class Test>
  bool AnySide(VertexId v, const Test& test) const;
  // Finds the triangles around both ends of an edge. O(triangles of both).
  void Gather(VertexId u, VertexId v, EdgeStar& star) const;
  // Moves v's triangles to u; removes those that have both u and v. star: from Gather. Calls
  // loose(vertex) for each vertex other than v that has lost its last triangle. O(triangles of u,
  // of v, and of the vertices that face the edge, at most manyTriangles of each).
  template <class Loose>
  void Merge(VertexId u, VertexId v, const EdgeStar& star, const Loose& loose);

private:
  static constexpr Corner none = std::numeric_limits<Corner>::max();
  // A vertex with more triangles than this keeps removed triangles in its list, with three equal
  // corners. Otherwise the hub of a large fan would have to search its whole list for each removed
  // triangle.
  static constexpr std::uint32_t manyTriangles = 1024;

  StarSide SideAt(Corner corner) const;
  static bool IsGone(const StarSide& side) { return side.first == side.second; }
  void Unlink(VertexId v, Corner corner);
  void DropGone(VertexId v);

  std::vector<Triangle> Triangles;
  std::vector<Corner> First; // of each vertex
  std::vector<Corner> Next;  // of each corner
  std::vector<std::uint32_t> Degrees;
  std::size_t Live;
  std::uint64_t Passed = 0;
};

inline StarSide VertexStars::SideAt(Corner corner) const
{
  const Triangle& triangle = this->Triangles[corner / 3];
  const std::uint32_t place = corner % 3;
  return { triangle[place == 2 ? 0 : place + 1], triangle[place == 0 ? 2 : place - 1], corner };
}

template <class Visit>
void VertexStars::ForEachSide(VertexId v, const Visit& visit) const
{
  this->AnySide(v,
    [&](const StarSide& side)
    {
      visit(side);
      return false;
    });
}

template <class Test>
bool VertexStars::AnySide(VertexId v, const Test& test) const
{
  for (Corner corner = this->First[v]; corner != none; corner = this->Next[corner])
  {
    const StarSide side = this->SideAt(corner);
    if (!IsGone(side) && test(side))
    {
      return true;
    }
  }
  return false;
}

template <class Loose>
void VertexStars::Merge(VertexId u, VertexId v, const EdgeStar& star, const Loose& loose)
{
  Corner* end = &this->First[u];
  for (std::size_t i = 0; i < star.sides.size(); ++i)
  {
    const Corner corner = star.sides[i].corner;
    this->Triangles[corner / 3][corner % 3] = u;
    *end = corner;
    end = &this->Next[corner];
  }
  *end = none;
  this->First[v] = none;
  this->Degrees[u] = static_cast<std::uint32_t>(star.sides.size());
  this->Degrees[v] = 0;
  this->Live -= star.facing.size();
  for (const EdgeStar::Facing& facing : star.facing)
  {
    this->Triangles[facing.corner / 3].fill(facing.vertex);
    this->Unlink(facing.vertex, facing.corner);
    if (this->Degrees[facing.vertex] == 0)
    {
      loose(facing.vertex);
    }
  }
  if (star.sides.empty())
  {
    loose(u);
  }
}

}
