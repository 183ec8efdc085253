// SPDX-License-Identifier: BSD-3-Clause
// The header of a PCD file, read and checked against the file's size before PCL takes memory for
// what it claims.
#pragma once

#include "filters/core/Result.h"

#include <cstdint>
#include <filesystem>

namespace kdstream
{

struct PcdHeader
{
  std::uint64_t points = 0;
  std::uint64_t pointBytes = 0; // of one point in memory
  std::uint64_t values = 0;     // of one point
  bool textOfFloats = false;    // decimals of which PCL makes floats: those of x, y and z
};

// Also goes through an ascii body, of which every line must be a point's numbers.
// Errors: InvalidInput saying which line is wrong, or that the file has fewer or more
// points than it claims.
Result<PcdHeader> CheckPcdHeader(const std::filesystem::path& file);

}
