// SPDX-License-Identifier: BSD-3-Clause
// Which side of a point cloud's tangent planes is outside.
#pragma once

#include "filters/core/Types.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// Turns normals so that neighbours agree. From the normals that are known, or in a part of the
// graph without any from its highest point (greatest z), whose normal is turned upwards, the way
// goes on always over the edge whose normals are the most parallel (Hoppe et al., Surface
// Reconstruction from Unorganized Points, 1992, section 3.3: the minimum spanning tree of 1 -
// |n·n'|). points, normals, known: one a point; `known` normals are not turned. neighbors: k ids a
// point, in any order, their own point among them or not; edges go both ways. Ties go to the lowest
// id. O(n k log(n k)); memory about 8 n k bytes and the queue. REQUIRES: unit normals, or zero for
// points without one; ids below n.
void OrientNormals(std::span<const Vec3> points, std::span<const std::uint8_t> known,
  std::span<const VertexId> neighbors, std::size_t k, std::span<Vec3> normals);

}
