// SPDX-License-Identifier: BSD-3-Clause
// Makes the texture tile of a partition: crops the charts of its triangles, packs them into a small
// picture, and encodes it. Part of step "encode" of the pipeline picture.
#pragma once

#include "filters/codec/TextureTile.h"
#include "filters/texture/TileCharts.h"

#include <cstdint>
#include <mutex>

namespace kdstream
{

struct TileOptions
{
  // WebP's quality, 1-100. 0 means lossless: texels bit for bit, and coordinates as the input has
  // them.
  unsigned quality = 90;
  // The longest side of a tile, in texels; a larger tile is halved until it fits. Lossless tiles
  // can be as long as longestTileSide.
  std::int64_t mostSide = 4096;
  // Locked while a tile of more than 2 million texels is made, so that only one tile at a time
  // takes this memory. Null: no limit.
  std::mutex* oneLarge = nullptr;
};

// Numbers of tiles, texels and triangles; the counts of several tiles can be added.
struct TileCounts
{
  std::uint64_t tiles = 0, halved = 0; // halved: had to be made smaller
  std::uint64_t texels = 0;            // of all tiles
  std::uint64_t triangles = 0,
                // All triangles; those that show a picture's mean, because they repeat it too
                // often.
    repeating = 0;
  void Add(const TileCounts& more);
};

struct MadeTile
{
  TextureTile tile;
  TileCounts counts;
};

// Packs the charts of FindTileCharts. Each chart has a gutter of two texels: the texels around it
// in its picture, or, beyond the picture's edge, what the wrap modes give. The texels are
// multiplied by the material's factor in linear light; alpha is 1 if the material is opaque.
// - Triangles without a picture get a patch of their material's colour.
// - Triangles that repeat their picture too often, or lie too far outside it, get a patch of its
//   mean colour. In a lossy tile with at most 64 colours of patches, patches are so large that no
//   other colour bleeds into the texels that triangles use.
// - Texels that no chart covers are grey.
//
// Time: O(texels of the tile + triangles log triangles); memory: ten bytes for each texel of the
// tile. The same input and version of libwebp give the same bytes. Errors: those of the source;
// LimitExceeded if libwebp refuses.
Result<MadeTile> MakeTile(const TexturedTriangles& textured, const TextureSet& textures,
  const TexelSource& source, const TileOptions& options);

}
