// SPDX-License-Identifier: BSD-3-Clause
// Numbers of vertices by place, in a file and, where they fit, in memory: what ranks ask each
// other.
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
  // file: VertexId, `count` of them. memory: up to which they are held. Errors of both functions:
  // InputOutput.
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
