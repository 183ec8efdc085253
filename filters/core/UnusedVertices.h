// SPDX-License-Identifier: BSD-3-Clause
// Vertices that no triangle uses. They are taken out of a mesh after step "weld" of the pipeline
// picture, and have no effect on later steps (doc/design.md#unused-vertices).
#pragma once

#include "filters/core/Types.h"

#include <vector>

namespace kdstream
{

// For each vertex whether a triangle, also a degenerate one, uses it. In a mesh without triangles,
// a cloud, all count as used. A bit a vertex. O(size).
std::vector<bool> FindUsedVertices(const Mesh& mesh);

// Takes the unused vertices out of the mesh, and renumbers the rest in the same order. Returns the
// unused ones in their order, with their tuples, as a mesh without triangles. O(size); memory: 4
// bytes a vertex and the result. REQUIRES: isUsed is that of this mesh (FindUsedVertices), or has
// more vertices set.
Mesh TakeUnusedVertices(Mesh& mesh, const std::vector<bool>& isUsed);

}
