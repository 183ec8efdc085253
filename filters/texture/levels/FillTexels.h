// SPDX-License-Identifier: BSD-3-Clause
// Texels between charts. Part of step "encode" of the pipeline picture: texture tiles.
#pragma once

#include <cstdint>
#include <vector>

namespace kdstream
{

// Fills texels that have no colour: each with the mean of those that have one in the smallest
// square of 2^n texels around it that has any; grey where there are none at all. rgba: of a picture
// of this width. O(texels), 27 bytes each. REQUIRES: 4 bytes of rgba for each of hasColor.
void FillTexels(
  std::vector<std::uint8_t>& rgba, const std::vector<bool>& hasColor, std::int64_t width);

}
