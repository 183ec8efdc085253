// Coincident vertices: finding and joining them. Step "weld" of the README's picture.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Types.h"

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
// Expected O(n); memory 4 to 8 bytes a point. REQUIRES: finite coordinates.
std::vector<VertexId> FirstCoincident(std::span<const Vec3> points, Coincidence coincidence);

// Joins vertices with bit-equal coordinates and bit-equal tuples of every point array to the lowest
// id (DESIGN section 4) and renumbers the rest, keeping their order. Triangles keep their order and
// orientation; those that become degenerate stay. Returns how many vertices went. Expected O(n).
std::size_t WeldVertices(Mesh& mesh);

// The box of all points. O(n).
Box BoxOfPoints(std::span<const Vec3> points);

}
