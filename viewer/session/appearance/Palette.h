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
  Partition,  // a colour a partition; below the stitch depth vertices have none, and stay stone
  Resolution, // a colour a resolution
  Attribute   // what a number of each vertex looks like (Coloring.h)
};

// A colour for every partition; neighbours in number, and so mostly in space, lie far apart in hue.
Color PartitionColor(std::uint32_t partition);

// A colour for every resolution; gold for the original.
Color ResolutionColor(Resolution resolution);

// The stone that everything without a colour of its own is made of.
inline constexpr Color stoneColor{ 217, 208, 192 };

}
