// SPDX-License-Identifier: BSD-3-Clause
// Encodes a picture as a JPEG in memory, for servers: an error ends only this call. Internal to
// filters/page.
#pragma once

#include "filters/core/Result.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// rgb: rows from the top, three bytes a pixel. REQUIRES: 3 · width · height bytes; width and height
// are from 1 to 65,500. Errors: LimitExceeded if there is not enough memory.
Result<std::vector<std::uint8_t>> JpegBytes(
  std::span<const std::uint8_t> rgb, unsigned width, unsigned height);

}
