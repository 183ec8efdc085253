// SPDX-License-Identifier: BSD-3-Clause
// The tilesets of models as a server makes them (doc/3dtiles.md#served): each file when it is asked
// for, of the model's blobs, and kept. Step "serve" of the pipeline picture. No sockets.
//
// A tile is made of its piece, its texture, and the normals on the borders of the pieces beside it.
// A tileset names boxes, and a tile's box encloses all below it, so each piece is read once, for
// the first tileset that is asked for; what is known of all tiles then is kept.
#pragma once

#include "filters/core/Result.h"
#include "filters/model/ModelDescription.h"
#include "filters/protocol/TileName.h"
#include "server/session/BlobCache.h"
#include "server/session/Catalog.h"

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <string>

namespace kdstream
{

// The piece that a tile, or the first tile of a tileset, shows. Errors: NotFound where the model
// has no such tile; Unsupported where it has more tiles than a server makes.
Result<protocol::BlobId> PieceOfTile(const ModelDescription& model, const protocol::TileName& tile);

// All functions from any thread.
class TileKeeper
{
public:
  static constexpr std::size_t keptBytes = std::size_t{ 64 } << 20;    // of tiles and tilesets
  static constexpr std::size_t borderBytes = std::size_t{ 16 } << 20;  // of normals on borders
  static constexpr std::size_t treeBytes = std::size_t{ 64 } << 20;    // of what is known of tiles
  static constexpr std::uint64_t mostTiles = std::uint64_t{ 1 } << 18; // of a model

  TileKeeper();
  ~TileKeeper();

  // version: names the model's content and description; tilesets refer to their tiles by it.
  struct Wanted
  {
    std::string version;
    protocol::TileName tile;
    ModelDetail detail = ModelDetail::Regions; // how deep a tileset goes
  };
  // The file, if it is in memory; else null. Waits for nobody.
  BlobBytes Find(const Wanted& wanted) const;
  // The file. May wait for a disk, and takes a processor. Errors: those of ServedModel::ReadBlob;
  // NotFound where the tile shows nothing; Damaged. REQUIRES: PieceOfTile has found it.
  Result<BlobBytes> Get(const ServedModel& model, const Wanted& wanted) const;

  CacheUse Use() const { return this->Files->Use(); }

private:
  class ModelTiles;
  std::shared_ptr<ModelTiles> Of(const std::string& version, bool isMade) const;
  void Trim(const std::shared_ptr<ModelTiles>& last) const;

  const std::shared_ptr<BlobCache> Files, Borders;
  mutable std::mutex Mutex;                              // for what follows
  mutable std::list<std::shared_ptr<ModelTiles>> Recent; // the latest first
};

}
