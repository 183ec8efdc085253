// SPDX-License-Identifier: BSD-3-Clause
// The header of a PCD file. It is checked against the file's size before PCL allocates memory for
// its claims.
#pragma once

#include "filters/core/Result.h"
#include "filters/meshio/Tolerance.h"

#include <cstdint>
#include <filesystem>
#include <string>

namespace kdstream
{

enum class PcdData
{
  Ascii,
  Binary,
  Compressed
};

struct PcdHeader
{
  std::uint64_t points = 0;     // in the file: at least the claimed number
  std::uint64_t pointBytes = 0; // bytes of one point in memory
  std::uint64_t values = 0;     // numbers of one point
  PcdData data = PcdData::Ascii;
  std::uint64_t bodyBegin = 0; // offset in the file
  std::string text;            // an equivalent header in the form that PCL reads
  Tolerance tolerance;         // of data that the header does not count
  bool hasOddLines = false;    // lines of points with #, with only \r at their end, with
                               // Fortran's exponents or numbers such as 1.#QNAN: PCL does not know
                               // these
  bool hasViewpoint = false;   // the scanner's position is given
  bool textOfFloats = false;   // PCL reads x, y and z as floats, which lose decimals
};

// Reads the header, and if the body is ascii, the body, too: every line must have the numbers of
// one point. Keywords, and names of fields with a meaning, may be in any case. VERSION, COUNT,
// HEIGHT, VIEWPOINT and POINTS may be missing. Errors: InvalidInput saying which line is wrong, or
// that the file has fewer points than it claims.
Result<PcdHeader> CheckPcdHeader(const std::filesystem::path& file);

}
