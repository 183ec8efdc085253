// SPDX-License-Identifier: BSD-3-Clause
// In how many different places the vertices of a mesh are that does not fit the memory.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/core/tree/PointRecord.h"
#include "filters/outofcore/files/SpillFile.h"

#include <cstdint>
#include <functional>

namespace kdstream
{

// What core's CountPlaces counts (Weld.h; -0.0 and 0.0 are the same place), of the records of a
// tree in any order. placeOf: maps a point to a place, such as its place on a grid; empty: the
// point itself; called by several threads. Places are compared by 64 bits of a hash: among n
// different ones, two are equal with a probability of n^2 / 2^65, and the count is then one too
// low. This is exact enough for a warning, but not for other uses. Two passes over the records. If
// the hashes that may be repeated do not fit the memory, one more pass, and all hashes are written
// and read once. Peak memory: `memory` and a few blocks, whatever places are equal. Errors:
// InputOutput; Cancelled.
template <class Scalar>
Result<std::uint64_t> CountPlacesExternally(SpillFolder& folder, const SpillFile& records,
  std::uint32_t count, const std::function<Vec3(const Vec3&)>& placeOf, std::uint64_t memory,
  const Execution& execution = {});

extern template Result<std::uint64_t> CountPlacesExternally<float>(SpillFolder&, const SpillFile&,
  std::uint32_t, const std::function<Vec3(const Vec3&)>&, std::uint64_t, const Execution&);
extern template Result<std::uint64_t> CountPlacesExternally<double>(SpillFolder&, const SpillFile&,
  std::uint32_t, const std::function<Vec3(const Vec3&)>&, std::uint64_t, const Execution&);

}
