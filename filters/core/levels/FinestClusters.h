// SPDX-License-Identifier: BSD-3-Clause
// The clusters of the finest level, where every maker of levels starts. Only for the makers of
// levels.
#pragma once

#include "filters/core/TriangleBuckets.h"
#include "filters/core/levels/ClusterSum.h"
#include "filters/core/tree/KdTree.h"

#include <span>
#include <vector>

namespace kdstream
{

// The vertices of one cell of the tree, and the vertices of other cells that its triangles use
// (ghosts). For the root: the whole mesh.
struct FinestInput
{
  std::span<const Vec3> points; // within a partition ascending by id
  std::span<const Triangle> triangles;
  const KdTree& tree; // of the cell: only its own vertices, depths count from there; needs no boxes
  const TriangleBuckets&
    partitionTriangles;            // for each partition of the cell, the triangles that touch it
  Vec3 origin;                     // of the sums: the centre of the model's box
  std::span<const VertexId> ids{}; // each point's id in the mesh; empty: its place
  // The vertex colours of the points, or null. Clusters do not cross edges between colours
  // (CollapseAttributes.h), unless a cell would then have too many clusters.
  const Attribute* vertexColors = nullptr;
};

struct FinestClusters
{
  Vec3 origin{};                        // of the sums
  std::vector<VertexId> clusterOf;      // of each point; noVertex for ghosts
  std::vector<ClusterSum> clusters;     // ordered by (cell, lowest original vertex)
  std::vector<std::uint32_t> cellOf;    // of each cluster
  std::vector<VertexId> partitionBegin; // first cluster of each partition, and the end
  std::vector<Link> coincident;         // vertices in the same place but not in the same cell
  ClusterLevel level;                   // parents and triangles are left empty
};

// The centre of a box: the origin of sums.
inline Vec3 CentreOf(const Box& box)
{
  return { box.lo[0] / 2 + box.hi[0] / 2, box.lo[1] / 2 + box.hi[1] / 2,
    box.lo[2] / 2 + box.hi[2] / 2 };
}

// Fills in a level's positions, geometric errors and lowest vertices from its clusters. A cluster's
// geometric error is at least that of its children.
void RepresentClusters(std::vector<ClusterSum>& clusters, Representative representative,
  const Vec3& origin, ClusterLevel& level, const Execution& execution);

// Makes the clusters of level L, of the whole tree or of one of its cells; the result is the same
// in both cases. For the triangles of the level see ImageInPartitions. Sums, complexity and errors:
// see BuildClusterLevels. Reports the progress of step "levels" up to clustersSummedPart.
Result<FinestClusters> BuildFinestClusters(
  const FinestInput& input, const ClusterOptions& options, const Execution& execution);

// Joins clusters at split vertices (texture seams, hard edges), where levels would otherwise open
// slits (CoincidentClusters.cxx). Joins those clusters of the same partition that finest.coincident
// links. Clusters of different partitions stay apart, because a cluster lies in one partition. A
// joined cluster is at home in the cell of its lowest vertex. Adjusts all of `finest` except the
// level and the links. cellsBelowPartition: the number of depths from partitions to finest cells.
// O(clusters + links).
void JoinCoincidentClusters(FinestClusters& finest, unsigned cellsBelowPartition);

}
