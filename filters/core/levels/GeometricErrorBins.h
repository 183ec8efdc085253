// SPDX-License-Identifier: BSD-3-Clause
// About how far nearly all clusters of a level lie off, found in one pass: how coarse a grid the
// level can do with depends on it, before any of its pieces is encoded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// How many clusters deviate by how much, in bins of a 32nd of an octave. Of a level in parts the
// counts are added up. 64 KiB.
class GeometricErrorBins
{
public:
  // deviation: not negative.
  void Add(double deviation);
  std::span<std::uint64_t> Counts() { return this->Bins; }
  // At most, and hardly less than, what 99 of 100 do not exceed; 0 if there are none. O(bins).
  double Most99() const;

private:
  // Of a float's bits: the exponent and 5 of the mantissa are left.
  static constexpr unsigned shift = 18;

  std::vector<std::uint64_t> Bins = std::vector<std::uint64_t>(std::size_t{ 1 } << (31 - shift));
};

}
