// SPDX-License-Identifier: BSD-3-Clause
// Finds out which points of a mesh's parts are the same point: by global ids, or by place. No VTK
// here.
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
  std::vector<Vec3> places;      // must be finite
  std::vector<VertexId> first;   // first point of each part, and the number of all points
  std::vector<bool> isCopy;      // whether it is a ghost: a point of another part
  std::vector<bool> isPresent;   // all other points are dropped
  std::vector<std::int64_t> ids; // global ids; empty if a part has no ids
  std::optional<Box> box;        // of the whole mesh, if these are only some of its points
  // A hash of a point's values in all arrays.
  std::function<std::uint64_t(VertexId)> hashOfArrays;
};

struct MergedPoints
{
  std::vector<VertexId> kept;    // the points that stay, in their new order
  std::vector<VertexId> becomes; // for each point its new number; noVertex: dropped
  bool byIds = false;            // whether global ids were present and plausible
};

// The square of the greatest distance between points with the same global id: 2^-20 of the diagonal
// of the box of all points. If points with one id are further apart, the ids are not taken for ids
// of points.
double MostApart(const Box& box);

// With global ids: points with the same id become the first of them that is not a copy, or the
// first copy; points are in the order of ids. If points with one id are further apart than
// MostApart, ids are ignored.
//
// By place: a copy becomes the point that it is a copy of. This is a point in the same place with
// the same values in its arrays; if there is none, the first point of another part. If there is no
// such point either, the first copy stays. With `weldByPlace` points of different parts become one
// in the same way, whether they are copies or not. The order is that of the input. Copies in one
// part with the same values stay separate if the points in the same place do.
//
// Expected O(n + s log s) for s sorted points: with ids or weldByPlace all points, otherwise copies
// and the points in the same places. Memory: 8 bytes a point, and 12 or 28 for each sorted point.
MergedPoints MergePoints(const PartPoints& points, bool weldByPlace);

}
