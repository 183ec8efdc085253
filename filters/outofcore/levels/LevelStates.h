// SPDX-License-Identifier: BSD-3-Clause
// What is needed of a level in files, besides the level itself, until the next coarser one is made.
// Only for the levels out of core.
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
  // The offset of the level's vertex colours in a tuple of attributes; nothing if there are none,
  // or if they are not needed.
  std::optional<std::size_t> vertexColors;

  std::size_t TupleBytes() const;
};

struct ClusterState
{
  ClusterSum sum;
  std::uint32_t cellOf = 0;
};

// The state of each cluster, by number. A block needs only those of its own clusters.
struct LevelStates
{
  SpillFile sums;          // ClusterState
  SpillFile components;    // float × components; closed if there are none
  SpillFile attributeSums; // AttributeSums; closed if there are none
  double area = 0;         // sum over all clusters: AddAreas
  // All triangles of the level, each once; counted when they are written.
  std::uint64_t triangles = 0;
};

// Writes the clusters of a level and their states, block after block.
class LevelWriter
{
public:
  // Keeps references to the arguments.
  LevelWriter(LevelFile& level, LevelStates& states, const LevelArrays& arrays)
    : Level(level)
    , States(states)
    , Arrays(arrays)
  {
  }

  // expected: about how many clusters. Errors of both functions: InputOutput.
  Status Begin(SpillFolder& folder, std::uint64_t expected);
  // Appends all clusters of a block without ghosts, and the sums of their attributes.
  Status Append(const CollapseState& block, const AttributeSums& attributes);
  // The number of clusters so far.
  VertexId ClusterCount() const { return this->Level.ClusterCount(); }

private:
  LevelFile& Level;
  LevelStates& States;
  const LevelArrays& Arrays;
};

// Loads the state of a block of a level, with ghosts; the triangles are moved into the state.
// Memory besides the state: 40 bytes a ghost. Errors: InputOutput.
Result<CollapseState> LoadState(
  const LevelFile& level, const LevelStates& states, const LevelArrays& arrays, LevelBlock& block);

// The sums of the attributes of a block's own clusters. Errors: InputOutput.
Result<AttributeSums> LoadAttributeSums(const LevelStates& states, const LevelArrays& arrays,
  VertexId firstCluster, std::size_t clusters);

// Merges the blocks of a level into larger ones, of depth blockDepth, before its triangles are
// written.
void MergeBlocks(LevelFile& level, unsigned blockDepth);

// Replaces each corner by its entry in a file of VertexId. [first, end): the range that most
// corners are in; other entries are read page by page. O(t log t). Errors: InputOutput.
Status MapCorners(
  std::vector<Triangle>& triangles, const SpillFile& map, VertexId first, VertexId end);

}
