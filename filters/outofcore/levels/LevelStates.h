// SPDX-License-Identifier: BSD-3-Clause
// What makers of levels need of a level in files, in addition to the level itself, until the next
// coarser one is made. Only for the levels out of core.
#pragma once

#include "filters/core/levels/CollapseState.h"
#include "filters/core/levels/LevelAttributes.h"
#include "filters/outofcore/files/RecordFile.h"
#include "filters/outofcore/files/SpillFile.h"
#include "filters/outofcore/levels/LevelFile.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace kdstream
{

// The arrays of a mesh that take part in levels.
struct LevelArrays
{
  std::size_t components = 0;            // of CollapseAttributes
  std::vector<AttributeInfo> attributes; // that levels carry
  // The place of the level's vertex colours in a tuple of attributes; nothing if there are none, or
  // if they are not needed.
  std::optional<std::size_t> vertexColors;

  std::size_t TupleBytes() const;
};

struct ClusterState
{
  ClusterSum sum;
  std::uint32_t cellOf = 0;
};

// The state of each cluster, by number. Blocks need only those of their own clusters.
struct LevelStates
{
  SpillFile sums;          // ClusterState
  SpillFile components;    // float × components; closed if there are none
  SpillFile attributeSums; // AttributeSums; closed if there are none
  double area = 0;         // of all clusters: AddAreas
  // All the level's, each once; counted when they are written.
  std::uint64_t triangles = 0;
};

// Writes the clusters of a level and their states, block after block.
class LevelWriter
{
public:
  // Keeps references.
  LevelWriter(LevelFile& level, LevelStates& states, const LevelArrays& arrays)
    : Level(level)
    , States(states)
    , Arrays(arrays)
  {
  }

  // expected: clusters, about. Errors of both: InputOutput.
  Status Begin(SpillFolder& folder, std::uint64_t expected);
  // All of a state without ghosts, and the sums of its attributes.
  Status Append(const CollapseState& block, const AttributeSums& attributes);
  // The number of clusters so far.
  VertexId ClusterCount() const { return this->Level.ClusterCount(); }

private:
  LevelFile& Level;
  LevelStates& States;
  const LevelArrays& Arrays;
};

// A block of a level with its ghosts; its triangles move into the state. Memory beside it: 40 bytes
// a ghost. Errors: InputOutput.
Result<CollapseState> LoadState(
  const LevelFile& level, const LevelStates& states, const LevelArrays& arrays, LevelBlock& block);

// The attributes' sums of a block's own clusters. Errors: InputOutput.
Result<AttributeSums> LoadAttributeSums(const LevelStates& states, const LevelArrays& arrays,
  VertexId firstCluster, std::size_t clusters);

// Merges the level's blocks into larger ones of a smaller depth, before its triangles are written.
void MergeBlocks(LevelFile& level, unsigned blockDepth);

// Replaces each corner by the entry of a file of VertexId at its place. [first, end): where most
// corners are; the others are read page by page. O(t log t). Errors: InputOutput.
Status MapCorners(
  std::vector<Triangle>& triangles, const SpillFile& map, VertexId first, VertexId end);

}
