// SPDX-License-Identifier: BSD-3-Clause
// A statue that photographs paint: the textured model of demos, tests and benchmarks.
#pragma once

#include "Data/Generate/ClosedGrid.h"
#include "filters/core/Execution.h"

#include <cstdint>
#include <filesystem>

namespace kdstream::generate
{

// How the surface is cut for its pictures.
enum class StatueCharts
{
  Few,   // four charts a picture
  Small, // 576 charts a picture, in no order, as photogrammetry makes them
  Udim   // few; picture k has the coordinates u from k to k + 1
};

struct StatueOptions
{
  std::uint64_t vertices = 300000; // about
  std::size_t pictureSide = 2048;  // texels, at least 64; 256 of small charts
  std::uint64_t seed = 1;
  StatueCharts charts = StatueCharts::Few;
};

// A bust of stone, about 1.8 high, standing on y = 0; closed. Its colour is that of the stone:
// bands, veins, grain, an inscription around its foot, and dirt. The colour is meant for a texture:
// it has finer detail than any vertices.
ColoredSurface MakeStatue(std::uint64_t seed);

// Writes NAME.obj, NAME.mtl and NAME-0.jpg, NAME-1.png, NAME-2.jpg, NAME-3.png beside it. Each
// picture has a quarter of the way around, in charts side by side with a gutter, some of them
// upside down; each was exposed a little differently. Vertices are shared where charts meet, so
// these edges are texture seams. The same options give the same files, as long as the image
// libraries have the same version. Memory: a picture. Errors: those of ClosedGrid::Of;
// InvalidArgument for too few vertices or texels; InputOutput; Cancelled.
Status WriteStatue(
  const StatueOptions& options, const std::filesystem::path& obj, const Execution& execution = {});

}
