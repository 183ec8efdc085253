// SPDX-License-Identifier: BSD-3-Clause
// Counts the distinct places of the vertices of a mesh that does not fit in memory.
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

// Counts what core's CountPlaces does (Weld.h; -0.0 and 0.0 are the same place), for the records of
// a tree in any order. placeOf: maps a point to a place, such as its place on a grid; called by
// several threads; if it is empty, the place is the point itself. Places are compared by a 64-bit
// hash. Among n distinct places, two have the same hash with a probability of n^2 / 2^65; the count
// is then one too low. This is exact enough for a warning, but not for other uses. Two passes over
// the records. If the hashes that may occur more than once do not fit in memory, there is one more
// pass, and all hashes are written and read once. Peak memory: `memory` and a few blocks, whichever
// places are equal. Errors: InputOutput; Cancelled.
template <class Scalar>
Result<std::uint64_t> CountPlacesExternally(SpillFolder& folder, const SpillFile& records,
  std::uint32_t count, const std::function<Vec3(const Vec3&)>& placeOf, std::uint64_t memory,
  const Execution& execution = {});

extern template Result<std::uint64_t> CountPlacesExternally<float>(SpillFolder&, const SpillFile&,
  std::uint32_t, const std::function<Vec3(const Vec3&)>&, std::uint64_t, const Execution&);
extern template Result<std::uint64_t> CountPlacesExternally<double>(SpillFolder&, const SpillFile&,
  std::uint32_t, const std::function<Vec3(const Vec3&)>&, std::uint64_t, const Execution&);

}
