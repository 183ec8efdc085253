// SPDX-License-Identifier: BSD-3-Clause
// Commas between digits in a VRML file: blanks, as the format has it, or decimal commas of a
// program that writes numbers as its system's language does. Part of step "convert" of the pipeline
// picture.
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
  Either   // nothing tells: they are read as blanks
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

// text: what is behind a field's name, or behind the bracket of its list. Decimal commas stand
// between digits, without a blank, one for a number, and no number has a point. Where the numbers
// could be meant both ways, that is taken which gives as many as the field has, or whole values;
// in which a number begins with two digits of which the first is 0; or in which what separates the
// numbers is the same for all values. O(bytes up to the first number with a point).
VrmlCommaReading ReadVrmlCommas(std::string_view text, const VrmlNumbers& numbers);

}
