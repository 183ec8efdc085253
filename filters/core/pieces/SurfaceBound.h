// SPDX-License-Identifier: BSD-3-Clause
// How far a surface is from another one at most: what levels tell of themselves. A bound that costs
// little; MeshDistance.h samples instead.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/Types.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace kdstream
{

// A part of a surface, ready to be searched for what is nearest to a place, and to be measured:
// triangles, or points where the whole surface has no triangles.
class SearchedPart
{
public:
  // A group of triangles that follow each other, or of such groups: their box, and a ball around
  // its centre that holds them.
  struct Node
  {
    Box box;
    Vec3 centre{};
    double radius = 0;
    std::uint32_t begin = 0, end = 0; // in the level below; of the lowest level triangles
  };

  // Points without triangles are degenerate triangles: { v, v, v }. groupEnds: where groups of
  // neighbours end, ascending, up to the last triangle; first small groups, then groups of these.
  // Without them triangles are ordered, and grouped, by where they lie. O(t log t).
  SearchedPart(std::vector<Vec3> points, std::vector<Triangle> triangles,
    std::span<const std::vector<std::uint32_t>> groupEnds = {});

  // In their own order.
  std::span<const Triangle> Triangles() const { return this->Corners; }
  const Vec3& At(VertexId v) const { return this->Points[v]; }
  std::span<const std::vector<Node>> Levels() const { return this->Nodes; }
  // Of what the triangles use; empty without triangles.
  Box Bounds() const { return this->Nodes.empty() ? Box{} : this->Nodes.back().front().box; }
  // The side of a square as large as two triangles are on average.
  double Spacing() const;

  double SquaredTo(std::uint32_t triangle, const Vec3& place) const;

  static constexpr std::uint32_t none = 0xffffffffU;
  // The triangle nearest to a place, of those nearer than `squared`, which becomes its squared
  // distance; none where there is none. Or the first one that is found within `enough`, squared,
  // and a distance that it is not beyond. O(log t) on average.
  std::uint32_t Nearest(const Vec3& place, double enough, double& squared) const;

private:
  static constexpr std::size_t arity = 4;

  void AddLevel(std::vector<Node> nodes);
  template <class Visit>
  void ForEachCorner(std::uint32_t begin, std::uint32_t end, const Visit& visit) const
  {
    for (std::uint32_t i = begin; i < end; ++i)
    {
      for (const VertexId v : this->Corners[i])
      {
        visit(this->Points[v]);
      }
    }
  }
  void Search(std::size_t level, std::size_t index, const Vec3& place, double enough,
    double& squared, std::uint32_t& nearest) const;

  std::vector<Vec3> Points;
  std::vector<Triangle> Corners;
  std::vector<std::vector<Node>> Nodes; // Levels
};

// The surface that another one is measured to.
struct MeasuredSurface
{
  // Most of what is nearest is in this part.
  const SearchedPart& near;
  // Looks for what is nearer to a place in all other parts; `squared` as for Nearest.
  std::function<Status(const Vec3& place, double& squared)> lookFarther;
  // Triangles, and groups of them, are looked at as a whole if they and their distance are smaller.
  double smallest = 0;
  // For each of the lowest groups of what is measured a point of the near part's triangles that is
  // likely to be close; none where there is none. Empty: nothing is known.
  std::span<const VertexId> guesses{};
};

// How far any point of `from` is from the surface `to` at most, or `enough` if that is more. Never
// less than the largest distance; more by a sixth of it or by what `smallest` adds: up to twice
// that much. The larger of results with different `enough` is always the same, so parts may be
// measured in any order, each with the largest that is known. Complexity: the fewer searches, the
// larger `enough` and `smallest`. Errors: those of lookFarther.
Result<double> FarthestPoint(const SearchedPart& from, const MeasuredSurface& to, double enough);

}
