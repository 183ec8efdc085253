// SPDX-License-Identifier: BSD-3-Clause
// A mesh in blocks: the files that the steps "tree" and "faces" of building out of core leave, and
// loading a block of them.
#pragma once

#include "filters/core/Attribute.h"
#include "filters/core/tree/KdTree.h"
#include "filters/outofcore/files/BucketFile.h"
#include "filters/outofcore/files/SpillFile.h"
#include "filters/outofcore/mesh/TreeBlock.h"
#include "filters/outofcore/mesh/VertexMap.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace kdstream
{

struct MeshBlocks
{
  TreeDepths depths;
  std::uint32_t vertexCount = 0;
  std::uint32_t triangleCount = 0;
  Box box;                 // the model's
  bool floats = true;      // whether the records hold floats
  unsigned blockDepth = 0; // at most depths.partition
  // The first vertex of each block, and the end: for blocks that are not cells of a k-d tree, whose
  // partitions may have any size (OctreePartitions.h). Empty: cells of depth blockDepth.
  std::vector<VertexId> begin;
  SpillFile records; // of an ExternalTree
  // For each block the triangles that touch it, corners are ranks; none for a cloud.
  std::optional<RecordBuckets<NumberedTriangle>> triangles;
  ScalarType scalarType = ScalarType::Float32;
  bool mayCoincide = true; // false: no two vertices are in one place, -0.0 and 0.0 unlike
  std::vector<AttributeInfo> attributes; // of the mesh, point arrays first
  SpillFile pointTuples;                 // by rank; closed if there are none
  SpillFile cellTuples;                  // by number of triangle; closed if there are none
  // What the process may hold while freed memory stays with it (ReturnFreeMemory).
  std::uint64_t keptMemory = 0;
  // Ranks of other processes' vertices that blocks of this one use, ascending (BlockGroup.h).
  std::vector<VertexId> foreign;

  std::size_t BlockCount() const
  {
    return this->begin.empty() ? std::size_t{ 1 } << this->blockDepth : this->begin.size() - 1;
  }
  CellRange RangeOf(std::size_t block) const
  {
    return this->begin.empty()
             ? RangeOfCell(this->vertexCount, this->blockDepth, block)
             : CellRange{ this->begin[block], this->begin[block + 1] - this->begin[block] };
  }
  // The first rank of each block, and the end.
  std::vector<VertexId> BlockBegins() const;
  // The block's vertices and triangles, with their attributes. Errors: InputOutput.
  Result<TreeBlock> Load(std::size_t block, BlockOrder order = BlockOrder::ById) const;
};

// The tree below a block's cell, over only its own vertices, for core's functions that take a part
// of a mesh. Its depths count from the block; `order` and `cellBegin` use the block's numbers; it
// has no boxes.
KdTree TreeOfBlock(const MeshBlocks& mesh, const TreeBlock& block);

}
