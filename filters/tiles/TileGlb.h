// SPDX-License-Identifier: BSD-3-Clause
// A tile as the bytes of a .glb, small for the network.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/tiles/TileMesh.h"

#include <array>
#include <string>
#include <string_view>

namespace kdstream
{

enum class TileCompression
{
  None,    // floats, no extension but that of WebP
  Meshopt, // EXT_meshopt_compression of KHR_mesh_quantization
  Draco    // KHR_draco_mesh_compression; points as None
};

// How far a place may be rounded where there is no lattice: of the longest side of what is encoded.
inline constexpr double mostTileRounding = 1.0 / 65534;
// The most steps of a lattice that a mesh may be long: floats hold their numbers exactly, and so
// does what Draco makes of them.
inline constexpr double mostLatticeSteps = (1U << 23U) - 64;

// Whether libmeshoptimizer and libdraco were there when this was built.
bool HasMeshoptCompression();
bool HasDracoCompression();

// How a tile stands in its file, and whose it is.
struct TileFrame
{
  // The model's directions that are x, y and z in the file, each of length 1 and across the others.
  std::array<Vec3, 3> axes{ Vec3{ 1, 0, 0 }, Vec3{ 0, 1, 0 }, Vec3{ 0, 0, 1 } };
  Vec3 origin{};    // the model's point that lies at the file's
  double scale = 1; // metres of the model's unit
  // The points that coordinates lie on: whole steps from one of them. 0: anywhere.
  double latticeStep = 0;
  Vec3 latticeOrigin{};
  // Of a finer lattice on which `origin` lies, too: latticeStep is a multiple. Then meshes beside
  // each other have their common vertices in the same places, bit for bit. 0: there is none.
  double finestStep = 0;
  std::string copyright; // empty: none is written
};

// Triangles and skirts are primitives of their own; the second has "extras": { "skirt": true }.
//
// Meshopt: positions are whole numbers of 16 bits, or where the mesh is longer than 65535 steps of
// the frame's lattice floats that hold whole numbers of 23 bits (as compressed ones, three bytes
// each). So they are the points of the lattice, and meshes beside each other meet. A frame without
// a finest step: 16 bits, of every 2nd, 4th … point if need be. Without a lattice the longest side
// is divided. Normals are bytes, colours (linear, as the format has them) and texture coordinates
// 16 bits. Draco: the same positions; normals of 8 bits, texture coordinates of 14; a primitive has
// its own vertices. Arrays are floats, of property attributes by EXT_structural_metadata. None:
// floats, differences to the middle of the mesh. Large coordinates stand only in the node's matrix,
// which has doubles. Deterministic. Errors: LimitExceeded beyond 4 GB; Unsupported where the
// library is not there. REQUIRES: points; with a finest step, no more than mostLatticeSteps from
// one to another (what skirts reach beyond is cut off).
Result<std::string> EncodeTileGlb(
  const TileMesh& mesh, const TileFrame& frame, TileCompression compression);

}
