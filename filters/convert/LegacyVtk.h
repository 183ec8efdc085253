// SPDX-License-Identifier: BSD-3-Clause
// Finds where a legacy .vtk file is damaged. VTK's reader reports the damage, but seldom where it
// is. Part of step "convert".
#pragma once

#include "filters/meshio/Tolerance.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace kdstream
{

// Byte ranges of parts that VTK does not read at their place in the file.
struct VtkOrder
{
  // Where the DATASET line is, and where the head before it ends, if there are parts before
  // DATASET; else zeros.
  std::uint64_t headEnd = 0, begin = 0, end = 0;
  // Blocks of METADATA that follow no array, and bytes after the last part, as ranges from begin to
  // end, in the order of the file.
  std::vector<std::array<std::uint64_t, 2>> leftOut{};
};

struct VtkDamage
{
  // The first part that differs from its header, for a message: "POINTS (line 5) has 20 of its 24
  // numbers, then 'POLYGONS' (line 12)". In a list of cells it names the cell. In binary files,
  // places are byte offsets. Empty if nothing was found, or the file cannot be read.
  std::string part;
  // Whether numbers are missing. VTK crashes if a list of cells is too short, and silently reads
  // fewer values if another list is.
  bool isCut = false;
  // The unknown keyword, in lower case, at which the file is damaged. VTK reports the same keyword;
  // if it does not, it knows the keyword, and something else is wrong.
  std::string unknownWord{};
  // Whether a text has numbers that VTK does not read: ones that are not finite, or with Fortran's
  // exponents.
  bool hasOtherNumbers = false;
  VtkOrder order{};
  // Names the last part, for a message if no part is damaged: "something after POINTS (line 5)
  // cannot be read".
  std::string lastPart{};
  Tolerance forgiven{}; // cells beyond a part's count, bytes after the last part
};

// Reads the file once. Memory: one block.
VtkDamage FindVtkDamage(const std::filesystem::path& file);

}
