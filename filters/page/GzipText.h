// SPDX-License-Identifier: BSD-3-Clause
// Texts as hosts send them: compressed by gzip.
#pragma once

#include "filters/core/Result.h"

#include <string>
#include <string_view>

namespace kdstream
{

// level: of zlib, 1 (fast) to 9. Errors: LimitExceeded for lack of memory.
Result<std::string> GzipText(std::string_view text, int level);

}
