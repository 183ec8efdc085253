// SPDX-License-Identifier: BSD-3-Clause
// The processes that build one model together, each with some of its blocks. The interface between
// the steps out of core and the transport between processes (filters/Parallel).
//
// A file has the same layout in all processes. Each process fills in its own data. It fetches the
// data of others that its blocks need, and writes them at the same places in its own file. The rest
// of its file stays empty.
#pragma once

#include "filters/core/Types.h"
#include "filters/core/levels/LevelBlocks.h"
#include "filters/outofcore/files/SpillFile.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// A group of one process; subclasses implement groups of several. All processes call the functions
// from Sum on in the same order. Errors: those of the files and of the transport; an error in any
// process is an error in all.
class BlockGroup
{
public:
  virtual ~BlockGroup() = default;

  virtual bool IsFirst() const { return true; }
  // The range of blocks (cells of `depth`) that this process has.
  virtual BlockRange Here(unsigned depth) const { return { 0, std::size_t{ 1 } << depth }; }

  // Adds up the numbers of all processes, element by element.
  virtual Status Sum(std::span<std::uint64_t>) { return {}; }
  // The greatest number of any process.
  virtual Result<std::uint64_t> Most(std::uint64_t number) { return number; }
  // Gives all processes the list of the first one.
  virtual Status Spread(std::vector<VertexId>&) { return {}; }
  // Fetches elements of a file whose blocks are cells of `depth`. begin[block] is the first element
  // of a block; the last entry is the end. wanted: numbers of elements, in any order; those of this
  // process are skipped.
  virtual Status Fetch(SpillFile& /*file*/, std::size_t /*elementBytes*/,
    std::span<const VertexId> /*begin*/, unsigned /*depth*/, std::span<const VertexId> /*wanted*/)
  {
    return {};
  }
};

}
