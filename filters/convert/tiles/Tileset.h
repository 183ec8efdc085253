// SPDX-License-Identifier: BSD-3-Clause
// Tilesets of 3D Tiles 1.0 and 1.1: where their finest tiles are, and how these stand.
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
  Box volume;                 // in which its boundingVolume lies; empty: not known
};

struct FinestTiles
{
  std::vector<TileFile> tiles;
  std::vector<std::filesystem::path> tilesets; // and subtrees, relative to the folder
  std::vector<std::string> warnings;
};

// Walks a tileset and the tilesets that it names. A content is among the finest unless its tile is
// one that others replace (refine: REPLACE) and a tile below has a content. Implicit tiling:
// quadtrees and octrees, also as the extension of version 1.0.
//
// Only files in the tileset's folder are read, and the contents themselves are not looked into.
// Limits: 2^20 tiles, 512 tiles one in the other, 2^30 bytes a tileset, 2^20 tiles a subtree, 32
// levels of implicit tiling.
// Memory: the tilesets from the root to one of them, and some 300 bytes a content. Errors:
// InvalidInput, naming the tileset and the tile ("root/0/3": its children's numbers): for a URI
// that leads nowhere or out of the folder; a tileset that names itself; an error, a box or a
// transform that cannot be. Unsupported: another version, or an extension that is required.
// LimitExceeded; Cancelled.
Result<FinestTiles> FindFinestTiles(
  const std::filesystem::path& tileset, const Execution& execution = {});

}
