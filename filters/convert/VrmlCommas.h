// SPDX-License-Identifier: BSD-3-Clause
// Decides whether commas between digits in a VRML file are separators, as in the format, or decimal
// commas of a program that writes numbers by its system's language. Part of step "convert" of the
// pipeline picture.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace kdstream
{

enum class VrmlCommas : std::uint8_t
{
  Blank,   // they separate numbers
  Decimal, // 1,5 is one and a half
  Either   // undecidable: commas are read as blanks
};

// How a field writes numbers, which are not whole numbers only.
struct VrmlNumbers
{
  std::size_t width = 0; // numbers of a value
  bool isList = false;   // any number of values in brackets, else one value
  std::size_t all = 0;   // how many numbers there should be in a list; 0: not known
};

struct VrmlCommaReading
{
  VrmlCommas commas = VrmlCommas::Blank;
  std::size_t size = 0; // of the numbers, in bytes; not known where commas are blanks
};

// text: what follows a field's name, or the bracket of its list. A decimal comma stands between
// digits, without a blank, and a number has only one; no number has a point then. Where the numbers
// can be read both ways, the first of these rules decides:
// 1. the reading with as many numbers as the field has;
// 2. the reading with whole values;
// 3. decimal, if the digits after a comma begin with 0 and another digit;
// 4. not decimal, if commas between digits stand only between values;
// 5. the reading in which the separators are the same for all values.
//
// O(bytes up to the first number with a point).
VrmlCommaReading ReadVrmlCommas(std::string_view text, const VrmlNumbers& numbers);

}
