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

// Arrays for the triangles of a coarser mesh: the means (MeansOfGroups) of the finer triangles that
// belong to each. A finer triangle belongs to its image. If its image is not a coarser triangle, it
// belongs to the one with most of its points' clusters; of several, to the one with the nearest
// centre; of equals, to the first. A coarser triangle to which none belongs gets the tuple of the
// first finer triangle that has a point in its first cluster. clusterOf: the coarser point of each
// point of `mesh`. arrays: a tuple a triangle. O(t log t); where triangles vanish at a point, also
// in how many others have the point.
std::vector<Attribute> CarryCells(std::span<const Attribute> arrays, const Mesh& mesh,
  std::span<const VertexId> clusterOf, const CoarserSurface& coarser,
  const Execution& execution = {});

}
