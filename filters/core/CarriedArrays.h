// SPDX-License-Identifier: BSD-3-Clause
// Makes the arrays of a coarser mesh from those of a finer one: any number of arrays, of points and
// of cells. The levels in a store carry fewer arrays, made in another way
// (levels/LevelAttributes.h).
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
// finite values gets NaN, or 0 in integers. groupOf: the group of each tuple; noVertex if it is in
// no group. Sums are in double, in the order of the tuples. Time: O(values). Memory beside the
// result: 16 bytes a group, 64 for classes. REQUIRES: all arrays have the same number of tuples.
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
// belong to each. A finer triangle belongs to its image. If its image is not a triangle of the
// coarser mesh, it belongs to the coarser triangle that contains most of the clusters of its
// points. Among several of these the one with the nearest centre is taken; among equally near ones,
// the first. A coarser triangle to which no finer one belongs gets the tuple of the first finer
// triangle that has a point in its first cluster. clusterOf: the coarser point of each point of
// `mesh`. arrays: one tuple for each triangle of `mesh`. O(t log t); if a triangle shrinks to a
// point, also linear in the number of triangles at that point.
std::vector<Attribute> CarryCells(std::span<const Attribute> arrays, const Mesh& mesh,
  std::span<const VertexId> clusterOf, const CoarserSurface& coarser,
  const Execution& execution = {});

}
