// SPDX-License-Identifier: BSD-3-Clause
// Writes a store as a tileset of 3D Tiles 1.1, or one level of it as a small .glb: for
// kdstream-store export --format 3dtiles and glb.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/store/Store.h"
#include "filters/tiles/TileTree.h"

#include <cstdint>
#include <filesystem>

namespace kdstream
{

struct TilesReport
{
  std::uint64_t tiles = 0, bytes = 0; // of the .glb files; of all files
};

// Writes tileset.json, and a .glb for each piece of the original and of the levels from the
// preview's on, into the folder `folder`. A new folder appears whole or not at all; an empty one is
// filled at the end, with tileset.json last. Layout: doc/3dtiles.md.
//
// Peak memory: some pieces at a time, and 5 kB a piece for normals on borders. Threads: `execution`
// encodes pieces. Reports the step "export". The same bytes for any number of threads. Errors:
// those of the store; Unsupported if it has no levels, or for a compression that is not built in;
// InputOutput, also if the folder exists and is not empty; Cancelled.
Result<TilesReport> ExportTiles(const Store& store, const std::filesystem::path& folder,
  const TilesOptions& options, const Execution& execution = {});

}
