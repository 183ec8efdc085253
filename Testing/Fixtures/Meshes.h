// SPDX-License-Identifier: BSD-3-Clause
// Meshes for tests: closed surfaces, and inputs that break simple code. All are generated, from a
// seed if they are random, and the same on every machine.
#pragma once

#include "filters/core/Types.h"

#include <cstdint>
#include <string>
#include <vector>

namespace kdstream::fixtures
{

struct NamedMesh
{
  std::string name;
  Mesh mesh;
};

// A closed sphere of 10 × 4^subdivisions + 2 vertices. Its radius varies, so that no two parts look
// the same.
Mesh DisplacedSphere(unsigned subdivisions, const Vec3& centre = {}, double radius = 1);
// A closed torus.
Mesh Torus(unsigned around, unsigned through);
// A sphere inside a sphere: two closed surfaces that clustering would join if it considered only
// cells.
Mesh NestedSpheres(unsigned subdivisions);
// A closed plate, `side` × `side` quads above and below, a thousandth as thick as wide.
Mesh ThinPlate(unsigned side);
// An open plate in the plane z = 0.1, with coordinates on a grid, so that most of them are equal.
Mesh GridPlate(unsigned side);
// Random triangles that share no vertex.
Mesh Soup(unsigned triangles, std::uint32_t seed);
// An open height field of side × side quads, with waves of two lengths.
Mesh HeightField(unsigned side);
// The mesh with separate vertices for each triangle. With welding this gives the mesh with shared
// vertices; without welding it is a soup of coincident vertices.
Mesh Unwelded(const Mesh& shared);
// Small closed bodies in which no edge can be collapsed.
Mesh Tetrahedra(unsigned count);
// Points on a displaced sphere, without triangles.
Mesh Cloud(unsigned subdivisions);
// Adds the points and triangles of another mesh.
void Append(Mesh& mesh, const Mesh& other);
// The same surface with its vertices and triangles in random order.
Mesh Shuffled(const Mesh& mesh, std::uint32_t seed);

// Meshes that are closed and consistently oriented.
std::vector<NamedMesh> ClosedMeshes();
// Other inputs that must work: equal coordinates, one vertex, no faces, non-manifold edges,
// isolated vertices, duplicate and degenerate faces, coincident vertices, huge offsets, doubles.
std::vector<NamedMesh> HardMeshes();
// ClosedMeshes and HardMeshes.
std::vector<NamedMesh> AllMeshes();

}
