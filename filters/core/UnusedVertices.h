// SPDX-License-Identifier: BSD-3-Clause
// Vertices that no triangle uses: they are taken out of a mesh after step "weld" of the pipeline
// picture, and decide nothing of what comes then (doc/design.md#unused-vertices).
#pragma once

#include "filters/core/Types.h"

#include <vector>

namespace kdstream
{

// Of each vertex whether a triangle names it, a degenerate one too; all of a mesh without
// triangles, which is a cloud. A bit a vertex. O(size).
std::vector<bool> FindUsedVertices(const Mesh& mesh);

// Takes the others out of the mesh and renumbers the rest, keeping their order. Returns them in
// their order, with their tuples, as a mesh without triangles. O(size); memory: 4 bytes a vertex
// and what is returned. REQUIRES: isUsed of this mesh (FindUsedVertices), or more
// than that.
Mesh TakeUnusedVertices(Mesh& mesh, const std::vector<bool>& isUsed);

}
