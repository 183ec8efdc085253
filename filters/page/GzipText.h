// SPDX-License-Identifier: BSD-3-Clause
// Compresses texts by gzip, as hosts send them.
#pragma once

#include "filters/core/Result.h"

#include <string>
#include <string_view>

namespace kdstream
{

// level: of zlib, 1 (fast) to 9. Errors: LimitExceeded if there is not enough memory.
Result<std::string> GzipText(std::string_view text, int level);

}
