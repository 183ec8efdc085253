// SPDX-License-Identifier: BSD-3-Clause
// Finds which parts of which pictures the triangles of a partition need, and packs them as charts
// of a texture atlas (tile). Part of step "encode" of the pipeline picture: texture tiles.
#pragma once

#include "filters/core/Types.h"
#include "filters/texture/TexelSource.h"
#include "filters/texture/TexturedMesh.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace kdstream
{

// The materials and pictures of a mesh, without the mesh.
struct TextureSet
{
  std::vector<TexturedMaterial> materials;
  std::size_t pictures = 0;
  // The result of NumberShownPictures, for lossless tiles; empty: pictures have the input's
  // numbers.
  std::vector<std::uint32_t> shown{};
};

// Numbers the shown pictures, and returns the number of each material's. A shown picture is a
// picture with a colour factor and an alpha mode. Picture i as the first material that uses it
// shows it has the number i; as others show it, it has a number from textures.pictures on. A
// material without a picture has noPicture.
std::vector<std::uint32_t> NumberShownPictures(const TextureSet& textures);

// The triangles of a partition's piece.
struct TexturedTriangles
{
  std::span<const Triangle> triangles;
  std::vector<std::array<PictureCoordinate, 3>> corners; // as the input has them
  std::vector<std::uint32_t> materialOf;
};

// The largest coordinate, in texels of its picture.
inline constexpr double mostChartTexels = 1 << 30;

inline constexpr std::uint32_t noChartBox = std::numeric_limits<std::uint32_t>::max();

// The texels of all charts that lie near each other in one picture.
struct ChartBox
{
  std::uint32_t material = 0;
  TexelBox box; // contains all corners; may reach beyond the picture
};

// Why a triangle shows no part of a picture.
enum class Untextured : std::uint8_t
{
  No,
  NoPicture, // the material has no picture, or an unreadable one
  NoCoordinates,
  TooFar, // coordinates of mostChartTexels or more
  Repeats // repeats the picture more than four times
};

struct TriangleChart
{
  std::uint32_t box = noChartBox;
  std::array<std::int64_t, 2> shift{}; // texels; corners minus this lie in the box
  Untextured why = Untextured::NoPicture;
};

// Where a triangle's corners are, in texels of a picture.
using TexelCorners = std::array<std::array<double, 2>, 3>;
// The texels that contain a triangle; at least one.
TexelBox BoxOf(const TexelCorners& at);

struct TileCharts
{
  std::vector<ChartBox> boxes;
  std::vector<TriangleChart> ofTriangle;
  // Where corners are, in texels of the picture, not shifted; undefined for untextured triangles.
  std::vector<TexelCorners> texels;
};

// Steps:
// 1. Triangles of one material that share an edge, with equal coordinates there, form one chart.
// 2. A chart that spans more than two periods of its picture in a direction is split into its
//    triangles.
// 3. Each chart is moved by whole periods of its picture, so that it begins in the first one.
// 4. Charts of a material share a box if this box is not larger than their own boxes together.
//    gutter: texels around each box, which count for its size; nothing: each chart has its box.
//
// O(n log n), except for the last step, which compares each box with only a few neighbours.
// Deterministic. REQUIRES: corners and existing materials for each triangle.
TileCharts FindTileCharts(const TexturedTriangles& textured, const TextureSet& textures,
  const TexelSource& source, std::optional<std::int64_t> gutter);

}
