// SPDX-License-Identifier: BSD-3-Clause
// The texture tiles that are loaded for parts of a surface. Step "render" of the pipeline picture.
#pragma once

#include "filters/codec/TextureTile.h"
#include "filters/core/pieces/Piece.h"

#include <algorithm>
#include <memory>
#include <vector>

namespace kdstream
{

struct TexturedPiece
{
  PieceId piece;
  std::shared_ptr<const TextureTile> tile;
};
using TileList = std::vector<TexturedPiece>; // by piece, ascending

// The tile of a piece; null if there is none. O(log tiles).
inline std::shared_ptr<const TextureTile> FindTile(const TileList& tiles, PieceId piece)
{
  const auto place = std::partition_point(
    tiles.begin(), tiles.end(), [piece](const TexturedPiece& each) { return each.piece < piece; });
  return place != tiles.end() && place->piece == piece ? place->tile : nullptr;
}

}
