// SPDX-License-Identifier: BSD-3-Clause
// One cell of the tree with everything that touches it, in memory. The steps after the tree process
// one such block after the other.
#pragma once

#include "filters/core/Types.h"
#include "filters/core/tree/KdTree.h"
#include "filters/outofcore/files/BucketFile.h"
#include "filters/outofcore/files/SpillFile.h"
#include "filters/outofcore/mesh/VertexMap.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace kdstream
{

// How the vertices of a block are numbered.
enum class BlockOrder
{
  // Ascending, own vertices and ghosts together. Code that depends on the order of ids then gives
  // the same results as for the whole mesh.
  ById,
  // The own vertices, then the ghosts. This is less work, for code that ignores the order of ids.
  ByRank
};

// The vertices of one cell and the vertices of other cells that its triangles use (ghosts).
struct TreeBlock
{
  std::size_t cell = 0;        // at the depth of the blocks
  VertexId firstRank = 0;      // the own vertices have the ranks firstRank … + order.size() - 1
  Mesh mesh;                   // points; triangles that touch an own vertex, ascending by number
  std::vector<VertexId> ids;   // of each vertex, ascending if ordered by id
  std::vector<VertexId> ranks; // of each vertex
  std::vector<VertexId> order; // the own vertices, by rank
  std::vector<std::uint32_t> numbers; // of each triangle, ascending

  bool IsOwn(VertexId v) const
  {
    return this->ranks[v] >= this->firstRank &&
           this->ranks[v] - this->firstRank < this->order.size();
  }
};

// Loads block `cell`, which has the ranks `range`. records: those of an ExternalTree
// (PointRecord<Scalar>); triangles: SortTrianglesIntoCells of these cells. Ghosts are read in the
// order of their ranks; each page of 16 KiB is read once. For v vertices (g of them ghosts) and t
// triangles of the block: O(v + t + g log g), or O(t log t) if the triangles do not ascend in their
// file; memory about 80 bytes a vertex and 40 a triangle. Errors: InputOutput.
template <class Scalar>
Result<TreeBlock> LoadBlock(const SpillFile& records, const CellRange& range,
  const RecordBuckets<NumberedTriangle>& triangles, std::size_t cell,
  BlockOrder order = BlockOrder::ById);

extern template Result<TreeBlock> LoadBlock<float>(const SpillFile&, const CellRange&,
  const RecordBuckets<NumberedTriangle>&, std::size_t, BlockOrder);
extern template Result<TreeBlock> LoadBlock<double>(const SpillFile&, const CellRange&,
  const RecordBuckets<NumberedTriangle>&, std::size_t, BlockOrder);

}
