// SPDX-License-Identifier: BSD-3-Clause
// The k-d tree on several ranks: step "tree" of a parallel build.
//   1. All ranks together split the nodes of the upper depths, until the vertices of a node fit in
//      the memory of one rank. The axis comes from the joined box, the median from histograms of
//      order-preserving bits, which are added over the ranks.
//   2. Every rank gets the vertices of its nodes.
//   3. Every rank splits its nodes further, without the others (RecordTree.h).
#pragma once

#include "filters/Parallel/DistributedWeld.h"
#include "filters/Parallel/MpiGroup.h"
#include "filters/core/Execution.h"
#include "filters/core/tree/KdTree.h"
#include "filters/outofcore/mesh/MeshBlocks.h"

#include <vector>

namespace kdstream
{

// The depth whose nodes are distributed: 2^depth >= ranks, with enough nodes that no rank gets much
// more than another; at most P.
unsigned DepthOfGroup(std::size_t ranks, const TreeDepths& depths);

// Fills mesh.records, with the vertices of this process's nodes, and mesh.box; returns the boxes of
// all nodes down to P. vertices: of this rank, with consecutive ids from firstId on. Bit for bit
// the result of BuildKdTree for all vertices. Messages: every record once; and for each depth that
// is split together 12 sums of 2 KiB a node, or up to depth 2 six sums of 512 KiB a node. Each such
// depth takes 14 passes over the records, or 8 up to depth 2. Memory: `memory`, and all boxes three
// times; the records (16 bytes a vertex, or 32 if floats do not hold the coordinates) are in files.
// Errors: InvalidInput beyond mostExtent (Extent.h); InputOutput; Cancelled; those of MpiGroup.
// REQUIRES: the group is divided at DepthOfGroup; mesh.depths, vertexCount and floats are known.
Result<std::vector<Box>> BuildTreeCollectively(MpiGroup& group, SpillFolder& folder,
  const VertexFiles& vertices, VertexId firstId, std::uint64_t memory, MeshBlocks& mesh,
  const Execution& execution);

}
