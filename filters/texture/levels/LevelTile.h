// SPDX-License-Identifier: BSD-3-Clause
// The texture of a level's piece, sampled from the next finer resolution. Part of step "encode" of
// the pipeline picture: texture tiles.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/pieces/Piece.h"
#include "filters/texture/MakeTile.h"
#include "filters/texture/levels/FinerColors.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

namespace kdstream
{

// The quality of levels' WebP for a quality of the original's, 1-100: a little less, since levels
// are what a view fetches first (decision 41).
constexpr unsigned LevelQuality(unsigned ofOriginal)
{
  return ofOriginal > 4 ? ofOriginal - 4 : 1;
}

struct LevelTileOptions
{
  unsigned quality = LevelQuality(90); // of WebP, 1-100
  // The number of texels on the surface for each vertex of the piece. If the next finer resolution
  // has more than twice as many vertices, as the original may, there are as many times more texels:
  // views show the piece longer. Fewer if the finer texels are farther apart.
  double texelsPerVertex = 32;
  // The largest side of a tile, in texels. If a side would be longer, texels are farther apart.
  std::int64_t mostSide = 1024;
  // The maximum size of the image in bytes. If it would be larger, texels are farther apart. 0: no
  // limit.
  std::size_t mostBytes = 0;
  // Locked while a finer image of more than 2 million texels exists, so that only one at a time
  // takes this memory. Null: no limit.
  std::mutex* oneLarge = nullptr;
};

// The pieces of the next finer resolution around a piece.
struct FinerTiles
{
  struct Place
  {
    Box box;           // of the piece's own vertices
    bool below = true; // true: the tile covers part of the piece; false: it is beside the piece
  };
  std::vector<Place> places;
  // Reads the tile at a place. May be called several times for a place.
  std::function<Result<std::shared_ptr<const FinerColors>>(std::size_t)> read;
  // Called after at most texelsBetween texels; returns false to stop. Null: never.
  std::function<bool()> goesOn = nullptr;
  static constexpr std::size_t texelsBetween = 1024;
};

// Makes a planar tile of the piece's triangles, in the charts of GrowLevelCharts, with a gutter of
// two texels.
// - A texel has the colour at the nearest place of a finer piece: the piece whose box is nearest to
//   the texel, or, if that place is more than a texel away, the nearest of all pieces. Surfaces
//   that face elsewhere count as farther away. The finer picture is halved, in linear light, until
//   its texels have about the same size.
// - Texels of the gutter are sampled, too, on the plane of the nearest triangle. So a filter reads
//   the same on both sides of a chart's border.
// - Texels between charts have the mean of the texels around them.
//
// Time: O(texels + triangles log triangles) for triangles of about the same size, plus the time for
// the finer pieces. Memory: about 30 bytes a texel, and one decoded finer tile. The same input and
// version of libwebp give the same bytes. Errors: those of finer.read; Damaged if a finer tile's
// image cannot be decoded; LimitExceeded if libwebp refuses; Cancelled.
Result<MadeTile> MakeLevelTile(
  const Piece& piece, const FinerTiles& finer, const LevelTileOptions& options);

}
