// SPDX-License-Identifier: BSD-3-Clause
// The k-d tree on several ranks: step "tree" of a parallel build.
//   1. All ranks together split the nodes of the upper depths, until a node's vertices fit the
//      memory of one rank. The axis comes from the joined box, the median from histograms of
//      order-preserving bits, which are added over the ranks.
//   2. Every rank gets the vertices of its nodes.
//   3. Every rank splits its nodes further by itself (RecordTree.h).
#pragma once

#include "filters/Parallel/DistributedWeld.h"
#include "filters/Parallel/MpiGroup.h"
#include "filters/core/Execution.h"
#include "filters/core/tree/KdTree.h"
#include "filters/outofcore/mesh/MeshBlocks.h"

#include <vector>

namespace kdstream
{

// The depth at which nodes are distributed: 2^depth >= ranks, with enough nodes that no rank has
// much more than another; at most P.
unsigned DepthOfGroup(std::size_t ranks, const TreeDepths& depths);

// Fills mesh.records, with the vertices of this process's nodes, and mesh.box; returns the boxes of
// all nodes down to P. vertices: of this rank, whose ids follow each other from firstId on. Bit for
// bit the result of BuildKdTree for all vertices. Messages: for each depth that is split together
// 12 sums of 2 KiB a node, or 6 of 512 KiB up to depth 2, and every record once. Each such depth is
// 14 passes over the records, or 8. Memory: `memory`, and all boxes three times; the records (16
// bytes a vertex, or 32 where floats do not hold the coordinates) are in files. Errors:
// InvalidInput beyond mostExtent (Extent.h); InputOutput; Cancelled; MpiGroup's. REQUIRES: the
// group is divided at DepthOfGroup; mesh.depths, vertexCount and floats are known.
Result<std::vector<Box>> BuildTreeCollectively(MpiGroup& group, SpillFolder& folder,
  const VertexFiles& vertices, VertexId firstId, std::uint64_t memory, MeshBlocks& mesh,
  const Execution& execution);

}
