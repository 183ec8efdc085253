// SPDX-License-Identifier: BSD-3-Clause
// Which side of a point cloud's tangent planes is outside.
#pragma once

#include "filters/core/Types.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// Turns normals so that neighbours agree. Starts at the known normals, or in a part of the graph
// without any at its highest point (greatest z), whose normal is turned upwards. Goes on over the
// edge with the most parallel normals (Hoppe et al., Surface Reconstruction from Unorganized
// Points, 1992, section 3.3: the minimum spanning tree of 1 - |n·n'|). Ties go to the lowest id.
//
// points, normals, known: one a point; `known` normals are not turned. neighbors: k ids a point, in
// any order, with or without the point itself; edges go both ways. O(n k log(n k)); memory about 8
// n k bytes and the queue. REQUIRES: unit normals, or zero for points without one; ids below n.
void OrientNormals(std::span<const Vec3> points, std::span<const std::uint8_t> known,
  std::span<const VertexId> neighbors, std::size_t k, std::span<Vec3> normals);

}
