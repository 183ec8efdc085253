// SPDX-License-Identifier: BSD-3-Clause
// Vertices that no triangle uses: they are taken out of a mesh behind step "weld" of the README's
// picture, and decide nothing of what comes then (doc/design.md#unused-vertices).
#pragma once

#include "filters/core/Types.h"

#include <vector>

namespace kdstream
{

// Whether it joins three vertices; else it is degenerate.
constexpr bool JoinsThree(const Triangle& t)
{
  return t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
}

// Of each vertex whether a triangle names it that joins three. Where none does, those that the
// degenerate ones name are used; of a mesh without triangles, which is a cloud, all are. A bit a
// vertex. O(size).
std::vector<bool> FindUsedVertices(const Mesh& mesh);

// Takes the others out of the mesh and renumbers the rest, keeping their order. A corner of a
// degenerate triangle that is taken out becomes the next vertex, behind the last the last: the
// triangle stays degenerate. Returns those that are not used in their order, with their tuples, as
// a mesh without triangles. O(size); memory: 4 bytes a vertex and what is returned. REQUIRES:
// isUsed of this mesh (FindUsedVertices).
Mesh TakeUnusedVertices(Mesh& mesh, const std::vector<bool>& isUsed);

}
