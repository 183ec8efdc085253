// SPDX-License-Identifier: BSD-3-Clause
// Which triangles touch which cell of the tree, out of core: step "faces" of building.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/tree/PointRecord.h"
#include "filters/outofcore/files/BucketFile.h"
#include "filters/outofcore/files/SpillFile.h"
#include "filters/outofcore/mesh/VertexMap.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// For each vertex its rank: its place in the order of the tree's leaves. records: that order
// (PointRecord<Scalar>), `count` of them, ids 0 … count - 1. One pass over the records if the ranks
// fit half of the memory; else the ranks are written and read once more. Peak memory: `memory` and
// two blocks. Errors: InputOutput; Cancelled.
template <class Scalar>
Result<VertexMap> RankVertices(SpillFolder& folder, const SpillFile& records, std::uint32_t count,
  std::uint64_t memory, const Execution& execution = {});

extern template Result<VertexMap> RankVertices<float>(
  SpillFolder&, const SpillFile&, std::uint32_t, std::uint64_t, const Execution&);
extern template Result<VertexMap> RankVertices<double>(
  SpillFolder&, const SpillFile&, std::uint32_t, std::uint64_t, const Execution&);

// Finds the cell of a depth that holds a rank.
class CellOfRank
{
public:
  CellOfRank(std::uint32_t vertices, unsigned depth);
  // begin: where each cell begins, and the end. Cells may have any size but 0.
  explicit CellOfRank(std::span<const VertexId> begin);

  std::size_t Count() const { return this->Begin.size() - 1; }
  // O(1) where cells differ by one vertex at most, else O(log). REQUIRES: rank < vertices.
  std::size_t operator()(VertexId rank) const;

private:
  double Scale; // cells a vertex; 0: of any size
  std::vector<std::uint64_t> Begin;
};

// For each cell of a depth the triangles that touch one of its vertices; a triangle is in one to
// three cells. Corners become ranks. To get the input's order inside a cell, sort by the numbers.
// Memory and passes: MapTriangles; a quarter of `memory` is kept for the cells' blocks. Errors:
// InputOutput; Cancelled. REQUIRES: ranks.count > 0 if there are triangles.
Result<RecordBuckets<NumberedTriangle>> SortTrianglesIntoCells(SpillFolder& folder,
  const SpillFile& triangles, std::uint64_t count, const VertexMap& ranks, unsigned depth,
  std::uint64_t memory, const Execution& execution = {});
// The same for any cells.
Result<RecordBuckets<NumberedTriangle>> SortTrianglesIntoCells(SpillFolder& folder,
  const SpillFile& triangles, std::uint64_t count, const VertexMap& ranks, const CellOfRank& cellOf,
  std::uint64_t memory, const Execution& execution = {});

}
