// SPDX-License-Identifier: BSD-3-Clause
// Which points of a mesh's parts are one point: by global ids, or by place. No VTK here.
#pragma once

#include "filters/core/Types.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace kdstream
{

// The points of all parts, one part after the other.
struct PartPoints
{
  std::vector<Vec3> places;      // finite
  std::vector<VertexId> first;   // of each part its first point; then the number of all
  std::vector<bool> isCopy;      // a ghost: another part's point
  std::vector<bool> isPresent;   // all other points are dropped
  std::vector<std::int64_t> ids; // global ids; empty if a part has no ids
  std::optional<Box> box;        // of the whole mesh, if these are only some of its points
  // A hash of the values that a point has in all arrays.
  std::function<std::uint64_t(VertexId)> hashOfArrays;
};

struct MergedPoints
{
  std::vector<VertexId> kept;    // which points stay, in their new order
  std::vector<VertexId> becomes; // for each point its new number; noVertex: dropped
  bool byIds = false;            // global ids were present and plausible
};

// The square of the greatest distance of points of the same global id: 2^-20 of the diagonal of the
// box of all points. Ids of points further apart are not taken for ids of points.
double MostApart(const Box& box);

// With global ids: points of one id become the first of them that is not a copy, or the first copy;
// points are in the order of ids. If an id stands for places that are further apart than MostApart,
// ids are ignored.
//
// By place: a copy becomes the point that it is a copy of: the one with the same values in its
// arrays, or else the first of another part. Without such a point the first copy stays. With
// `weldByPlace` points of different parts become one in the same way, copies or not. The order is
// that of the input. Copies of one part with the same values stay apart if the points in the same
// place do.
//
// Expected O(n + s log s) for s sorted points: these are copies and the points in the same places,
// or, with ids or weldByPlace, all points. Memory: 8 bytes a point, and 12 or 28 a sorted point.
MergedPoints MergePoints(const PartPoints& points, bool weldByPlace);

}
