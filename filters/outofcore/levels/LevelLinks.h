// SPDX-License-Identifier: BSD-3-Clause
// The links of a level by clusters, in a file: pairs of clusters that are connected only by
// collapsed triangles or coincident vertices. A link matters when both ends are in one cell, and so
// in one block; until then any block that owns an end may keep it. Only for the levels out of core.
#pragma once

#include "filters/core/Types.h"
#include "filters/outofcore/levels/LevelFile.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace kdstream
{

// A link is a triangle with two equal corners, so that links are mapped as triangles are.
struct LevelLinks
{
  SpillFile file;                   // Triangle; each in the block of its lower end
  std::vector<std::uint64_t> begin; // first link of each of the level's blocks, and the end

  // Appends those of the blocks [firstBlock, endBlock). Errors: InputOutput.
  Status Load(std::size_t firstBlock, std::size_t endBlock, std::vector<Triangle>& triangles) const;
};

// Writes them, block after block. Errors of both functions: InputOutput.
class LinkWriter
{
public:
  // Keeps references.
  LinkWriter(const LevelFile& level, LevelLinks& links)
    : Level(level)
    , Links(links)
  {
  }

  Status Begin(SpillFolder& folder);
  // Adds the links of the next block: triangles that collapsed to two of the level's clusters, of
  // which the lower is the block's. mapped: all such triangles; it may have others. O(t log t).
  Status Add(const std::vector<Triangle>& mapped);

private:
  const LevelFile& Level;
  LevelLinks& Links;
};

}
