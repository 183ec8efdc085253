// SPDX-License-Identifier: BSD-3-Clause
// Arrays of a mesh for a coarser one: any number of them, of points and of cells. What stores carry
// in their levels is less, and made as levels are (levels/LevelAttributes.h).
#pragma once

#include "filters/core/Attribute.h"
#include "filters/core/Execution.h"
#include "filters/core/Types.h"

#include <cstddef>
#include <span>
#include <vector>

namespace kdstream
{

// For each of `count` groups of tuples one: the mean of each component, over its finite values
// (integers rounded to the nearest, halves away from 0), or of arrays of one component that hold
// classes (HoldsClasses) the most frequent value (ClassVotes). Where a group has no tuples, or no
// finite value: NaN, 0 in integers. groupOf: of each tuple its group; noVertex: none. Sums are in
// double, over tuples ascending. O(values); 16 bytes a group, 64 for classes, beside the result.
// REQUIRES: as many tuples in each array.
std::vector<Attribute> MeansOfGroups(
  std::span<const Attribute> arrays, std::span<const VertexId> groupOf, std::size_t count);

// A coarser mesh: where its points are, and its triangles, each with its lowest point first,
// sorted.
struct CoarserSurface
{
  std::span<const Vec3> points;
  std::span<const Triangle> triangles;
};

// Arrays of triangles for the triangles of a coarser mesh: the means (MeansOfGroups) of those that
// belong to each. A triangle belongs to its image, or, where that is none of the coarser ones, to
// the one that has most of its points' clusters, of several the one whose centre is nearest to its
// own, of equals the first. To whom none belongs, it gets the tuple of the first triangle that has
// a point in its first cluster. clusterOf: of each point of `mesh` the coarser point. O(t log t),
// and where triangles vanish at a point in how many others have it. arrays: a tuple a triangle.
std::vector<Attribute> CarryCells(std::span<const Attribute> arrays, const Mesh& mesh,
  std::span<const VertexId> clusterOf, const CoarserSurface& coarser,
  const Execution& execution = {});

}
