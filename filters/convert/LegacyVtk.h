// SPDX-License-Identifier: BSD-3-Clause
// Finds where a legacy .vtk file is damaged. VTK's reader says that it is damaged, but seldom
// where. Part of step "convert".
#pragma once

#include "filters/meshio/Tolerance.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace kdstream
{

// Parts that VTK does not read in their place, as byte ranges.
struct VtkOrder
{
  // Where the line of DATASET is, if parts come before it; else zeros.
  std::uint64_t headEnd = 0, begin = 0, end = 0;
  // Blocks of METADATA that follow no array, and what is after the last part: in the order of the
  // file, from begin to end.
  std::vector<std::array<std::uint64_t, 2>> leftOut{};
};

struct VtkDamage
{
  // The first part that differs from its header, for a message: "POINTS (line 5) has 20 of its 24
  // numbers, then 'POLYGONS' (line 12)"; in a list of cells it names the cell. Places in binary
  // files are byte offsets. Empty: nothing was found, or the file cannot be read.
  std::string part;
  // Whether numbers are missing. VTK crashes on such lists of cells, and silently reads less of
  // other lists.
  bool isCut = false;
  // The unknown keyword at which the file is damaged, in lower case. VTK reports it too, unless VTK
  // knows the keyword and something else is wrong.
  std::string unknownWord{};
  // A text has numbers that VTK does not read: not finite ones, and exponents of Fortran.
  bool hasOtherNumbers = false;
  VtkOrder order{};
  // For a message where no part is damaged: "something after POINTS (line 5) cannot be read".
  std::string lastPart{};
  Tolerance forgiven{}; // cells that their part does not count, bytes after the last part
};

// Goes through the file once, in the memory of a block.
VtkDamage FindVtkDamage(const std::filesystem::path& file);

}
