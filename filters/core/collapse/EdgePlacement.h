// SPDX-License-Identifier: BSD-3-Clause
// Where to put the vertex to which an edge collapses, and what the collapse costs. Only for
// EdgeCollapse.
//
// Source: Garland and Heckbert 1997; the choice between the edge and the place beside it is ours.
#pragma once

#include "filters/core/Lanes.h"
#include "filters/core/TriangleDistance.h"
#include "filters/core/Types.h"
#include "filters/core/VectorMath.h"
#include "filters/core/collapse/Quadric.h"

#include <array>

namespace kdstream
{

// Puts two quadrics side by side, one in each lane.
inline QuadraticForm<Lanes> SideBySide(const Quadric& first, const Quadric& second)
{
  QuadraticForm<Lanes> both;
  for (std::size_t k = 0; k < 6; ++k)
  {
    both.a[k] = Lanes(first.a[k], second.a[k]);
  }
  for (std::size_t k = 0; k < 3; ++k)
  {
    both.b[k] = Lanes(first.b[k], second.b[k]);
  }
  both.c = Lanes(first.c, second.c);
  return both;
}

// One edge, or two if Real is Lanes. Positions are relative to the origin of the quadrics.
template <class Real>
struct EdgeToPlace
{
  std::array<Real, 3> a, b;    // its ends
  QuadraticForm<Real> quadric; // the sum of the ends' quadrics
  Real beside;                 // a place beside the edge needs less than this share of its error
};

template <class Real>
struct PlacedVertex
{
  std::array<Real, 3> position;
  Real cost;
};

template <class Real>
Real Squared(const std::array<Real, 3>& d)
{
  return Dot(d, d);
}

template <class Real, class Mask>
std::array<Real, 3> Select(Mask mask, const std::array<Real, 3>& yes, const std::array<Real, 3>& no)
{
  return { Select(mask, yes[0], no[0]), Select(mask, yes[1], no[1]), Select(mask, yes[2], no[2]) };
}

// The best place on the edge itself.
template <class Real>
PlacedVertex<Real> PlaceOnEdge(const EdgeToPlace<Real>& edge, const std::array<Real, 3>& middle)
{
  const std::array<Real, 3>&a = edge.a, &b = edge.b;
  // A parabola through the errors at the ends and in the middle.
  const Real atA = edge.quadric.At(a), atB = edge.quadric.At(b), atMiddle = edge.quadric.At(middle);
  const Real curvature = atA + atB - 2 * atMiddle;
  const Real t = Select(curvature > Real(0), 0.5 + (atA - atB) / (4 * curvature), Real(0.5));
  const std::array<Real, 3> best = Select(And(t > Real(0), t < Real(1)),
    std::array<Real, 3>{
      a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2]) },
    middle);
  const Real least = edge.quadric.At(best);
  const auto between = And(least < atA, least < atB);
  const auto first = atA <= atB;
  return { Select(between, best, Select(first, a, b)),
    Select(between, least, Select(first, atA, atB)) };
}

// Where to put the merged vertex: the best place on the edge, or the place beside the edge with the
// least quadric, if that is better. The place is inside `bounds`, and at most two edge lengths from
// the middle of the edge. Without branches, because the lanes may differ.
template <class Real>
PlacedVertex<Real> PlaceVertex(const EdgeToPlace<Real>& edge, const Box& bounds)
{
  constexpr double regularisation = 1e-3; // of the quadric's trace; measured in the prototype
  constexpr double reach = 2; // largest distance from the edge's middle, in edge lengths
  const std::array<Real, 3>&a = edge.a, &b = edge.b;
  const std::array<Real, 3> middle{ (a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2 };
  const PlacedVertex<Real> on = PlaceOnEdge(edge, middle);
  std::array<Real, 3> least = edge.quadric.Minimum(middle, regularisation);
  for (std::size_t k = 0; k < 3; ++k)
  {
    const Real lo = bounds.lo[k], hi = bounds.hi[k];
    least[k] = Select(least[k] < lo, lo, Select(hi < least[k], hi, least[k]));
  }
  const Real error = edge.quadric.At(least);
  const auto beside = And(Squared(Minus(least, middle)) <= reach * reach * Squared(Minus(b, a)),
    error < edge.beside * on.cost);
  return { Select(beside, least, on.position), Select(beside, error, on.cost) };
}

}
