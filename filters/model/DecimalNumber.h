// SPDX-License-Identifier: BSD-3-Clause
// A decimal number as the double that is nearest to it. Internal: not installed.
//
// std::from_chars does this, but emscripten's C++ library has none for doubles; strtod drags in
// arithmetic of long doubles, 128 bits wide on WebAssembly; RapidJSON 1.1 is wrong near 0.
#pragma once

#include <string_view>

namespace kdstream
{

// Correctly rounded, ties to even; infinite where it is too large. O(digits²), for any number of
// digits, but those behind the first 800 count only as "and a bit more".
// REQUIRES: a number as JSON has it: -? digits (. digits)? ([eE] [+-]? digits)?
double NearestDouble(std::string_view decimal);

}
