// SPDX-License-Identifier: BSD-3-Clause
// Vertices that no triangle uses. They are taken out of a mesh after step "weld" of the pipeline
// picture, and have no effect on later steps (doc/design.md#unused-vertices).
#pragma once

#include "filters/core/Types.h"

#include <vector>

namespace kdstream
{

// For each vertex, whether a triangle uses it, even a degenerate one. In a point cloud, which has
// no triangles, all vertices count as used. Memory: one bit a vertex. Time: O(size).
std::vector<bool> FindUsedVertices(const Mesh& mesh);

// Takes the unused vertices out of the mesh, and renumbers the rest in the same order. Returns the
// unused ones in their order, with their tuples, as a mesh without triangles. O(size); memory: 4
// bytes a vertex and the result. REQUIRES: isUsed is FindUsedVertices(mesh), possibly with further
// vertices marked as used.
Mesh TakeUnusedVertices(Mesh& mesh, const std::vector<bool>& isUsed);

}
