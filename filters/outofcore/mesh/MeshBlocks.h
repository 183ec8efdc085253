// SPDX-License-Identifier: BSD-3-Clause
// A mesh in blocks: the files that the steps "tree" and "faces" of building out of core leave, and
// a function that loads one block.
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
  // The first vertex of each block, and the end. Only for blocks that are not cells of a k-d tree;
  // their partitions may have any size (OctreePartitions.h). Empty: blocks are cells of depth
  // blockDepth.
  std::vector<VertexId> begin;
  SpillFile records; // of an ExternalTree
  // For each block the triangles that touch it; corners are ranks. None for a cloud.
  std::optional<RecordBuckets<NumberedTriangle>> triangles;
  ScalarType scalarType = ScalarType::Float32;
  bool mayCoincide = true; // false: no two vertices are in one place, even if -0.0 equals 0.0
  std::vector<AttributeInfo> attributes; // of the mesh, point arrays first
  SpillFile pointTuples;                 // by rank; closed if there are none
  SpillFile cellTuples;                  // by number of triangle; closed if there are none
  // The bytes that the process may hold before freed memory is returned (ReturnFreeMemory).
  std::uint64_t keptMemory = 0;
  // Ranks of vertices of other processes that blocks of this process use, ascending (BlockGroup.h).
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

// The tree below a block's cell, over only the block's own vertices; for functions of core that
// take a part of a mesh. Depths are relative to the block. `order` and `cellBegin` use the block's
// numbers. The tree has no boxes.
KdTree TreeOfBlock(const MeshBlocks& mesh, const TreeBlock& block);

}
