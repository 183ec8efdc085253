// SPDX-License-Identifier: BSD-3-Clause
// What the numbers after an OBJ vertex's coordinates mean: colours or normals. Part of step "read".
#pragma once

#include "filters/meshio/ShownColors.h"
#include "filters/meshio/Tolerance.h"

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace kdstream
{

struct ObjPlaceColumns
{
  enum class What
  {
    Nothing,
    Colors,
    Normals
  };
  What what = What::Nothing;
  std::size_t at = 3;    // the number of a vertex, from 0, that is the first of three
  double scale = 1;      // of a colour to 255
  std::string ignored{}; // the numbers that are not read; empty: all are read
};

// Looks at the numbers of all vertices, then decides. O(1) a vertex.
class ObjPlaceNumbers
{
public:
  // text: what a vertex has after x y z. What is not a number is refused when it is read.
  void Add(std::string_view text);
  // Three numbers are normals if most of them have length one and some are negative, else colours
  // (ColorWhite). If a line has seven or more numbers, the first three after x y z count. But if
  // the first of them is 1 for all vertices, and the last is not opaque for all, the first is a
  // weight, and the next three count. Nothing if some vertices have no such numbers. normalsNamed:
  // whether faces name other normals. Ambiguous cases are reported.
  ObjPlaceColumns Decide(std::uint64_t vertices, bool normalsNamed, Tolerance& tolerance) const;

private:
  // Of three numbers.
  struct Triple
  {
    ColorWhite white;
    std::uint64_t unit = 0; // vectors of length one
    bool negative = false;
  };

  std::uint64_t Weights = 0;        // vertices of four numbers, the last of which is not 1
  std::uint64_t Two = 0;            // vertices of five numbers
  std::uint64_t Six = 0, Seven = 0; // vertices of as many numbers at least
  bool WeightOne = true, LastOpaque = true;
  // The three numbers after the coordinates, and the three after these.
  std::array<Triple, 2> Triples;
};

}
