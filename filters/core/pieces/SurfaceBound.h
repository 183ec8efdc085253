// SPDX-License-Identifier: BSD-3-Clause
// How far a surface is from another one at most: what levels tell of themselves. A bound that costs
// little; MeshDistance.h samples instead.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/Types.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

namespace kdstream
{

// A part of a surface, ready to be searched for what is nearest to a place: triangles, or points
// where the whole surface has no triangles.
class SearchedPart
{
public:
  // Points without triangles are degenerate triangles: { v, v, v }. Searches are fast where
  // triangles that follow each other are neighbours, as in pieces. O(t).
  SearchedPart(std::vector<Vec3> points, std::vector<Triangle> triangles);

  std::span<const Triangle> Triangles() const { return this->Corners; }
  const Vec3& At(VertexId v) const { return this->Points[v]; }
  // The side of a square as large as two triangles are on average.
  double Spacing() const;

  double SquaredTo(std::uint32_t triangle, const Vec3& place) const;

  static constexpr std::uint32_t none = 0xffffffffU;
  // The triangle nearest to a place, of those nearer than `squared`, which becomes its squared
  // distance; none where there is none. Or the first one that is found within `enough`, squared,
  // and a distance that it is not beyond. O(log t) on average.
  std::uint32_t Nearest(const Vec3& place, double enough, double& squared) const;

private:
  void Search(std::size_t level, std::size_t index, const Vec3& place, double enough,
    double& squared, std::uint32_t& nearest) const;

  std::vector<Vec3> Points;
  std::vector<Triangle> Corners;
  std::vector<std::vector<Box>> Boxes; // of groups of triangles, then of groups of these; one last
};

// A part of a surface, ready to be measured: balls around the vertices of clusters, each of which
// holds its triangles, and balls around neighbours' balls.
class MeasuredPart
{
public:
  struct Ball
  {
    Vec3 centre{};
    double radius = -1; // below zero: nothing is in it
  };

  // triangles: remain the caller's, who keeps them; points without are degenerate ones. ballOf:
  // which ball each point belongs to. A triangle is in the lowest of its corners' balls; in none
  // where that is below zero or beyond the last. centres: of the balls; neighbours follow each
  // other. O(t).
  MeasuredPart(std::vector<Vec3> points, std::span<const Triangle> triangles,
    std::vector<std::int32_t> ballOf, std::span<const Vec3> centres);

  // The balls, then those around groups of them; a single one last. Empty without triangles.
  std::span<const std::vector<Ball>> Levels() const { return this->Balls; }
  // Of the balls below that a ball is around: the first, and the last's next.
  std::pair<std::size_t, std::size_t> GroupOf(std::size_t level, std::size_t index) const;
  // In one of the lowest balls. The first call takes O(t): mostly none is made.
  std::span<const Triangle> TrianglesOf(std::size_t ball);
  const Vec3& At(VertexId v) const { return this->Points[v]; }

private:
  std::size_t BallOf(const Triangle& t) const
  {
    return static_cast<std::size_t>(
      std::min({ this->BallOfPoint[t[0]], this->BallOfPoint[t[1]], this->BallOfPoint[t[2]] }));
  }
  Ball BallAround(std::size_t level, std::size_t index) const;

  std::vector<Vec3> Points;
  std::span<const Triangle> Triangles;
  std::vector<std::int32_t> BallOfPoint;
  std::vector<std::vector<Ball>> Balls; // Levels
  std::vector<Triangle> Ordered;        // ball after ball, once they are asked for
  std::vector<std::uint32_t> Begin;     // of each ball, and the end
};

// The surface that another one is measured to.
struct LevelSurface
{
  // Most of what is nearest is in this part.
  const SearchedPart& near;
  // Looks for what is nearer to a place in all other parts; `squared` as for Nearest.
  std::function<Status(const Vec3& place, double& squared)> lookFarther;
  // A ball is looked at as a whole if it and its distance are smaller; one around others, if it is
  // smaller than this.
  double smallest = 0, smallestGroup = 0;
  // For each of the lowest balls of what is measured a point of the near part's triangles that is
  // likely to be close; none where there is none. Empty: nothing is known.
  std::span<const VertexId> guesses{};
};

// How far any point of `from` is from the surface `to` at most, or `enough` if that is more. Never
// less than the largest distance; more by a sixth of it or by what `smallest` adds: up to twice
// that much. The larger of results with different `enough` is always the same, so parts may be
// measured in any order, each with the largest that is known. Complexity: the fewer searches, the
// larger `enough` and `smallest`. Errors: those of lookFarther.
Result<double> FarthestPoint(MeasuredPart& from, const LevelSurface& to, double enough);

}
