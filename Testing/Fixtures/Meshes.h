// SPDX-License-Identifier: BSD-3-Clause
// Meshes for tests: closed surfaces, and inputs that break simple code. All are generated, seeded
// if they are random, and the same on every machine.
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

// A sphere of 10 × 4^subdivisions + 2 vertices, with a radius that varies, so that no two parts
// look the same. Closed.
Mesh DisplacedSphere(unsigned subdivisions, const Vec3& centre = {}, double radius = 1);
// Closed.
Mesh Torus(unsigned around, unsigned through);
// A sphere inside a sphere: two closed surfaces that clustering only by cells would join.
Mesh NestedSpheres(unsigned subdivisions);
// A closed plate, `side` × `side` quads above and below, a thousandth as thick as wide.
Mesh ThinPlate(unsigned side);
// An open plate in the plane z = 0.1, coordinates on a grid: most of them equal.
Mesh GridPlate(unsigned side);
// Random triangles that share no vertex.
Mesh Soup(unsigned triangles, std::uint32_t seed);
// An open height field of side × side quads, with waves of two lengths.
Mesh HeightField(unsigned side);
// Each triangle with its own vertices: with welding, the mesh with shared vertices; without it, a
// soup of coincident vertices.
Mesh Unwelded(const Mesh& shared);
// Small closed bodies, in which no edge can collapse.
Mesh Tetrahedra(unsigned count);
// Points on a displaced sphere without triangles.
Mesh Cloud(unsigned subdivisions);
// Vertices in random order, triangles too: the same surface.
Mesh Shuffled(const Mesh& mesh, std::uint32_t seed);

// Closed and consistently oriented.
std::vector<NamedMesh> ClosedMeshes();
// Other inputs that must work: equal coordinates, one vertex, no faces, non-manifold edges,
// isolated vertices, duplicate and degenerate faces, coincident vertices, huge offsets, doubles.
std::vector<NamedMesh> HardMeshes();
// Both.
std::vector<NamedMesh> AllMeshes();

}
