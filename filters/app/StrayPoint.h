// SPDX-License-Identifier: BSD-3-Clause
// Finds a point of a cloud that lies far from all others: it makes the grid coarse for them. For a
// warning of kdstream-build.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Types.h"

#include <cstdint>
#include <filesystem>
#include <optional>

namespace kdstream
{

struct StrayPoint
{
  std::uint64_t number = 0; // among the finite points of the file
  Vec3 place{};
  double shrinks = 1; // how many times longer the longest side of the box is with it
};

// The point without which the box's longest side shrinks most, if that is at least tenfold. Reads
// the file's points once, in blocks. Nothing where they cannot be read, or on a cancel.
std::optional<StrayPoint> FindStrayPoint(
  const std::filesystem::path& file, const Execution& execution);

}
