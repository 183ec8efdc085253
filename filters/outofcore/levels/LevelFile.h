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

// What is needed of a cluster to write pieces; kept until then.
struct ClusterRecord
{
  Vec3 position{};
  double geometricError = 0;
  VertexId lowest = noVertex; // original vertex
  VertexId count = 0;         // original vertices
};

// One level. Clusters are numbered as in ClusterLevel. A block is a cell of depth blockDepth, and
// the numbers of its clusters are one interval. A triangle is stored in each block that owns one of
// its corners.
struct LevelFile
{
  unsigned depth = 0;
  unsigned blockDepth = 0;
  std::vector<VertexId> begin;              // first cluster of each block, and the end
  std::vector<std::uint64_t> triangleBegin; // first triangle of each block, and the end
  SpillFile clusters;                       // ClusterRecord
  SpillFile triangles; // Triangle, lowest cluster first, sorted in each block, no duplicates
  SpillFile parents;   // VertexId: cluster of the next coarser level; closed at the coarsest
  // For each cluster the tuples of all arrays of the level; closed if there are none.
  SpillFile tuples;
  // Clusters of other processes that blocks of this process use, ascending (BlockGroup.h).
  std::vector<VertexId> foreign;

  std::size_t BlockCount() const { return std::size_t{ 1 } << this->blockDepth; }
  VertexId ClusterCount() const { return this->begin.back(); }
  BlockRange AllBlocks() const { return { 0, this->BlockCount() }; }
};

// The clusters of a block and the ghosts that its triangles use, in ascending order.
struct LevelBlock
{
  std::vector<VertexId> clusters;    // the number in the level of each
  VertexId ownBegin = 0, ownEnd = 0; // the own clusters are clusters[ownBegin … ownEnd - 1]
  std::vector<Triangle> triangles;   // corners are indices into `clusters`, lowest first; sorted

  bool IsOwn(VertexId place) const { return place >= this->ownBegin && place < this->ownEnd; }
  // The ghosts' numbers, ascending.
  std::vector<VertexId> Ghosts() const;
};

// Finds the clusters of a block, and loads its triangles. O(t log t); memory 40 bytes a triangle.
// Errors: InputOutput.
Result<LevelBlock> LoadLevelBlock(const LevelFile& level, std::size_t block);

// Reads one element for each cluster of a block: the block's own in one go, ghosts page by page.
// out: block.clusters.size() × elementBytes. Errors: InputOutput.
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

// All triangles of a level, each once, sorted. Each is taken from the block that owns its lowest
// cluster. Memory 12 bytes a triangle. Errors: InputOutput.
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

  // expected: about how many triangles all blocks have together; 0 = unknown. REQUIRES: level.begin
  // is known. Errors of both functions: InputOutput.
  Status Begin(std::uint64_t expected);
  // Adds the triangles of the next block; corners are numbers of the level's clusters. `mapped`
  // must contain all triangles that touch the block. Triangles elsewhere, degenerate ones and
  // duplicates are dropped. O(t log t).
  Status Add(std::vector<Triangle>& mapped);
  // How many triangles there are so far. Each is counted in the block that owns its lowest cluster.
  std::uint64_t TriangleCount() const { return this->Triangles; }

private:
  SpillFolder& Folder;
  LevelFile& Level;
  std::uint64_t Triangles = 0;
};

}
