// SPDX-License-Identifier: BSD-3-Clause
// A decimal number as the double that is nearest to it, and back. Internal: not installed.
//
// std::from_chars and std::to_chars do this, but emscripten's C++ library has none for doubles;
// strtod and printf drag in arithmetic of long doubles, 128 bits wide on WebAssembly.
#pragma once

#include <string>
#include <string_view>

namespace kdstream
{

// Correctly rounded, ties to even; infinite where it is too large. O(digits²), for any number of
// digits, but those after the first 800 count only as "and a bit more".
// REQUIRES: a number as JSON has it: -? digits (. digits)? ([eE] [+-]? digits)?
double NearestDouble(std::string_view decimal);

// The fewest digits of which NearestDouble makes `value` again; of several numbers with so few the
// nearest. Without an exponent from 1e-6 to 1e21: "640.0", "0.000001", "1e-7", "1.5e300", "-0.0".
// REQUIRES: a finite number. O(its exponent).
std::string ShortestDecimal(double value);

}
