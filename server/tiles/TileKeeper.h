// SPDX-License-Identifier: BSD-3-Clause
// The tilesets of models as a server makes them (doc/3dtiles.md#served): each file is made from the
// model's blobs when it is requested, and kept. Step "serve" of the pipeline picture. No sockets.
//
// A tile is made from its piece, its texture, and the normals on the borders of the pieces beside
// it. A tileset contains boxes, and a tile's box encloses everything below it. So each piece is
// read once, for the first tileset that is requested; then what is known about all tiles is kept.
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

// The piece that a tile shows, or the first tile of a tileset. Errors: NotFound if the model has no
// such tile; Unsupported if it has more tiles than a server makes.
Result<protocol::BlobId> PieceOfTile(const ModelDescription& model, const protocol::TileName& tile);

// All functions may be called from any thread.
class TileKeeper
{
public:
  static constexpr std::size_t keptBytes = std::size_t{ 64 } << 20;    // of tiles and tilesets
  static constexpr std::size_t borderBytes = std::size_t{ 16 } << 20;  // of normals on borders
  static constexpr std::size_t treeBytes = std::size_t{ 64 } << 20;    // of trees of tiles
  static constexpr std::uint64_t mostTiles = std::uint64_t{ 1 } << 18; // of a model

  TileKeeper();
  ~TileKeeper();

  // version: identifies the model's content and description; the addresses of tiles in a tileset
  // contain it.
  struct Wanted
  {
    std::string version;
    protocol::TileName tile;
    ModelDetail detail = ModelDetail::Regions; // how deep a tileset goes
  };
  // The file, if it is in memory; else null. Never waits.
  BlobBytes Find(const Wanted& wanted) const;
  // The file. May wait for a disk, and takes much computing. Errors: those of
  // ServedModel::ReadBlob; NotFound if the tile shows nothing; Damaged. REQUIRES: PieceOfTile has
  // found the tile's piece.
  Result<BlobBytes> Get(const ServedModel& model, const Wanted& wanted) const;

  CacheUse Use() const { return this->Files->Use(); }

private:
  class ModelTiles;
  std::shared_ptr<ModelTiles> Of(const std::string& version, bool isMade) const;
  void Trim(const std::shared_ptr<ModelTiles>& last) const;

  const std::shared_ptr<BlobCache> Files, Borders;
  mutable std::mutex Mutex;                              // for the members below
  mutable std::list<std::shared_ptr<ModelTiles>> Recent; // the latest first
};

}
