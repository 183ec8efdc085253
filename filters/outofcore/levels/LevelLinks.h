// SPDX-License-Identifier: BSD-3-Clause
// The links of a level by clusters, in a file. A link is a pair of clusters that are connected only
// by collapsed triangles or coincident vertices. It matters once both ends are in one cell, and so
// in one block; until then any block that owns an end may hold it. Only for the levels out of core.
#pragma once

#include "filters/core/Types.h"
#include "filters/outofcore/levels/LevelFile.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace kdstream
{

// A link is stored as a triangle with two equal corners, so that links are mapped as triangles are.
struct LevelLinks
{
  SpillFile file;                   // Triangle; each in the block that owns its lower end
  std::vector<std::uint64_t> begin; // first link of each of the level's blocks, and the end

  // Appends the links of the blocks [firstBlock, endBlock). Errors: InputOutput.
  Status Load(std::size_t firstBlock, std::size_t endBlock, std::vector<Triangle>& triangles) const;
};

// Writes links, block after block. Errors of both functions: InputOutput.
class LinkWriter
{
public:
  // Keeps references to both arguments.
  LinkWriter(const LevelFile& level, LevelLinks& links)
    : Level(level)
    , Links(links)
  {
  }

  Status Begin(SpillFolder& folder);
  // Adds the links of the next block: those whose lower cluster the block owns. mapped: must
  // contain all triangles that collapsed to links of this block; others are ignored. O(t log t).
  Status Add(const std::vector<Triangle>& mapped);

private:
  const LevelFile& Level;
  LevelLinks& Links;
};

}
