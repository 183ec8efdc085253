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

// Finds the rank of each vertex: its place in the order of the tree's leaves. records: the vertices
// in that order (PointRecord<Scalar>), `count` of them, with ids 0 … count - 1. One pass over the
// records if the ranks fit in half of the memory; otherwise the ranks are also written and read
// once. Peak memory: `memory` and two blocks. Errors: InputOutput; Cancelled.
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
  // begin: the first rank of each cell, and the end. Cells may have any size but 0.
  explicit CellOfRank(std::span<const VertexId> begin);

  std::size_t Count() const { return this->Begin.size() - 1; }
  // O(1) if the sizes of cells differ by at most one vertex, otherwise O(log). REQUIRES: rank <
  // vertices.
  std::size_t operator()(VertexId rank) const;

private:
  double Scale; // cells per vertex; 0 if cells have any size
  std::vector<std::uint64_t> Begin;
};

// For each cell, collects the triangles that touch one of its vertices; a triangle is in
// one to three cells. Corners become ranks. Inside a cell, sort the triangles by number to get the
// order of the input. Memory and passes: as MapTriangles; a quarter of `memory` is kept for the
// cells' blocks. Errors: InputOutput; Cancelled. REQUIRES: ranks.count > 0 if there are triangles.
Result<RecordBuckets<NumberedTriangle>> SortTrianglesIntoCells(SpillFolder& folder,
  const SpillFile& triangles, std::uint64_t count, const VertexMap& ranks, const CellOfRank& cellOf,
  std::uint64_t memory, const Execution& execution = {});

}
