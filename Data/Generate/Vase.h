// SPDX-License-Identifier: BSD-3-Clause
// A painted vase: the demo's coloured model.
#pragma once

#include "Data/Generate/ClosedGrid.h"

#include <cstdint>

namespace kdstream::generate
{

// A hollow, closed vase, about 1.8 high and 1.2 wide, standing on y = 0. The surface itself has
// gadroons around the foot, a twisted rope around the neck and a little grain everywhere. A frieze
// of rosettes, a meander and rims are coloured, and slightly raised. seed: for grain and glaze.
ColoredSurface MakeVase(std::uint64_t seed);

// With this number of columns in a ring, triangles are about as wide as they are high.
inline constexpr double vaseColumnsPerRing = 0.7;

}
