// SPDX-License-Identifier: BSD-3-Clause
// A statue whose texture comes from photographs: the textured model of demos, tests and benchmarks.
#pragma once

#include "Data/Generate/ClosedGrid.h"
#include "filters/core/Execution.h"

#include <cstdint>
#include <filesystem>

namespace kdstream::generate
{

// How the surface is cut into charts for its pictures.
enum class StatueCharts
{
  Few,   // four charts in each picture
  Small, // 576 charts in each picture, in a random order, as photogrammetry makes them
  Udim   // few charts; picture k has the coordinates u from k to k + 1
};

struct StatueOptions
{
  std::uint64_t vertices = 300000; // approximately
  std::size_t pictureSide = 2048;  // texels, at least 64; for small charts at least 256
  std::uint64_t seed = 1;
  StatueCharts charts = StatueCharts::Few;
};

// A closed bust of stone, about 1.8 high, standing on y = 0. It has the colour of stone: bands,
// veins, grain, an inscription around the foot, and dirt. The colour is meant for a texture,
// because its detail is finer than any vertices.
ColoredSurface MakeStatue(std::uint64_t seed);

// Writes NAME.obj, NAME.mtl and NAME-0.jpg, NAME-1.png, NAME-2.jpg, NAME-3.png beside it. Each
// picture shows a quarter of the statue, in charts side by side with a gutter; some charts are
// upside down. Each picture has a slightly different exposure. Vertices are shared where charts
// meet, so these edges are texture seams. The same options give the same files, as long as the
// image libraries have the same version. Memory: a picture. Errors: those of ClosedGrid::Of;
// InvalidArgument for too few vertices or texels; InputOutput; Cancelled.
Status WriteStatue(
  const StatueOptions& options, const std::filesystem::path& obj, const Execution& execution = {});

}
