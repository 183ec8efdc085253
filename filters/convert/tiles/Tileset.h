// SPDX-License-Identifier: BSD-3-Clause
// Tilesets of 3D Tiles 1.0 and 1.1: finds their finest tiles, and how these are placed.
#pragma once

#include "filters/convert/gltf/GltfNodes.h"
#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"

#include <filesystem>
#include <string>
#include <vector>

namespace kdstream
{

struct TileFile
{
  std::filesystem::path file; // relative to the tileset's folder
  GltfStand stand;            // from glTF's axes to those of the tileset, z up
  Box volume;                 // contains the tile's boundingVolume; empty: not known
};

struct FinestTiles
{
  std::vector<TileFile> tiles;
  std::vector<std::filesystem::path> tilesets; // also subtrees; relative to the folder
  std::vector<std::string> warnings;
};

// Walks through a tileset and the tilesets that it names. A content is among the finest unless
// finer contents replace it: its tile has refine: REPLACE, and a tile below has a content. Reads
// implicit tiling, quadtrees and octrees, also as the extension of version 1.0.
//
// Reads only files in the tileset's folder, and does not look into the contents. Limits: 2^20
// tiles, 512 levels of nested tiles, 2^30 bytes for a tileset, 2^20 tiles in a subtree, 32 levels
// of implicit tiling.
//
// Memory: the tilesets on the path from the root to one of them, and about 300 bytes for each
// content. Errors: InvalidInput, naming the tileset and the tile ("root/0/3", by the numbers of
// children): for a URI that leads nowhere or out of the folder; a tileset that names itself; an
// impossible error, box or transform. Unsupported: another version, or a required extension.
// LimitExceeded; Cancelled.
Result<FinestTiles> FindFinestTiles(
  const std::filesystem::path& tileset, const Execution& execution = {});

}
