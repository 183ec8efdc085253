// SPDX-License-Identifier: BSD-3-Clause
// Finds a point of a cloud that lies far from all others, and makes the grid coarse for them. For a
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
  double shrinks = 1; // factor by which this point lengthens the longest side of the box
};

// The point without which the longest side of the box shrinks most, if it becomes at least ten
// times shorter. Reads the points of the file once, in blocks. Nothing if they cannot be read, or
// if cancelled.
std::optional<StrayPoint> FindStrayPoint(
  const std::filesystem::path& file, const Execution& execution);

}
