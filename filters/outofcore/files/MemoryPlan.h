// SPDX-License-Identifier: BSD-3-Clause
// How a memory limit is divided among the buffers of the steps out of core.
#pragma once

#include "filters/outofcore/files/BatchPass.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace kdstream
{

// The blocks of a pass that takes about `memory` bytes and stores nothing else. Each block is in
// memory twice, as input and as output.
inline BatchShape ShapeOfPass(std::uint64_t memory, std::size_t recordBytes)
{
  constexpr std::size_t slots = 8;
  return { slots, static_cast<std::size_t>(std::clamp<std::uint64_t>(
                    memory / (2 * slots * recordBytes), 1, spillBlockBytes / recordBytes)) };
}

// How the parts of a pass share the memory limit: a quarter for blocks, an eighth for records that
// are kept, an eighth for histograms, and half for the median method. A cell in memory may use all
// of it.
struct MemoryPlan
{
  // The smallest limit for records of a given size.
  static constexpr std::uint64_t Least(std::size_t recordBytes) { return 64 * recordBytes; }

  // REQUIRES: memory >= Least(recordBytes).
  MemoryPlan(std::uint64_t memory, std::size_t recordBytes)
    : cellRecords(memory / recordBytes)
    , keepable(std::max<std::uint64_t>(1, memory / 8 / recordBytes))
    , method(memory / 2)
  {
    // A block is in memory twice: as it was read, and divided into halves (or as keys, which are
    // not larger).
    const std::uint64_t records = memory / 4 / (2 * recordBytes);
    const std::uint64_t large = largeBlockBytes / recordBytes;
    this->shape.slots =
      static_cast<std::size_t>(std::clamp<std::uint64_t>(records / large, 1, mostSlots));
    this->shape.blockRecords =
      static_cast<std::size_t>(std::clamp<std::uint64_t>(records / this->shape.slots, 1, large));
    // Two cells × three axes × 4 bytes a bin.
    while (this->bits > 4 && (std::uint64_t{ 24 } << this->bits) * this->shape.slots > memory / 8)
    {
      --this->bits;
    }
  }

  BatchShape shape;
  std::uint64_t cellRecords; // maximum number of records of a cell that is finished in memory
  std::uint64_t keepable;    // maximum number of records around a median that a pass may keep
  std::uint64_t method;      // bytes for the median method
  unsigned bits = 12;        // of the histograms that are gathered during other work

private:
  static constexpr std::uint64_t largeBlockBytes = 2 * spillBlockBytes;
  static constexpr std::uint64_t mostSlots = 8;
};

}
