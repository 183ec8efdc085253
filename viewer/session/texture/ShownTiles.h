// SPDX-License-Identifier: BSD-3-Clause
// The texture tiles for the shown surface: which ones the view wants, and which have arrived.
// Between steps "choose" and "keep" of the pipeline picture.
#pragma once

#include "filters/codec/TextureTile.h"
#include "filters/core/Result.h"
#include "filters/core/drawing/DrawnSurface.h"
#include "filters/core/pieces/Piece.h"
#include "filters/model/ModelDescription.h"
#include "filters/protocol/BlobId.h"
#include "viewer/session/Camera.h"
#include "viewer/session/texture/TileList.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <set>
#include <span>
#include <vector>

namespace kdstream
{

// A tile is wanted if its piece is drawn and may be visible, and one of these holds: the piece is a
// tapped partition; its vertices are so far apart on the screen that the colours of vertices would
// look blurred; everything is to be shown as the original. Of the pieces of levels, only those that
// the view wants count: others are drawn only until those arrive, or where hardly anything of them
// is visible. Tiles in the middle of the screen come first, up to the limit on decoded pictures. A
// tile that is not wanted any more stays until others need its memory. All functions are O(parts
// log parts), except Add.
class ShownTiles
{
public:
  explicit ShownTiles(std::size_t limit);

  // Forgets everything. For a model without textures nothing is wanted. spacings: of the vertices
  // of each level and of the original, in the model's unit.
  void Reset(const ModelDescription& model, std::vector<double> spacings);
  // Whether the model has textures.
  bool AreThere() const { return !this->Expected.empty(); }
  // Bytes of decoded pictures, 4 a texel.
  void SetLimit(std::size_t bytes);

  // Finds what the camera wants for a surface whose parts have texture corners
  // (SurfaceParts::KeepCorners). tapped: nodes of tapped partitions. all: tiles are wanted even if
  // vertices are near each other. levels: the pieces of levels that count, ascending; null: all of
  // them.
  void Follow(const DrawnSurface& surface, const Camera& camera, const std::set<NodeId>& tapped,
    bool all, const std::vector<PieceId>* levels = nullptr);
  // The wanted tiles that have neither arrived nor failed, the most urgent first.
  const std::vector<protocol::BlobId>& Missing() const { return this->Lacking; }
  // The approximate bytes of a tile that has not arrived. REQUIRES: AreThere, a blob of Missing.
  std::size_t ExpectedBytes(const protocol::BlobId& blob) const;

  // The bytes may be hostile. piece: the decoded piece that the tile belongs to, or null if it is
  // not in memory any more; then nothing happens. Errors: those of DecodeTextureTile.
  Status Add(const protocol::BlobId& blob, std::span<const std::uint8_t> bytes, const Piece* piece);
  // A failed tile is not requested again until Retry.
  void Fail(const protocol::BlobId& blob) { this->Failed.insert(blob); }
  void Retry() { this->Failed.clear(); }
  void Retry(const protocol::BlobId& blob) { this->Failed.erase(blob); }

  // The loaded tiles, never null. A change of the tiles gives a new object.
  const std::shared_ptr<const TileList>& Tiles() const { return this->Here; }
  // The bytes of the tiles as they arrived, and of their corners.
  std::size_t Bytes() const { return this->Held; }
  // Bytes of decoded pictures, 4 for each texel.
  std::size_t PictureBytes() const;

private:
  bool Touch(PieceId piece);
  void Evict();

  struct ExpectedTile // averages of a resolution
  {
    std::size_t bytes = 0, picture = 0; // picture: 4 a texel; bytes 0: there are no tiles
    double spacing = 0;                 // between the piece's vertices
  };
  const ExpectedTile& ExpectedOf(Resolution resolution) const;

  std::size_t Limit;
  TreeDepths Depths;
  std::vector<ExpectedTile> Expected; // of levels, and of the original; empty without textures
  TileList Kept;                      // in the order in which they were wanted
  std::shared_ptr<const TileList> Here;
  std::vector<protocol::BlobId> Lacking;
  std::set<protocol::BlobId> Failed;
  std::size_t Held = 0;
};

}
