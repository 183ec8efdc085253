// SPDX-License-Identifier: BSD-3-Clause
// A picture as a JPEG in memory, for servers: what fails ends nothing but this call. Internal to
// filters/page.
#pragma once

#include "filters/core/Result.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// rgb: rows from the top, three bytes a pixel. REQUIRES: 3 · width · height bytes, neither is 0 or
// above 65,500. Errors: LimitExceeded for lack of memory.
Result<std::vector<std::uint8_t>> JpegBytes(
  std::span<const std::uint8_t> rgb, unsigned width, unsigned height);

}
