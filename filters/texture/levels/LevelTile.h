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

struct LevelTileOptions
{
  unsigned quality = 90; // of WebP, 1-100
  // Texels of the surface for each vertex of the piece, unless the finer texels are farther apart.
  double texelsPerVertex = 36;
  // The most texels of a tile's side: they are farther apart if it would be longer.
  std::int64_t mostSide = 1024;
  // The most bytes of the image: texels are farther apart if it would have more. 0: any number.
  std::size_t mostBytes = 0;
  // Held while there is a finer image of more than 2 million texels: one at a time, for their
  // memory. Null: any number.
  std::mutex* oneLarge = nullptr;
};

// Pieces of the next finer resolution around a piece.
struct FinerTiles
{
  struct Place
  {
    Box box;           // of the piece's own vertices
    bool below = true; // true: the tile covers part of the piece; false: it is beside the piece
  };
  std::vector<Place> places;
  // Reads the tile at a place. Called more than once.
  std::function<Result<std::shared_ptr<const FinerColors>>(std::size_t)> read;
};

// A tile of the piece's triangles, in charts of GrowLevelCharts with a gutter of two texels.
// - A texel has the colour at the nearest place of a finer piece: the one whose box is nearest to
//   the texel. Surfaces that face elsewhere count as farther. The finer picture is halved, in
//   linear light, until its texels are about as large.
// - Texels of the gutter are sampled too, on the plane of the nearest triangle: a filter reads the
//   same on both sides of a chart's border.
// - What is left between charts has the mean of what is around it.
//
// Time: O(texels + triangles log triangles) for triangles of about one size, and the finer pieces.
// Memory: some 30 bytes a texel, and one finer tile, decoded. The same bytes for the same input and
// version of libwebp. Errors: those of finer.read; Damaged where a finer tile's image cannot be
// decoded; LimitExceeded where libwebp refuses.
Result<MadeTile> MakeLevelTile(
  const Piece& piece, const FinerTiles& finer, const LevelTileOptions& options);

}
