// SPDX-License-Identifier: BSD-3-Clause
// A table from the place of a vertex to its number, in a file, and also in memory if it fits. Ranks
// look up entries in each other's tables.
#pragma once

#include "filters/core/Types.h"
#include "filters/outofcore/files/SpillFile.h"

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace kdstream
{

class NumberTable
{
public:
  // file: `count` VertexIds. memory: in bytes; a larger table is not held in memory. Errors of both
  // functions: InputOutput.
  static Result<NumberTable> Open(SpillFile file, std::uint64_t count, std::uint64_t memory);

  // Replaces places, in any order, by the numbers at these places. From the file, O(p log p) for p
  // places and 12 bytes each; the file is read page by page, ascending. REQUIRES: places < count.
  Status Look(std::span<VertexId> places) const;

  SpillFile GiveFile() { return std::move(this->Numbers); }

private:
  SpillFile Numbers;
  std::vector<VertexId> Held;
};

}
