// SPDX-License-Identifier: BSD-3-Clause
// A painted vase: the demo's coloured model.
#pragma once

#include "Data/Generate/ClosedGrid.h"

#include <cstdint>

namespace kdstream::generate
{

// About 1.8 high and 1.2 wide, standing on y = 0; hollow, closed. Gadroons around its foot, a
// twisted rope around its neck and a little grain everywhere are in the surface itself; a frieze of
// rosettes, a meander and rims are coloured, and raised a little. seed: of grain and glaze.
ColoredSurface MakeVase(std::uint64_t seed);

// With this number of columns in a ring, triangles are about as wide as high.
inline constexpr double vaseColumnsPerRing = 0.7;

}
