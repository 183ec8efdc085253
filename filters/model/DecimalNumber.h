// SPDX-License-Identifier: BSD-3-Clause
// Converts a decimal number to the nearest double, and back. Internal: not installed.
//
// std::from_chars and std::to_chars do this, but emscripten's C++ library does not have them for
// doubles. strtod and printf would add arithmetic of long doubles to the page, which are 128 bits
// wide on WebAssembly.
#pragma once

#include <string>
#include <string_view>

namespace kdstream
{

// Correctly rounded, ties to even; infinity if the number is too large. O(digits²), for any number
// of digits; those after the first 800 count only as "slightly more". REQUIRES: a number in JSON's
// syntax: -? digits (. digits)? ([eE] [+-]? digits)?
double NearestDouble(std::string_view decimal);

// The shortest decimal that NearestDouble turns into `value`; if there are several, the nearest.
// Written without an exponent from 1e-6 to 1e21: "640.0", "0.000001", "1e-7", "1.5e300", "-0.0".
// REQUIRES: a finite number. O(its exponent).
std::string ShortestDecimal(double value);

}
