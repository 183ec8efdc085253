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

// The number of different places among `count` points. placeOf(v): the place of point v; several
// threads may call it. Places are compared as ValueEqual. Expected O(count); memory 12 bytes a
// point.
std::size_t CountPlaces(
  std::size_t count, const std::function<Vec3(VertexId)>& placeOf, const Execution& execution = {});

// Merges vertices whose coordinates and tuples of every point array are equal bit for bit; the
// vertex with the lowest id stays (doc/design.md#welding). The remaining vertices are renumbered in
// the same order. Triangles keep their order and orientation; those that become degenerate stay.
// Returns the number of vertices removed. newIds, if not null: the new id of each vertex. Expected
// O(n).
std::size_t WeldVertices(
  Mesh& mesh, const Execution& execution = {}, std::vector<VertexId>* newIds = nullptr);

// The box of all points. O(n).
Box BoxOfPoints(std::span<const Vec3> points);

}
