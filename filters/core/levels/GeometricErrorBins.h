// SPDX-License-Identifier: BSD-3-Clause
// Estimates in one pass the geometric error that nearly all clusters of a level stay below. The
// grid's spacing for the level depends on it, before any of its pieces is encoded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// A histogram of the clusters' geometric errors, in bins of a 32nd of an octave. The counts of a
// level's parts can be added up. Memory: 64 KiB.
class GeometricErrorBins
{
public:
  // geometricError: not negative.
  void Add(double geometricError);
  std::span<std::uint64_t> Counts() { return this->Bins; }
  // The error that 99 of 100 clusters do not exceed, rounded down to the start of its bin; 0
  // without clusters. O(bins).
  double Most99() const;

private:
  // Drops bits of a float; the exponent and 5 bits of the mantissa are left.
  static constexpr unsigned shift = 18;

  std::vector<std::uint64_t> Bins = std::vector<std::uint64_t>(std::size_t{ 1 } << (31 - shift));
};

}
