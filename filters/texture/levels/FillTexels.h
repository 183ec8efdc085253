// SPDX-License-Identifier: BSD-3-Clause
// Fills the texels between charts. Part of step "encode" of the pipeline picture: texture tiles.
#pragma once

#include <cstdint>
#include <vector>

namespace kdstream
{

// Fills texels that have no colour. Each gets the mean of the coloured texels in the smallest
// square of 2^n texels around it that has any; grey if there are none at all. rgba: a picture of
// this width. O(texels); 27 bytes for each texel. REQUIRES: 4 bytes of rgba for each element of
// hasColor.
void FillTexels(
  std::vector<std::uint8_t>& rgba, const std::vector<bool>& hasColor, std::int64_t width);

}
