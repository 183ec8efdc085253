// SPDX-License-Identifier: BSD-3-Clause
// A level of detail in files, block by block: what the levels out of core are made of.
#pragma once

#include "filters/core/SortTriangles.h"
#include "filters/core/Types.h"
#include "filters/core/levels/ClusterSum.h"
#include "filters/core/levels/LevelBlocks.h"
#include "filters/outofcore/files/RecordFile.h"
#include "filters/outofcore/files/SpillFile.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// What pieces need of a cluster; kept until they are written.
struct ClusterRecord
{
  Vec3 position{};
  double geometricError = 0;
  VertexId lowest = noVertex; // original vertex
  VertexId count = 0;         // original vertices
};

// One level. Clusters are numbered as in ClusterLevel; those of a block, a cell of depth
// blockDepth, are one interval. A triangle is in each block that owns one of its corners.
struct LevelFile
{
  unsigned depth = 0;
  unsigned blockDepth = 0;
  std::vector<VertexId> begin;              // first cluster of each block, and the end
  std::vector<std::uint64_t> triangleBegin; // first triangle of each block, and the end
  SpillFile clusters;                       // ClusterRecord
  SpillFile triangles; // Triangle, lowest cluster first, sorted in each block, none twice
  SpillFile parents;   // VertexId: cluster of the next coarser level; closed at the coarsest
  // For each cluster the tuples of all arrays of the level; closed if there are none.
  SpillFile tuples;
  // Clusters of other processes that blocks of this one use, ascending (BlockGroup.h).
  std::vector<VertexId> foreign;

  std::size_t BlockCount() const { return std::size_t{ 1 } << this->blockDepth; }
  VertexId ClusterCount() const { return this->begin.back(); }
  BlockRange AllBlocks() const { return { 0, this->BlockCount() }; }
};

// The clusters of a block and the ghosts that its triangles use, in ascending order.
struct LevelBlock
{
  std::vector<VertexId> clusters;    // number in the level of each
  VertexId ownBegin = 0, ownEnd = 0; // places in `clusters`
  std::vector<Triangle> triangles;   // of places in `clusters`, lowest first, sorted

  bool IsOwn(VertexId place) const { return place >= this->ownBegin && place < this->ownEnd; }
  // The ghosts' numbers, ascending.
  std::vector<VertexId> Ghosts() const;
};

// Loads which clusters a block has, and its triangles. O(t log t); memory 40 bytes a triangle.
// Errors: InputOutput.
Result<LevelBlock> LoadLevelBlock(const LevelFile& level, std::size_t block);

// Reads an element for each cluster of a block: its own in one go, ghosts page by page. out:
// block.clusters.size() × elementBytes. Errors: InputOutput.
Status ReadBlockElements(const SpillFile& file, std::size_t elementBytes, const LevelBlock& block,
  std::span<std::byte> out);

template <SpillRecord Record>
Result<std::vector<Record>> ReadBlockRecords(const SpillFile& file, const LevelBlock& block)
{
  std::vector<Record> records(block.clusters.size());
  KDSTREAM_TRY(ReadBlockElements(
    file, sizeof(Record), block, std::as_writable_bytes(std::span<Record>(records))));
  return records;
}

// All of a level's triangles, each once, sorted: from each block those whose lowest cluster is the
// block's own. Memory 12 bytes a triangle. Errors: InputOutput.
Result<std::vector<Triangle>> LoadAllTriangles(const LevelFile& level);

// A level as one block, without ghosts: all its clusters and triangles. Errors: InputOutput.
Result<LevelBlock> LoadWholeLevel(const LevelFile& level);

// Writes the triangles of a level, block after block.
class ImageWriter
{
public:
  ImageWriter(SpillFolder& folder, LevelFile& level)
    : Folder(folder)
    , Level(level)
  {
  }

  // expected: about the sum of the triangles of all blocks; 0 = unknown. REQUIRES: level.begin is
  // known. Errors of both: InputOutput.
  Status Begin(std::uint64_t expected);
  // Adds the triangles of the next block, as numbers of the level's clusters: all that touch the
  // block. Others, degenerate ones and duplicates are dropped. O(t log t).
  Status Add(std::vector<Triangle>& mapped);
  // How many there are so far, each counted where its lowest cluster is.
  std::uint64_t TriangleCount() const { return this->Triangles; }

private:
  SpillFolder& Folder;
  LevelFile& Level;
  std::uint64_t Triangles = 0;
};

}
