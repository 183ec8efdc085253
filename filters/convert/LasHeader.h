// SPDX-License-Identifier: BSD-3-Clause
// The header of a .las file: what it claims, checked against the file's size.
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
  std::uint64_t pointsBegin = 0; // in the file
  std::uint64_t points = 0;      // as the header counts them
  // End of the space for points: there may be more points than are counted.
  std::uint64_t pointsEnd = 0;
  std::size_t pointBytes = 0, extraBytes = 0; // of a point; more than its format has
  unsigned format = 0;
  bool compressed = false; // LAZ: the file's size does not tell how many points there are
  bool isOldest = false;   // 1.0: a class has its whole byte, and no point is withheld
  Vec3 scale{}, offset{};
  Box box{}; // of the points, as the header states it

  // At which byte of a point its colour is; nothing where it has none.
  std::optional<std::size_t> ColorPlace() const;
  // From format 6 on classes, flags and returns have bytes of their own.
  bool IsLong() const { return this->format >= 6; }
};

// A number of a header or a point. REQUIRES: it is there.
template <class T>
T LasNumberAt(const char* bytes, std::size_t place)
{
  T value;
  std::memcpy(&value, bytes + place, sizeof(value));
  return value;
}

// The most bytes of a header that are looked at.
inline constexpr std::size_t lasHeaderBytes = 375;

// begin: the first bytes of the file, up to lasHeaderBytes. Checks any bytes: that the file has the
// claimed number of points, and a point the claimed fields. Errors: InvalidInput saying what is
// wrong; Unsupported for formats beyond 10; LimitExceeded for more points than a mesh can have.
Result<LasHeader> ParseLasHeader(std::string_view begin, std::uint64_t fileSize);

}
