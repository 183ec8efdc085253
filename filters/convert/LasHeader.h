// SPDX-License-Identifier: BSD-3-Clause
// The header of a .las file: its claims, checked against the file's size.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/Types.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>

namespace kdstream
{

// Versions 1.0 to 1.4 (ASPRS, "LAS Specification 1.4 - R15", 2019), point formats 0 to 10.
struct LasHeader
{
  std::uint64_t pointsBegin = 0; // offset in the file
  std::uint64_t points = 0;      // as the header counts them
  // End of the space for points, which may hold more points than the header counts.
  std::uint64_t pointsEnd = 0;
  std::size_t pointBytes = 0, extraBytes = 0; // bytes of a point; those beyond its format
  unsigned format = 0;
  bool compressed = false; // LAZ: the file's size does not show the number of points
  bool isOldest = false;   // 1.0: a class takes a whole byte; no point is withheld
  Vec3 scale{}, offset{};
  Box box{}; // of the points, as the header states it

  // The offset of the colour in a point; nothing if it has no colour.
  std::optional<std::size_t> ColorPlace() const;
  // From format 6 on, classes, flags and returns have their own bytes.
  bool IsLong() const { return this->format >= 6; }
};

// Reads a number of a header or a point. REQUIRES: the bytes are in memory.
template <class T>
T LasNumberAt(const char* bytes, std::size_t place)
{
  T value;
  std::memcpy(&value, bytes + place, sizeof(value));
  return value;
}

// How many bytes of a header are looked at, at most.
inline constexpr std::size_t lasHeaderBytes = 375;

// begin: the first bytes of the file, up to lasHeaderBytes. Accepts any bytes, and checks that the
// file is large enough for the claimed number of points, and a point for the claimed fields.
// Errors: InvalidInput saying what is wrong; Unsupported for formats beyond 10; LimitExceeded for
// more points than a mesh can have.
Result<LasHeader> ParseLasHeader(std::string_view begin, std::uint64_t fileSize);

}
