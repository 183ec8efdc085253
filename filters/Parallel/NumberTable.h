// SPDX-License-Identifier: BSD-3-Clause
// A table from place to number of a vertex, in a file, and in memory where it fits. Ranks ask each
// other for its entries.
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
  // file: `count` VertexIds. memory: the table is held in memory if it is not larger. Errors of
  // both functions: InputOutput.
  static Result<NumberTable> Open(SpillFile file, std::uint64_t count, std::uint64_t memory);

  // Replaces places, in any order, by the numbers there. From the file O(p log p) for p places, 12
  // bytes each; it is read page by page, ascending. REQUIRES: places < count.
  Status Look(std::span<VertexId> places) const;

  SpillFile GiveFile() { return std::move(this->Numbers); }

private:
  SpillFile Numbers;
  std::vector<VertexId> Held;
};

}
