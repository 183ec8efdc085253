// SPDX-License-Identifier: BSD-3-Clause
// The tiles of a model: which tiles there are, the error, place and content of each, and the
// tilesets that refer to them. Layout: doc/3dtiles.md. kdstream-store exports all tiles; a server
// makes those that are requested. Both make the same bytes of each .glb.
//
// The tree of tiles follows the tree of nodes: the children of a piece are the pieces of the next
// resolution in its node. So each piece is in one tile, and its children show the same part of the
// surface.
//
// The tree is divided into tilesets of at most mostTilesOfTileset tiles. If partitions are so small
// that a piece of the finest level has more than this below it, tiles without content group them.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/core/pieces/Piece.h"
#include "filters/model/ModelDescription.h"
#include "filters/protocol/BlobId.h"
#include "filters/tiles/GlobePlace.h"
#include "filters/tiles/TileGlb.h"
#include "filters/tiles/TileMesh.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace kdstream
{

class JsonWriter;

struct TilesOptions
{
  TileCompression compression = TileCompression::Meshopt;
  bool normals = true;
  // The place of the model's (0, 0, 0) on the globe; nothing: not on the globe.
  std::optional<GlobePlace> origin;
};

// The source of the data for tiles. Both functions may be called from any thread.
struct TileInput
{
  std::function<Result<Piece>(PieceId)> readPiece; // returns a checked piece
  // Reads a page of the tree, or a texture.
  std::function<Result<std::vector<std::uint8_t>>(const protocol::BlobId&)> readBlob;
};

struct TileFacts
{
  double error = 0; // in model units
  Box box;          // of the content of the tile and of all tiles below; model units
  bool shows = false;
  bool stays = false; // whether the tile or one below it has content
};

// The tiles of one step of the tree: those of one resolution, or groups for the original.
struct TileStepShape
{
  Resolution resolution;
  unsigned depth = 0;      // of the nodes of its tiles
  std::uint64_t count = 0; // number of its tiles
  bool isGroup = false;    // whether they only group other tiles
  bool begins = false;     // whether they are the roots of tilesets of their own

  NodeId NodeOf(std::size_t tile) const
  {
    return (NodeId{ 1 } << this->depth) + static_cast<NodeId>(tile);
  }
  PieceId PieceOf(std::size_t tile) const { return { this->resolution, this->NodeOf(tile) }; }
};

struct TileStep : TileStepShape
{
  std::string folder; // its name
  std::vector<TileFacts> tiles;
  double latticeStep = 0; // of the coordinates of all its tiles, in model units; 0: not known yet
};

// The .glb of a tile; no bytes if the tile shows nothing.
struct EncodedTile
{
  std::string bytes;
  Box box;
};

class TileTree
{
public:
  // Inner tilesets to which a tileset refers count, too.
  static constexpr std::uint64_t mostTilesOfTileset = 256;

  // Makes the tree for resolutions from the preview's level to the finest one that `detail`
  // includes. O(tiles); the tree stores one TileFacts for each. REQUIRES: a model with levels.
  explicit TileTree(const ModelDescription& model, ModelDetail detail = ModelDetail::Regions);

  const std::vector<TileStep>& Steps() const { return this->All; } // coarse to fine
  // The steps of a model, coarse to fine. Tilesets begin at the same tiles for each `detail`.
  // O(levels).
  static std::vector<TileStepShape> ShapesOf(const ModelDescription& model, ModelDetail detail);
  // How many tiles there would be, not counting groups.
  static std::uint64_t CountTiles(const ModelDescription& model, ModelDetail detail);

  // Finds the error of each tile, fine to coarse, and the lattices of lossless stores, from the
  // pages of the tree. Errors: those of the source; Damaged.
  Status FindErrors(const TileInput& source);

  // Whether adjacent tiles would be lit differently along their border.
  bool NeedsBorders(std::size_t step, const TilesOptions& options) const;
  // borders: of the step, ascending; at least those of the owners of the piece's ghosts. Errors:
  // those of the source; Damaged; those of EncodeTileGlb. REQUIRES: FindErrors was called; not a
  // group.
  Result<EncodedTile> MakeTile(const TileInput& source, std::size_t step, std::size_t tile,
    const TilesOptions& options, std::span<const BorderNormal> borders) const;
  // A box that encloses what the tile of a piece shows, without making the tile; empty if it shows
  // nothing.
  Box ReachOf(const Piece& piece, std::size_t step, std::size_t tile) const;

  // Sets the box of a tile's content; `box` is empty if it has none. REQUIRES: Place was called for
  // all tiles below.
  void Place(std::size_t step, std::size_t tile, const Box& box);

  // The tileset of a tile that begins one. up: the path from the tileset to the folder of all
  // tiles: "", "../". REQUIRES: Place was called for all tiles.
  std::string TilesetOf(
    std::size_t step, std::size_t tile, const TilesOptions& options, const std::string& up) const;
  // The file of a tile, such as "17/12.glb"; of a group by its node: "original/131.json".
  static std::string FileOf(const TileStep& step, std::size_t tile, const char* ending)
  {
    return step.folder + "/" + std::to_string(step.isGroup ? step.NodeOf(tile) : tile) + ending;
  }

private:
  std::pair<std::size_t, std::size_t> ChildrenOf(std::size_t step, std::size_t tile) const;
  template <class Visit>
  Status VisitFacts(const TileInput& source, const Visit& visit) const;
  void ChooseLattices(const std::vector<double>& leastSides);
  TileFrame FrameOf(const TileStep& step) const;
  double SkirtDepth(std::size_t step, std::size_t tile) const;
  const TileFacts& ShownBy(std::size_t step, std::size_t tile) const;
  double ErrorOf(const TileFacts& tile) const { return tile.error * this->Frame.scale; }
  double Diagonal() const;
  void PutTile(JsonWriter& json, std::size_t step, std::size_t tile, std::size_t root,
    const TilesOptions& options, const std::string& up) const;
  void PutBox(JsonWriter& json, const Box& box) const;
  void PutTransform(JsonWriter& json, const TilesOptions& options) const;

  ModelDescription Info;
  TileFrame Frame;
  std::vector<TileStep> All;
};

}
