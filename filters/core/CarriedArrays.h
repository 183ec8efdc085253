// SPDX-License-Identifier: BSD-3-Clause
// Makes the arrays of a coarser mesh from those of a finer one: any number of arrays, of points and
// of cells. Levels of stores carry fewer, made in another way (levels/LevelAttributes.h).
#pragma once

#include "filters/core/Attribute.h"
#include "filters/core/Execution.h"
#include "filters/core/Types.h"

#include <cstddef>
#include <span>
#include <vector>

namespace kdstream
{

// Gives one tuple for each of `count` groups of tuples: the mean of each component over its finite
// values (integers rounded to the nearest, halves away from 0). An array of one component that
// holds classes (HoldsClasses) gets the most frequent value (ClassVotes). A group without tuples or
// finite values gets NaN, or 0 in integers. groupOf: the group of each tuple, or noVertex. Sums are
// in double, over tuples ascending. O(values); 16 bytes a group, 64 for classes, beside the result.
// REQUIRES: as many tuples in each array.
std::vector<Attribute> MeansOfGroups(
  std::span<const Attribute> arrays, std::span<const VertexId> groupOf, std::size_t count);

// A coarser mesh: the positions of its points, and its triangles, sorted, each with its lowest
// point first.
struct CoarserSurface
{
  std::span<const Vec3> points;
  std::span<const Triangle> triangles;
};

// Arrays for the triangles of a coarser mesh: the means (MeansOfGroups) of the finer triangles that
// belong to each. A finer triangle belongs to its image. If its image is not a coarser triangle, it
// belongs to the coarser triangle that has the most of its points' clusters; among several, to the
// one with the nearest centre; among equals, to the first. A coarser triangle to which none belongs
// gets the tuple of the first finer triangle that has a point in its first cluster. clusterOf: the
// coarser point of each point of `mesh`. arrays: a tuple a triangle. O(t log t); where a triangle
// becomes a point, also linear in the number of triangles at the point.
std::vector<Attribute> CarryCells(std::span<const Attribute> arrays, const Mesh& mesh,
  std::span<const VertexId> clusterOf, const CoarserSurface& coarser,
  const Execution& execution = {});

}
