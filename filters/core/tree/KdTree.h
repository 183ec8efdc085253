// SPDX-License-Identifier: BSD-3-Clause
// The balanced k-d tree over the vertices (paper section 4.1): step "tree" of the pipeline picture.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace kdstream
{

// P, S and L of doc/design.md#depths: the depths of partitions, of stitching, and of the finest
// level.
struct TreeDepths
{
  unsigned partition = 0;
  unsigned stitch = 0;
  unsigned finest = 0;
  // Levels up to this one are one piece each. Always 11, except in tests that need many small
  // pieces.
  unsigned onePiece = 11;
  bool operator==(const TreeDepths&) const = default;
};

struct KdTreeOptions
{
  // Most vertices of a partition (N of the paper), at least 1. Ignored if `partitions` is given.
  std::uint32_t verticesPerPartition = 2000;
  // The number of partitions, instead of their size: a power of two, at most the number of
  // vertices.
  std::optional<std::uint32_t> partitions;
  // Most vertices of a cell at the finest level, 1-1024; 0 ends the tree at the partitions.
  std::uint32_t cellVertices = 8;
};

// The depths of the tree over `vertices` vertices. P: the smallest depth with ceil(n / 2^P) <= N.
// L: the maximum of P, the smallest depth whose cells have at most cellVertices vertices, and
// min(11, floor(log2 n)). S: min(L, P + 4). Errors: InvalidArgument if there are no vertices, N is
// 0, cellVertices is above 1024, or the number of partitions is not a power of two or is above n;
// LimitExceeded beyond 2^32 - 2 vertices.
Result<TreeDepths> ComputeDepths(std::size_t vertices, const KdTreeOptions& options);

// The positions [begin, begin + size) of one cell in the order of the leaves.
struct CellRange
{
  std::uint64_t begin = 0, size = 0;
};

// Where cell `index` (0 … 2^depth - 1) of `depth` lies in the tree over `vertices` vertices: each
// split of m vertices gives the lower half floor(m / 2), the upper ceil(m / 2). O(depth).
CellRange RangeOfCell(std::uint64_t vertices, unsigned depth, std::uint64_t index);

// The vertices of a mesh in the order of the leaves of a balanced k-d tree, and the boxes of its
// upper nodes.
struct KdTree
{
  TreeDepths depths;
  std::vector<VertexId> order; // n vertex ids, finest cell by finest cell, ascending inside each
  std::vector<VertexId> cellBegin; // 2^L + 1 positions in `order`
  std::vector<Box>
    boxes; // of nodes 1 … 2^(P+1) - 1; [0] is unused; empty for a cell without vertices

  // The vertices of cell `index` (0 … 2^depth - 1) at `depth` <= L.
  std::span<const VertexId> Cell(unsigned depth, std::size_t index) const;
};

// Builds the tree.
// Input: n points, each finite. Output: every cell at depth d holds floor(n / 2^d) or ceil(n / 2^d)
// vertices, for any input: vertices are ordered by (coordinate, id), so points with equal
// coordinates can be split too. The axis is the longest side of the cell's own box (the first of
// equals); the lower half gets floor, the upper ceil. Complexity: O(n L); memory beside the result:
// 16 bytes a point if floats hold every coordinate exactly, otherwise 32. Threads: nodes of one
// depth run in parallel. Errors: those of ComputeDepths; InvalidInput beyond mostExtent (Extent.h);
// Cancelled. Source: paper 4.1; the total order is ours (doc/design.md#uniform).
Result<KdTree> BuildKdTree(
  std::span<const Vec3> points, const KdTreeOptions& options, const Execution& execution = {});

// For each vertex the cell (0 … 2^depth - 1) that holds it. O(n).
std::vector<std::uint32_t> CellOfVertex(
  const KdTree& tree, unsigned depth, const Execution& execution = {});

// The same for a mesh with vertices that are not in the tree; these get noCell.
inline constexpr std::uint32_t noCell = std::numeric_limits<std::uint32_t>::max();
std::vector<std::uint32_t> CellOfVertex(
  const KdTree& tree, unsigned depth, std::size_t vertices, const Execution& execution = {});

}
