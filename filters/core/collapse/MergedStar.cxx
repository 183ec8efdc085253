// SPDX-License-Identifier: BSD-3-Clause
// The triangles around a merged vertex, two at a time: see MergedStar.h.
#include "filters/core/collapse/MergedStar.h"

#include "filters/core/TriangleDistance.h"
#include "filters/core/VectorMath.h"

#include <algorithm>
#include <limits>

namespace kdstream
{
namespace
{

constexpr double flipCosine = 0.2; // a normal may turn by 78°

using LanePoint = std::array<Lanes, 3>;

LanePoint Both(const Vec3& first, const Vec3& second)
{
  return { Lanes(first[0], second[0]), Lanes(first[1], second[1]), Lanes(first[2], second[2]) };
}

LanePoint Both(const Vec3& p)
{
  return { p[0], p[1], p[2] };
}

// The squared length of the longest side of the triangles on the edge from u to v.
double LongestSide(std::span<const Vec3> positions, const EdgeStar& star, VertexId u, VertexId v)
{
  const auto squaredLength = [&](VertexId from, VertexId to)
  { return SquaredDistance(positions[from], positions[to]); };
  double longest = std::max(0.0, squaredLength(u, v));
  for (const EdgeStar::Facing& facing : star.facing)
  {
    longest =
      std::max({ longest, squaredLength(u, facing.vertex), squaredLength(v, facing.vertex) });
  }
  return longest;
}

}

bool MergedStar::TurnsNormal(const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& to)
{
  const Vec3 before = Cross(kdstream::Minus(q, p), kdstream::Minus(r, p));
  const Vec3 after = Cross(kdstream::Minus(q, to), kdstream::Minus(r, to));
  const double squaredBefore = Dot(before, before), cosine = Dot(before, after); // × both lengths
  const bool keeps =
    cosine > 0 && cosine * cosine > flipCosine * flipCosine * squaredBefore * Dot(after, after);
  return squaredBefore > 0 && !keeps;
}

void MergedStar::Set(std::span<const Vec3> positions, const EdgeStar& star, VertexId u, VertexId v,
  const Vec3& position)
{
  const std::size_t sides = star.sides.size();
  const LanePoint to = Both(position);
  this->Position = position;
  this->Turns = false;
  this->Pairs.resize((sides + 1) / 2);
  for (std::size_t i = 0; i < sides; i += 2)
  {
    const std::size_t j = std::min(i + 1, sides - 1);
    const StarSide &one = star.sides[i], &other = star.sides[j];
    const LanePoint p = Both(positions[i < star.ofU ? u : v], positions[j < star.ofU ? u : v]);
    const LanePoint q = Both(positions[one.first], positions[other.first]);
    const LanePoint r = Both(positions[one.second], positions[other.second]);
    Pair& pair = this->Pairs[i / 2];
    pair.a = Minus(q, to);
    pair.b = Minus(r, to);
    pair.aa = Dot(pair.a, pair.a);
    pair.ab = Dot(pair.a, pair.b);
    pair.bb = Dot(pair.b, pair.b);
    pair.determinant = pair.aa * pair.bb - pair.ab * pair.ab;
    const LanePoint before = Cross(Minus(q, p), Minus(r, p)), after = Cross(pair.a, pair.b);
    const Lanes squaredBefore = Dot(before, before);
    const Lanes cosine = Dot(before, after); // × both lengths
    const LaneMask hasNormal = squaredBefore > 0.0;
    const LaneMask keeps = (cosine > 0.0) & (cosine * cosine > flipCosine * flipCosine *
                                                                 squaredBefore * Dot(after, after));
    this->Turns |= AndNot(hasNormal, keeps).Any();
  }
}

// Considers only triangles whose inside contains the projection of p. In each lane: the squared
// distance of p to the nearest plane of these triangles; infinity if there are none.
Lanes MergedStar::SquaredToInsides(const Vec3& p) const
{
  const LanePoint w = Both(kdstream::Minus(p, this->Position));
  Lanes nearest = std::numeric_limits<double>::infinity();
  for (const Pair& pair : this->Pairs)
  {
    const Lanes wa = Dot(w, pair.a), wb = Dot(w, pair.b);
    const Lanes s = (pair.bb * wa - pair.ab * wb) / pair.determinant;
    const Lanes t = (pair.aa * wb - pair.ab * wa) / pair.determinant;
    const LanePoint d{ w[0] - s * pair.a[0] - t * pair.b[0], w[1] - s * pair.a[1] - t * pair.b[1],
      w[2] - s * pair.a[2] - t * pair.b[2] };
    const Lanes squared = Dot(d, d);
    const LaneMask inside = (pair.determinant > 0.0) & (s >= 0.0) & (t >= 0.0) & (s + t <= 1.0);
    nearest = Select(inside & (squared < nearest), squared, nearest);
  }
  return nearest;
}

// The squared distance of p to the nearest triangle, at most `least`.
double MergedStar::SquaredToTriangles(
  const Vec3& p, std::span<const Vec3> positions, const EdgeStar& star, double least) const
{
  for (const StarSide& side : star.sides)
  {
    least = std::min(
      least, SquaredToTriangle(p, this->Position, positions[side.first], positions[side.second]));
  }
  return least;
}

// Whether a vertex has certainly the distance 0, because it is a corner of one of the triangles.
bool MergedStar::IsOnSide(const EdgeStar& star, VertexId w) const
{
  for (std::size_t i = 0; i < star.sides.size(); ++i)
  {
    if (star.sides[i].first == w || star.sides[i].second == w)
    {
      const double determinant = this->Pairs[i / 2].determinant[i % 2];
      return determinant - determinant == 0; // not where numbers overflow
    }
  }
  return false;
}

double MergedStar::SquaredRetreat(std::span<const Vec3> positions, const EdgeStar& star, VertexId u,
  VertexId v, double scale, double enough) const
{
  const double longest = LongestSide(positions, star, u, v);
  double farthest = 0;
  const auto measure = [&](VertexId from)
  {
    const Vec3& p = positions[from];
    const Lanes insides = this->SquaredToInsides(p);
    double nearest = std::min({ longest, insides[0], insides[1] });
    // If a triangle is near enough, or nearer than the farthest distance so far, the result does
    // not change.
    if (nearest > farthest && scale * nearest > enough)
    {
      nearest = this->SquaredToTriangles(p, positions, star, nearest);
    }
    farthest = std::max(farthest, nearest);
  };
  measure(u);
  measure(v);
  for (const EdgeStar::Facing& facing : star.facing)
  {
    if (!this->IsOnSide(star, facing.vertex))
    {
      measure(facing.vertex);
    }
  }
  return farthest;
}

}
