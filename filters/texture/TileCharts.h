// SPDX-License-Identifier: BSD-3-Clause
// Finds which parts of which pictures the triangles of a partition need, and packs them as charts
// of a texture atlas (tile). Part of step "encode" of the pipeline picture: texture tiles.
#pragma once

#include "filters/core/Types.h"
#include "filters/texture/TexelSource.h"
#include "filters/texture/TexturedMesh.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// How a mesh is painted, without the mesh.
struct TextureSet
{
  std::vector<TexturedMaterial> materials;
  std::size_t pictures = 0;
  // NumberShownPictures, for lossless tiles; empty: each as the input numbers it.
  std::vector<std::uint32_t> shown{};
};

// For each material the number of its picture as the material shows it: the picture's own number
// for the first material that has it; for another factor or alpha mode, a number from
// textures.pictures on, the same for equal ones. Without a picture: noPicture.
std::vector<std::uint32_t> NumberShownPictures(const TextureSet& textures);

// Triangles of a partition's piece.
struct TexturedTriangles
{
  std::span<const Triangle> triangles;
  std::vector<std::array<PictureCoordinate, 3>> corners; // as the input has them
  std::vector<std::uint32_t> materialOf;
};

// The most of a coordinate, in texels of its picture.
inline constexpr double mostChartTexels = 1 << 30;

inline constexpr std::uint32_t noChartBox = std::numeric_limits<std::uint32_t>::max();

// Texels of all charts that lie near each other in one picture.
struct ChartBox
{
  std::uint32_t material = 0;
  TexelBox box; // all that corners lie in; may be outside the picture, which repeats there
};

// Why a triangle has no part of a picture.
enum class Untextured : std::uint8_t
{
  No,
  NoPicture, // the material has no picture, or one that cannot be read
  NoCoordinates,
  TooFar, // coordinates of mostChartTexels or more
  Repeats // repeats the picture more than four times
};

struct TriangleChart
{
  std::uint32_t box = noChartBox;
  std::array<std::int64_t, 2> shift{}; // texels; corners less this lie in the box
  Untextured why = Untextured::NoPicture;
};

struct TileCharts
{
  std::vector<ChartBox> boxes;
  std::vector<TriangleChart> ofTriangle;
  // Where corners are, in texels of the picture, not shifted; of unpainted triangles anything.
  std::vector<std::array<std::array<double, 2>, 3>> texels;
};

// Steps:
// 1. Triangles of one material that share an edge, with the same coordinates there, form one chart.
// 2. A chart that spans more than two periods of its picture in a direction is cut into its
//    triangles.
// 3. Each chart is moved by whole periods of its picture, so that it begins in the first one.
// 4. Charts of a material whose common box is not larger than their own boxes together share one
//    box. gutter: texels around each box, included in its size.
//
// O(n log n), but for the last step, which looks at no more than a few neighbours of each box.
//  Deterministic. REQUIRES: corners and materials of each triangle, materials that are there.
TileCharts FindTileCharts(const TexturedTriangles& textured, const TextureSet& textures,
  const TexelSource& source, std::int64_t gutter);

}
