// SPDX-License-Identifier: BSD-3-Clause
// The clusters of the finest level, where every maker of levels starts. For the makers of levels
// alone.
#pragma once

#include "filters/core/TriangleBuckets.h"
#include "filters/core/levels/ClusterSum.h"
#include "filters/core/tree/KdTree.h"

#include <span>
#include <vector>

namespace kdstream
{

// The vertices of one cell of the tree, and those of other cells that its triangles use (ghosts).
// The whole mesh is that of the root.
struct FinestInput
{
  std::span<const Vec3> points; // those of a partition ascending by id
  std::span<const Triangle> triangles;
  const KdTree& tree; // of the cell: over only its own vertices, depths from there; no boxes needed
  const TriangleBuckets&
    partitionTriangles;            // for each of the cell's partitions those that touch it
  Vec3 origin;                     // of the sums: the centre of the model's box
  std::span<const VertexId> ids{}; // of each point in the mesh; empty: its place
  // The vertex colours of the points, or null: clusters do not go across its edges
  // (CollapseAttributes.h) but where a cell would have too many.
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

// The centre of a box, where sums have their origin.
inline Vec3 CentreOf(const Box& box)
{
  return { box.lo[0] / 2 + box.hi[0] / 2, box.lo[1] / 2 + box.hi[1] / 2,
    box.lo[2] / 2 + box.hi[2] / 2 };
}

// Fills a level's positions, deviations and lowest vertices from its clusters, and raises the
// clusters' deviations to their own where the children's are below it.
void RepresentClusters(std::vector<ClusterSum>& clusters, Representative representative,
  const Vec3& origin, ClusterLevel& level, const Execution& execution);

// Makes the clusters of level L of the tree, or of one of its cells: what they are does not depend
// on the cell. Their triangles: ImageInPartitions. Sums, complexity and errors: see
// BuildClusterLevels, whose first half of the progress it reports.
Result<FinestClusters> BuildFinestClusters(
  const FinestInput& input, const ClusterOptions& options, const Execution& execution);

// Where vertices are split, at texture seams and hard edges, levels would open slits between their
// clusters (CoincidentClusters.cxx). Joins the clusters of one partition that finest.coincident
// links; clusters of different partitions stay apart, since a cluster may not lie in both. A joined
// cluster is at home in the cell of its lowest vertex. Adjusts all of `finest` but the level and
// the links. cellsBelowPartition: how many depths the finest cells are below the partitions.
// O(clusters + links).
void JoinCoincidentClusters(FinestClusters& finest, unsigned cellsBelowPartition);

}
