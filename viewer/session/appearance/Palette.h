// SPDX-License-Identifier: BSD-3-Clause
// The colours of partitions and resolutions. Step "draw" of the pipeline picture.
#pragma once

#include "filters/core/Types.h"

#include <array>
#include <cstdint>

namespace kdstream
{

using Color = std::array<std::uint8_t, 3>; // red, green, blue

enum class SurfaceColoring
{
  Own,        // the colours that the model came with (OwnColors in SceneRules.h), else stone
  Stone,      // one neutral material
  Partition,  // one colour for each partition; vertices coarser than S have no partition: stone
  Resolution, // one colour for each resolution
  Attribute   // by a number that each vertex has (Coloring.h)
};

// A colour for every partition. Partitions with neighbouring numbers, which are mostly neighbours
// in space, have very different hues.
Color PartitionColor(std::uint32_t partition);

// A colour for every resolution; gold for the original.
Color ResolutionColor(Resolution resolution);

// The colour of stone, for everything without a colour of its own.
inline constexpr Color stoneColor{ 217, 208, 192 };

}
