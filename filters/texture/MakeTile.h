// SPDX-License-Identifier: BSD-3-Clause
// Makes the texture tile of a partition: its triangles' charts are cropped, packed into a small
// picture and encoded. Part of step "encode" of the pipeline picture.
#pragma once

#include "filters/codec/TextureTile.h"
#include "filters/texture/TileCharts.h"

#include <cstdint>
#include <mutex>

namespace kdstream
{

struct TileOptions
{
  // WebP's quality, 1-100. 0: lossless: texels bit for bit, and coordinates as the input has them.
  unsigned quality = 90;
  // The longest side of a tile in texels; a larger tile is halved until it fits. Lossless tiles may
  // have longestTileSide.
  std::int64_t mostSide = 4096;
  // Locked while a tile of more than 2 million texels is made, so that only one at a time takes
  // that memory. Null: no limit.
  std::mutex* oneLarge = nullptr;
};

// Numbers of triangles by result; counts of several tiles can be added.
struct TileCounts
{
  std::uint64_t tiles = 0, halved = 0; // tiles that had to be made smaller
  std::uint64_t texels = 0;            // of all tiles
  std::uint64_t triangles = 0,
                // All triangles; and those that show the mean of a picture that they repeat.
    repeating = 0;
  void Add(const TileCounts& more);
};

struct MadeTile
{
  TextureTile tile;
  TileCounts counts;
};

// Packs the charts of FindTileCharts. Each chart has a gutter of two texels: its surroundings in
// its picture, or, beyond the picture's edge, by the wrap modes. A material's factor is multiplied
// in, in linear light; alpha is 1 where the material is opaque.
// - Triangles without a picture get a patch of their material's colour.
// - Triangles that repeat their picture too often, or lie too far outside it, get a patch of its
//   mean colour. In a lossy tile of up to 64 of these colours, patches are so large that no other
//   colour reaches their corners.
// - Texels that no chart covers are grey.
//
// Time: O(texels of the tile + triangles log triangles); memory: ten bytes a texel of the tile. The
// same bytes for the same input and version of libwebp. Errors: those of the source; LimitExceeded
// if libwebp refuses.
Result<MadeTile> MakeTile(const TexturedTriangles& textured, const TextureSet& textures,
  const TexelSource& source, const TileOptions& options);

}
