// SPDX-License-Identifier: BSD-3-Clause
// Coincident vertices: finding and joining them. Step "weld" of the pipeline picture.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Types.h"

#include <functional>
#include <span>
#include <vector>

namespace kdstream
{

enum class Coincidence
{
  BitEqual,  // -0.0 and 0.0 differ
  ValueEqual // -0.0 and 0.0 are the same place
};

// For each point the lowest id of a point in the same place (its own if no other is lower).
// Expected O(n); memory 12 bytes a point. REQUIRES: finite coordinates.
std::vector<VertexId> FirstCoincident(
  std::span<const Vec3> points, Coincidence coincidence, const Execution& execution = {});

// The number of different places of points; placeOf(v) is the place of point v < count, and several
// threads may call it. Compares as ValueEqual. Expected O(count); memory 12 bytes a point.
std::size_t CountPlaces(
  std::size_t count, const std::function<Vec3(VertexId)>& placeOf, const Execution& execution = {});

// Merges vertices with bit-equal coordinates and bit-equal tuples of every point array into the one
// of the lowest id (doc/design.md#welding), and renumbers the rest in the same order. Triangles
// keep their order and orientation; those that become degenerate stay. Returns the number of
// vertices removed. newIds, if not null: the new id of each vertex. Expected O(n).
std::size_t WeldVertices(
  Mesh& mesh, const Execution& execution = {}, std::vector<VertexId>* newIds = nullptr);

// The box of all points. O(n).
Box BoxOfPoints(std::span<const Vec3> points);

}
