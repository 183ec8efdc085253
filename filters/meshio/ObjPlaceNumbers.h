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
  std::size_t at = 3;    // index of the first of the three numbers, from 0
  double scale = 1;      // factor from a colour to 0 … 255
  std::string ignored{}; // the numbers that are not read; empty: all are read
};

// Looks at the numbers of all vertices, then decides. O(1) a vertex.
class ObjPlaceNumbers
{
public:
  // text: the numbers that follow x y z of a vertex. Words that are not numbers are refused later,
  // when they are read.
  void Add(std::string_view text);
  // Three numbers are normals if most of them have length one and some are negative; else they are
  // colours (ColorWhite). If a line has seven or more numbers, the three after x y z count. There
  // is one exception: if the first of them is 1 for all vertices and the last is not opaque for
  // all, the first is a weight, and the next three count. If some vertices have no such numbers,
  // nothing is read. normalsNamed: whether faces name other normals. Ambiguous cases are reported.
  ObjPlaceColumns Decide(std::uint64_t vertices, bool normalsNamed, Tolerance& tolerance) const;

private:
  // What is known of three numbers, over all vertices.
  struct Triple
  {
    ColorWhite white;
    std::uint64_t unit = 0; // vectors of length one
    bool negative = false;
  };

  std::uint64_t Weights = 0;        // vertices of four numbers, if the last is not 1
  std::uint64_t Two = 0;            // vertices of five numbers
  std::uint64_t Six = 0, Seven = 0; // vertices of at least six, or seven
  bool WeightOne = true, LastOpaque = true;
  // The three numbers after the coordinates, and the three that begin one number later.
  std::array<Triple, 2> Triples;
};

}
