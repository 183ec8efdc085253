// SPDX-License-Identifier: BSD-3-Clause
// Encodes and decodes the texture of a partition: a small picture, into which the charts of its
// triangles are packed, and the coordinates of the triangles' corners in the picture. Part of the
// steps "encode" and "decode" of the pipeline picture. Layout: doc/formats.md, "Textures". The
// picture itself is an encoded image. It is not decoded here: clients use the decoder of their
// platform.
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
// The format's name in stores and messages: "jpeg", "png" or "webp".
std::string_view NameOf(TileImage format);

// A place in the tile's picture, in texels from the left edge and from the upper edge down: texel
// (i, j) covers [i, i + 1) × [j, j + 1). Divided by width and height it gives texture coordinates
// as in glTF, and as in OpenGL ES if the first row is uploaded first.
using TileCoordinate = std::array<float, 2>;

// The longest side of a tile's picture: the limit of WebP.
inline constexpr std::uint32_t longestTileSide = 16383;
// Coordinates are rounded to 1 / tileSteps of a texel, in coarse tiles to 1 / coarseTileSteps. In
// exact tiles they are not rounded.
inline constexpr unsigned tileSteps = 256, coarseTileSteps = 8;

inline constexpr std::uint32_t noTileSource = std::numeric_limits<std::uint32_t>::max();

// In an exact tile: a picture of the input, in the way that a material uses it.
struct TileSource
{
  // The number of a picture of the input. Numbers beyond the count of pictures stand for the same
  // pictures with another factor or alpha mode (doc/formats.md).
  std::uint32_t picture = 0;
  std::uint32_t width = 1, height = 1;
  // Maps the coordinates of the input to those of the picture (0-1 from the upper left): u' = u[0]
  // u + u[1] v + u[2], and v' likewise.
  std::array<double, 3> u{ 1, 0, 0 }, v{ 0, 1, 0 };
  std::array<std::uint8_t, 2> wrap{}; // along u' and v': 0 repeats, 1 mirrors, 2 clamps
  bool operator==(const TileSource&) const = default;
};

// In an exact tile: a part of a source, moved by whole texels; or a patch of a single colour.
struct TileChart
{
  std::uint32_t source = noTileSource; // noTileSource: a patch, whose corners are all at (x, y)
  // Where the source's upper left corner lies in the tile, in texels of the source, before the tile
  // is halved. It can be far outside the tile.
  std::int64_t x = 0, y = 0;
  bool operator==(const TileChart&) const = default;
};

// Data that a lossless build keeps: the input's coordinates bit for bit, and where texels come
// from.
struct ExactTile
{
  std::uint8_t halvings = 0; // charts' sides: those of the sources / 2^halvings
  std::vector<TileSource> sources;
  std::vector<TileChart> charts;
  std::vector<std::uint32_t> chartOf; // of each triangle
  // u, v of each triangle's corners as in the input; NaN if there are none.
  std::vector<std::array<std::array<float, 2>, 3>> corners;
  bool operator==(const ExactTile&) const = default;
};

// In a planar tile: a plane on which triangles are projected. `turn`: x, y and z of the quaternion
// of length 1 that turns the plane's axes into those of the picture, in 1 / turnSteps; w is not
// negative. `offset`: where the piece's first vertex would lie, in 1 / coarseTileSteps of a texel.
struct PlanarChart
{
  std::array<std::int64_t, 2> offset{};
  std::array<std::int32_t, 3> turn{};
  bool operator==(const PlanarChart&) const = default;
};
inline constexpr std::int32_t turnSteps = 2048;

// How the texture coordinates of a planar tile follow from the positions of vertices.
struct PlanarTile
{
  double texels = 1; // along a unit of length
  std::vector<PlanarChart> charts;
  std::vector<std::uint32_t> chartOf; // of each triangle
  bool operator==(const PlanarTile&) const = default;
};

// The head of a tile, which is enough to decode and upload the picture.
struct TextureTileHead
{
  std::uint32_t triangles = 0;
  std::uint32_t width = 1, height = 1; // texels of the picture, 1 to longestTileSide
  TileImage format = TileImage::Webp;
  bool exact = false, coarse = false, planar = false; // at most one of them
  std::span<const std::uint8_t> image;                // into the blob
};

struct TextureTile
{
  std::uint32_t width = 1, height = 1;
  TileImage format = TileImage::Webp;
  std::vector<std::uint8_t> image;
  // For each triangle of the piece, in its order. For an exact tile the coordinates come from
  // `exact`, for a planar one from `planar`: encoding ignores these, decoding fills them in
  // (PlaceOfCorner).
  std::vector<std::array<TileCoordinate, 3>> corners;
  bool isExact = false;
  ExactTile exact{};
  bool isCoarse = false; // at most one of isExact, isCoarse and isPlanar
  bool isPlanar = false;
  PlanarTile planar{};
};

// Where in the tile a corner of an exact chart lies.
TileCoordinate PlaceOfCorner(
  const ExactTile& exact, std::uint32_t chart, const std::array<float, 2>& corner);

// The axes of a planar chart, x and y of the picture, of length about 1.
std::array<Vec3, 2> AxesOf(const PlanarChart& chart);
// Where a vertex of a planar chart lies. from: from the piece's first vertex.
TileCoordinate PlaceOfCorner(const PlanarTile& planar, const PlanarChart& chart,
  const std::array<Vec3, 2>& axes, const Vec3& from);

// Encodes a tile of a piece with these triangles. Unless the tile is exact or planar, coordinates
// are rounded to 1 / tileSteps (coarse: 1 / coarseTileSteps) of a texel, and clamped to the
// picture. REQUIRES: the same number of corners (exact: also of charts in chartOf; planar: only of
// these) as of triangles; sides of 1 to longestTileSide; charts and sources that exist.
// Deterministic; O(triangles + bytes of the image).
std::vector<std::uint8_t> EncodeTextureTile(
  const TextureTile& tile, std::span<const Triangle> triangles);

// Reads the head of a tile. The bytes may be hostile. Allocates nothing; O(size) for the checksum.
// Errors: Damaged if the checksum is wrong (Seal.h); InvalidInput, with the byte offset, if the
// head is malformed; Unsupported for an unknown codec version.
Result<TextureTileHead> ReadTextureTileHead(std::span<const std::uint8_t> blob);

// Decodes the whole tile. triangles, positions: of the decoded piece (DecodePiece), whose number
// and the blob's size bound memory and time. Positions are needed for planar tiles only. The
// image's bytes are not checked: code that decodes the image must compare its size with that in the
// head. Errors: those of ReadTextureTileHead; InvalidInput if the number of triangles differs, or
// the tile is malformed.
Result<TextureTile> DecodeTextureTile(std::span<const std::uint8_t> blob,
  std::span<const Triangle> triangles, std::span<const Vec3> positions = {});

}
