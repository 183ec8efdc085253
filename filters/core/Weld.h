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

// For each point the lowest id of a point in the same place (itself where there is none lower).
// Expected O(n); memory 12 bytes a point. REQUIRES: finite coordinates.
std::vector<VertexId> FirstCoincident(
  std::span<const Vec3> points, Coincidence coincidence, const Execution& execution = {});

// In how many different places points are; placeOf(v) is that of point v < count, and may be called
// by several threads. As ValueEqual. Expected O(count); memory 12 bytes a point.
std::size_t CountPlaces(
  std::size_t count, const std::function<Vec3(VertexId)>& placeOf, const Execution& execution = {});

// Joins vertices with bit-equal coordinates and bit-equal tuples of every point array to the lowest
// id (doc/design.md#welding) and renumbers the rest, keeping their order. Triangles keep their
// order and orientation; those that become degenerate stay. Returns how many vertices went.
// newIds, where it is not null: of each vertex the one that it became. Expected O(n).
std::size_t WeldVertices(
  Mesh& mesh, const Execution& execution = {}, std::vector<VertexId>* newIds = nullptr);

// The box of all points. O(n).
Box BoxOfPoints(std::span<const Vec3> points);

}
