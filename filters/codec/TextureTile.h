// SPDX-License-Identifier: BSD-3-Clause
// Encodes and decodes the texture of a partition: a small picture, into which the charts of its
// triangles are packed, and the corners' coordinates in it. Part of the steps "encode" and "decode"
// of the pipeline picture. Layout: doc/formats.md, "Textures". The picture itself is an encoded
// image, which clients decode with what their platform has. It is not decoded here.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/Types.h"

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

namespace kdstream
{

enum class TileImage : std::uint8_t
{
  Jpeg = 1,
  Png = 2,
  Webp = 3
};
// "jpeg", "png", "webp": as stores and messages name them.
std::string_view NameOf(TileImage format);

// Texels of the tile's picture from its left edge, and from its upper edge down: texel (i, j)
// covers [i, i + 1) × [j, j + 1). Divided by width and height they are the texture coordinates of
// glTF, and of OpenGL ES if the first row is uploaded first.
using TileCoordinate = std::array<float, 2>;

// The longest side of a tile's picture: WebP's.
inline constexpr std::uint32_t longestTileSide = 16383;
// Steps of a texel to which coordinates are rounded, except in exact tiles; and in coarse ones.
inline constexpr unsigned tileSteps = 256, coarseTileSteps = 8;

inline constexpr std::uint32_t noTileSource = std::numeric_limits<std::uint32_t>::max();

// In an exact tile: a picture of the input as a material uses it.
struct TileSource
{
  // The number of a picture of the input. Numbers from their count on: the same pictures with
  // another factor or alpha mode (doc/formats.md).
  std::uint32_t picture = 0;
  std::uint32_t width = 1, height = 1;
  // From the coordinates that the input gives to those of the picture, 0-1 from its upper left:
  // u' = u[0] u + u[1] v + u[2], v' alike.
  std::array<double, 3> u{ 1, 0, 0 }, v{ 0, 1, 0 };
  std::array<std::uint8_t, 2> wrap{}; // along u' and v': 0 repeats, 1 mirrors, 2 clamps
  bool operator==(const TileSource&) const = default;
};

// In an exact tile: a part of a source, moved by whole texels, or a patch of one colour.
struct TileChart
{
  std::uint32_t source = noTileSource; // noTileSource: a patch, whose corners are all at (x, y)
  // Where the source's upper left corner lies in the tile, in texels of the source, before the tile
  // is halved. May be far outside the tile.
  std::int64_t x = 0, y = 0;
  bool operator==(const TileChart&) const = default;
};

// What a lossless build keeps: the input's coordinates bit for bit, and where texels are from.
struct ExactTile
{
  std::uint8_t halvings = 0; // the charts' sides are the sources' by 2^halvings
  std::vector<TileSource> sources;
  std::vector<TileChart> charts;
  std::vector<std::uint32_t> chartOf; // of each triangle
  // u, v of each triangle's corners as the input has them; NaN: none.
  std::vector<std::array<std::array<float, 2>, 3>> corners;
  bool operator==(const ExactTile&) const = default;
};

// Only the head: enough to decode and upload the picture.
struct TextureTileHead
{
  std::uint32_t triangles = 0;
  std::uint32_t width = 1, height = 1; // texels of the picture, 1 to longestTileSide
  TileImage format = TileImage::Webp;
  bool exact = false, coarse = false;
  std::span<const std::uint8_t> image; // into the blob
};

struct TextureTile
{
  std::uint32_t width = 1, height = 1;
  TileImage format = TileImage::Webp;
  std::vector<std::uint8_t> image;
  // For each triangle of the partition's piece, in its order. For an exact tile `exact` gives the
  // coordinates: an encoder ignores these, a decoder fills them in (PlaceOfCorner).
  std::vector<std::array<TileCoordinate, 3>> corners;
  bool isExact = false;
  ExactTile exact{};
  bool isCoarse = false; // not of an exact tile
};

// Where in the tile a corner of an exact chart lies.
TileCoordinate PlaceOfCorner(
  const ExactTile& exact, std::uint32_t chart, const std::array<float, 2>& corner);

// Encodes a tile of a piece with these triangles. Coordinates are rounded to 1 / tileSteps of a
// texel (coarseTileSteps) and kept inside the picture, unless the tile is exact. REQUIRES: as many
// corners (exact: charts and corners) as triangles; sides of 1 to longestTileSide; numbers of
// charts and sources that are there. Deterministic; O(triangles + bytes of the image).
std::vector<std::uint8_t> EncodeTextureTile(
  const TextureTile& tile, std::span<const Triangle> triangles);

// The head of a tile. Any bytes may be given. No memory is taken; O(size) for the checksum. Errors:
// Damaged where the checksum is wrong (Seal.h); InvalidInput with the byte offset; Unsupported for
// an unknown codec version.
Result<TextureTileHead> ReadTextureTileHead(std::span<const std::uint8_t> blob);

// The whole tile. triangles: of the decoded original piece of the same partition (DecodePiece);
// memory and time are bounded by their number and the blob's size. The image's bytes are not
// checked: the code that decodes them must compare its size with the specified one. Errors: those
// of the head; InvalidInput for another number of triangles, and for a malformed tile.
Result<TextureTile> DecodeTextureTile(
  std::span<const std::uint8_t> blob, std::span<const Triangle> triangles);

}
