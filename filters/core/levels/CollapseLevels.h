// SPDX-License-Identifier: BSD-3-Clause
// Levels by edge collapse (doc/design.md#edge-collapse): step "levels" of the pipeline picture.
//
// The finest level is that of ClusterLevels.h. Every coarser level is made from the level below it
// by merging neighbouring clusters, in the order of their quadric errors. From L to S every
// partition collapses by itself, with the clusters of other partitions fixed; for levels coarser
// than S any edge may collapse.
#pragma once

#include "filters/core/levels/ClusterLevels.h"
#include "filters/core/levels/CollapseState.h"
#include "filters/core/levels/Levels.h"

namespace kdstream
{

class SumsAside;

// Builds the levels L … coarsestDepth of a mesh with triangles; a mesh without any is passed to
// BuildClusterLevels. Level d has about 2^d clusters with triangles, at most 32 more, ordered by
// (cell of depth d of the lowest original vertex, lowest original vertex); no node of depth
// PieceDepth(d) is the home of more than 4 × 2^(d - PieceDepth(d)) clusters. A cluster of a level
// >= S lies in one partition. Where no edge can collapse any more, clusters are grouped by cells:
// by components, at most 4 a cell. Clusters without triangles are always grouped, one a cell.
// Positions may lie outside the box of a cluster's vertices, never outside the model's. Colours and
// normals (RoleOf) take part: see CollapseAttributes.h. Complexity: O(n + t log t) for level L, and
// O(c log c) for all other levels together, where c is the number of clusters of level L; memory
// about 440 bytes a finest cluster. The same bits for any number of threads. Errors: Cancelled.
// Source: Garland and Heckbert 1997; rounds, thresholds and fixed ghosts are ours.
Result<ClusterLevels> BuildCollapseLevels(const Mesh& mesh, const KdTree& tree,
  const TriangleBuckets& partitionTriangles, const LevelOptions& options,
  const Execution& execution = {});

// Makes the levels `depth` … options.coarsestDepth from the whole state of level `depth`, as
// BuildCollapseLevels does. Returns them without attributes. box: the model's. Errors: Cancelled;
// those of `aside`.
Result<std::vector<ClusterLevel>> BuildCoarserLevels(CollapseState state, unsigned depth,
  const TreeDepths& depths, const Box& box, const LevelOptions& options, SumsAside& aside,
  const Execution& execution = {});

// The target of a collapse: at most this number of triangles, or of points; 0 = no limit.
// At least one of them is not 0.
struct CollapseTarget
{
  std::size_t triangles = 0;
  std::size_t points = 0;
};

// One level of any size: its clusters (parents empty), and for each original vertex its cluster.
struct CollapsedMesh
{
  ClusterLevel level;
  std::vector<VertexId> clusterOf;
};

// Collapses a mesh to the target: level by level as BuildCollapseLevels does, while levels are
// larger than the target; then without restriction until it is met. If the finest level meets the
// target, the result is the finest level. If no edge can collapse any more, the rest is grouped by
// larger and larger cells. Errors: InvalidArgument for an empty target; those of
// BuildCollapseLevels.
Result<CollapsedMesh> CollapseTo(const Mesh& mesh, const KdTree& tree,
  const TriangleBuckets& partitionTriangles, const LevelOptions& options,
  const CollapseTarget& target, const Execution& execution = {});

}
