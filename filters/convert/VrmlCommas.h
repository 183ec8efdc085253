// SPDX-License-Identifier: BSD-3-Clause
// Decides what commas between digits in a VRML file are: separators, as in the format, or decimal
// commas, from a program that writes numbers in its system's language. Part of step "convert" of
// the pipeline picture.
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

// How a field writes numbers; for fields whose numbers need not be whole.
struct VrmlNumbers
{
  std::size_t width = 0; // how many numbers make up a value
  bool isList = false;   // any number of values in brackets; else one value
  std::size_t all = 0;   // how many numbers a list should have; 0 if not known
};

struct VrmlCommaReading
{
  VrmlCommas commas = VrmlCommas::Blank;
  std::size_t size = 0; // of the numbers, in bytes; unset if commas are blanks
};

// text: begins after a field's name, or after the bracket of its list. A decimal comma stands
// between digits, without a blank, and a number has only one. If there are decimal commas, no
// number has a point. If the numbers can be read both ways, the first of these rules decides:
// 1. the reading with as many numbers as the field should have;
// 2. the reading with only complete values;
// 3. decimal, if the digits after a comma begin with 0 and another digit;
// 4. not decimal, if commas between digits occur only between values;
// 5. the reading in which the separators are the same for all values.
//
// O(bytes up to the first number with a point).
VrmlCommaReading ReadVrmlCommas(std::string_view text, const VrmlNumbers& numbers);

}
