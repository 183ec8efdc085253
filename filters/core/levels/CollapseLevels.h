// SPDX-License-Identifier: BSD-3-Clause
// Levels by edge collapse (doc/design.md#edge-collapse): step "levels" of the pipeline picture.
//
// The finest level is that of ClusterLevels.h. Every coarser one comes from the level below it by
// merges of neighbouring clusters, those of the smallest quadric error first. From L to S every
// partition collapses by itself, with the clusters of other partitions fixed; below S collapses go
// freely.
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
// PieceDepth(d) is the home of more than 4 × 2^(d - that depth). A cluster of a level >= S lies in
// one partition. Where no edge can collapse any more, clusters are grouped by cells (at most 4 a
// cell, by components), and clusters without triangles always (one a cell). Positions may lie
// outside the box of a cluster's vertices, never outside the model's. Colours and normals (RoleOf)
// take part: see CollapseAttributes.h. Complexity: O(n + t log t) for level L, O(c log c) over its
// clusters for all others; memory about 440 bytes a finest cluster. The same bits for any number of
// threads. Errors: Cancelled. Source: Garland and Heckbert 1997; rounds, thresholds
// and fixed ghosts are ours.
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

// Collapses a mesh to the target: by the levels of BuildCollapseLevels while these are larger, then
// freely until it is met. If the finest level meets the target, the result is the finest level. If
// no edge can collapse any more, the rest is grouped by larger and larger cells. Errors:
// InvalidArgument for an empty target; those of BuildCollapseLevels.
Result<CollapsedMesh> CollapseTo(const Mesh& mesh, const KdTree& tree,
  const TriangleBuckets& partitionTriangles, const LevelOptions& options,
  const CollapseTarget& target, const Execution& execution = {});

}
