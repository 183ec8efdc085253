// SPDX-License-Identifier: BSD-3-Clause
// Attributes for the meshes of tests: every type, every association, and names that are difficult
// for formats.
#pragma once

#include "filters/core/Types.h"

#include <cstdint>
#include <string>
#include <vector>

namespace kdstream::fixtures
{

// Adds attributes to the mesh: Normals, RGB or RGBA, TCoords, one array of each type for points and
// for cells (1-4 components), and arrays whose names look like something else. Values are random
// bits, including NaNs, infinities and negative zeros; a few vertices are equal in all arrays.
// Point arrays come first. The result depends only on the mesh and the seed, on every machine.
Mesh WithAttributes(Mesh mesh, std::uint32_t seed);

// The content of a mesh, independent of the order of its vertices and triangles. For every vertex:
// the bits of its coordinates and tuples. For every triangle: those of its corners (in the lowest
// rotation) and its tuples. Sorted.
struct MeshContent
{
  std::vector<std::string> vertices, triangles;
  bool operator==(const MeshContent&) const = default;
};
MeshContent ContentOf(const Mesh& mesh);

std::vector<AttributeInfo> InfosOf(const std::vector<Attribute>& attributes);

// The bytes of one tuple of an array.
std::vector<std::uint8_t> TupleOf(const Attribute& attribute, std::size_t tuple);

}
