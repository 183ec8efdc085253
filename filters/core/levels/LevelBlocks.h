// SPDX-License-Identifier: BSD-3-Clause
// A level in blocks, as a round of collapses visits it: in memory or in files. Only for the makers
// of levels.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/collapse/EdgeCollapse.h"
#include "filters/core/levels/CollapseState.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// The merges of one part, in the order in which they were made; errors never decrease. Clusters are
// numbered from the block's first own one.
struct MergeList
{
  std::vector<Merge> merges;
  std::uint32_t own = 0; // clusters with triangles at first
  bool stuck = false;    // no edge can collapse any more
  bool whole = false;    // no more merges can be added to the list
};

// Which steps the targets of clusters take into account.
enum class TargetStage
{
  Merged, // merges of edges only
  Grouped // also that clusters of overfull nodes were grouped by cells
};

// Blocks that follow each other.
struct BlockRange
{
  std::size_t begin = 0, end = 0;
};

// How a round of collapses accesses a level. Blocks are the cells of one depth; parts are nodes of
// the same or a larger depth, each in one block. Implementations decide where the data are: one
// block, or two (LoadAhead), are in memory at a time.
class LevelBlocks
{
public:
  virtual ~LevelBlocks() = default;

  // A power of two.
  virtual std::size_t Count() const = 0;
  // The blocks of this process, if several processes make a level together. Each process visits its
  // own blocks, and calls all functions from Alone() on in the same order as the other processes.
  virtual BlockRange Here() const { return { 0, this->Count() }; }
  virtual bool Alone() const { return true; }
  // Adds up the numbers of all processes, element by element.
  virtual Status Sum(std::span<std::uint64_t>) { return {}; }
  // parts: the same number of bytes for each part of the level. Fills in the bytes of the parts of
  // other processes.
  virtual Status ShareParts(std::span<std::byte>) { return {}; }
  // Called when all targets of a stage are kept: gets the targets of ghosts that other processes
  // own.
  virtual Status ShareTargets(TargetStage) { return {}; }

  // Area of the triangles of all clusters (AddAreas) / number of clusters.
  virtual double AreaPerCluster() const = 0;
  // Fetches the block that Load will be asked for next. Called on another thread than the one that
  // uses the current block. Load reports the errors.
  virtual void LoadAhead(std::size_t /*block*/) {}
  // Loads a block; the result is valid until another block is loaded.
  virtual Result<const CollapseState*> Load(std::size_t block) = 0;

  // Keeps the merge lists of the block's parts, in the order of the parts. The result of Lists is
  // valid until it is called for another block.
  virtual Status KeepLists(std::size_t block, std::vector<MergeList>&& lists) = 0;
  virtual Result<std::vector<MergeList>*> Lists(std::size_t block) = 0;

  // Keeps the cluster to which each own cluster of a block goes, numbered from the first own one.
  virtual Status KeepTargets(
    std::size_t block, TargetStage stage, std::span<const VertexId> targets) = 0;
  // Where the ghosts of the last loaded block go, in their order. Ghosts that go to the same
  // cluster have equal numbers.
  virtual Result<std::vector<VertexId>> GhostTargets(TargetStage stage) = 0;

  // Takes the block's part of the next coarser level (without ghosts and triangles), and for each
  // own cluster its parent there. Blocks come in order.
  virtual Status KeepCoarser(
    std::size_t block, CollapseState&& coarser, std::vector<VertexId>&& parents) = 0;
};

}
