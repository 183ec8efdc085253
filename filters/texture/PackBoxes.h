// SPDX-License-Identifier: BSD-3-Clause
// Packs boxes into a picture. Part of step "encode" of the pipeline picture: texture tiles.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace kdstream
{

struct PackedBoxes
{
  std::int64_t width = 1, height = 1;
  std::vector<std::array<std::int64_t, 2>> places; // the upper left corner of each box
};

// Places boxes of these widths and heights (at least 1) side by side, without overlap, on shelves:
// the highest first, from left to right and from top to bottom. Tries a few widths, and takes the
// one with the smallest area whose sides are at most mostSide. Returns nothing if none fits. O(n
// log n). Deterministic. Source: next fit with decreasing heights (E. G. Coffman et al., SIAM J.
// Comput. 9(4), 1980).
std::optional<PackedBoxes> PackBoxes(
  std::span<const std::array<std::int64_t, 2>> sizes, std::int64_t mostSide);

}
