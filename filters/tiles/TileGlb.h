// SPDX-License-Identifier: BSD-3-Clause
// Encodes a tile as the bytes of a .glb, small for the network.
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
  None,    // floats, no extension except for WebP
  Meshopt, // EXT_meshopt_compression and KHR_mesh_quantization
  Draco    // KHR_draco_mesh_compression; points as None
};

// How far a position may be rounded if there is no lattice, as a part of the longest side of the
// encoded mesh.
inline constexpr double mostTileRounding = 1.0 / 65534;
// The maximum length of a mesh in steps of a lattice: up to this, floats and Draco store the
// numbers exactly.
inline constexpr double mostLatticeSteps = (1U << 23U) - 64;

// Whether libmeshoptimizer and libdraco were available when this was built.
bool HasMeshoptCompression();
bool HasDracoCompression();

// How a tile is placed in its file, and who owns the copyright.
struct TileFrame
{
  // The directions in the model that become x, y and z in the file; each has length 1, and they are
  // orthogonal.
  std::array<Vec3, 3> axes{ Vec3{ 1, 0, 0 }, Vec3{ 0, 1, 0 }, Vec3{ 0, 0, 1 } };
  Vec3 origin{};    // the point of the model that becomes the origin of the file
  double scale = 1; // length of the model's unit in metres
  // The lattice that coordinates are on: points at whole steps from latticeOrigin. 0: anywhere.
  double latticeStep = 0;
  Vec3 latticeOrigin{};
  // The step of a finer lattice, which `origin` is on, too; latticeStep is a multiple of it. With
  // it, adjacent meshes have their common vertices in the same places, bit for bit. 0: none.
  double finestStep = 0;
  std::string copyright; // empty: not written
};

// Encodes a tile. Triangles and skirts are separate primitives; that of the skirts has "extras":
// { "skirt": true }.
//
// Meshopt: positions are whole numbers of 16 bits. If the mesh is longer than 65535 steps of the
// frame's lattice, they are floats that hold whole numbers of 23 bits (three bytes each when
// compressed). So positions are points of the lattice, and adjacent meshes meet. If the frame has
// no finest step, positions always have 16 bits, and use only every 2nd, 4th … point if necessary.
// Without a lattice the longest side is divided into equal steps. Normals are bytes; colours
// (linear, as in the format) and texture coordinates have 16 bits. Draco: the same positions;
// normals of 8 bits, texture coordinates of 14; each primitive has its own vertices. None: floats,
// relative to the middle of the mesh. Always: arrays are floats, property attributes of
// EXT_structural_metadata; large coordinates are only in the node's matrix, which has doubles.
// Deterministic. Errors: LimitExceeded beyond 4 GB; Unsupported if the library is not available.
// REQUIRES: points; with a finest step, they are at most mostLatticeSteps apart (parts of skirts
// beyond that are cut off).
Result<std::string> EncodeTileGlb(
  const TileMesh& mesh, const TileFrame& frame, TileCompression compression);

}
