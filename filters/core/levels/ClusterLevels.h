// SPDX-License-Identifier: BSD-3-Clause
// Levels by clustering (paper 4.3, doc/design.md#clusters): step "levels" of the pipeline picture.
//
// The vertices of a cell of the k-d tree become one representative, or one for each component of
// the surface in the cell. The clusters of all depths form one tree: a child's cluster lies in one
// cluster of its parent. The triangles of a level are exactly the image of the original triangles
// under the map vertex -> cluster.
#pragma once

#include "filters/core/Attribute.h"
#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/SortTriangles.h"
#include "filters/core/TriangleBuckets.h"
#include "filters/core/Types.h"
#include "filters/core/tree/KdTree.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

enum class Representative
{
  Quadric, // minimises the area-weighted plane quadrics of the cluster's triangles
  Mean     // the mean of the cluster's vertices, as in the paper
};

struct ClusterOptions
{
  Representative representative = Representative::Quadric;
  // True: a representative for each component, at most 4 a cell. False: one a cell, as in the
  // paper.
  bool byComponents = true;
  // Levels are made from L down to this depth.
  unsigned coarsestDepth = 0;
  // Whether vertices may lie in the same place. False: no two do (as in a welded mesh), and the
  // search for them is skipped.
  bool mayCoincide = true;
  // Whether finest clusters of one partition are joined, even across cells, if they hold vertices
  // in the same place. Set by the maker that needs this (collapse).
  bool joinCoincident = false;
  // Each vertex's original id, if the mesh was renumbered (GatherMesh); ascending inside each
  // partition. Empty: the vertex numbers are the ids.
  std::span<const VertexId> ids{};
};

// Red, green, blue.
using VertexColor = std::array<std::uint8_t, 3>;

// One level. Clusters are ordered by (cell, lowest original vertex).
struct ClusterLevel
{
  // Representatives. They are inside the box of the cluster's original vertices, unless a collapse
  // or FoldOverRepair.h has moved them; never outside the model's box.
  std::vector<Vec3> positions;
  std::vector<double> geometricErrors; // sqrt(Q(x) / trace A), never below a child's; model units
  std::vector<VertexId> lowest;        // lowest original vertex of each cluster
  std::vector<VertexId> parents;       // cluster of the next coarser level; empty at the coarsest
  std::vector<Triangle> triangles;     // lowest cluster first, sorted, one of each orientation
  std::vector<Attribute> attributes{}; // means of normals and colours, a tuple a cluster
  // Colours that replace the means of the mesh's vertex colours (CollapseAttributes.h). Only for
  // levels by collapse of meshes with colours, until their attributes are made.
  std::vector<VertexColor> vertexColors{};
};

struct ClusterLevels
{
  std::vector<VertexId> finest;     // for each original vertex its cluster at level L
  std::vector<ClusterLevel> levels; // [depth]; empty below coarsestDepth
};

// Builds the levels L … coarsestDepth.
// Input: n points, triangles with indices < n (degenerate and duplicate ones allowed), their tree,
// and the triangles sorted into its partitions (BucketTriangles with CellOfVertex(tree, P)). Sums
// are in double, relative to the centre of the model's box: at level L over original vertices by
// ascending id, at coarser levels over children by lowest id. So the bits are the same for any
// number of threads. If a cluster's quadric is empty, the representative is the mean of its
// vertices, and the geometric error their RMS distance. Complexity: O(n + t log t) a level, where
// each level is half the size of the next finer one; memory about 440 bytes a finest cluster.
// Errors: Cancelled. Source: paper 4.3; components, quadrics and geometric errors are ours.
Result<ClusterLevels> BuildClusterLevels(std::span<const Vec3> points,
  std::span<const Triangle> triangles, const KdTree& tree,
  const TriangleBuckets& partitionTriangles, const ClusterOptions& options,
  const Execution& execution = {});

// The image of triangles under a map of their vertices. Degenerate triangles are dropped; each
// starts with its lowest vertex; they are sorted; of equal ones one is kept for each orientation.
// O(t log t).
std::vector<Triangle> ImageOfTriangles(std::span<const Triangle> triangles,
  std::span<const VertexId> map, const Execution& execution = {});

// The same for a map that keeps partitions apart: the vertices of partition p are mapped to
// mapBegin[p] … mapBegin[p + 1] - 1. buckets: the triangles sorted into the partitions
// (BucketTriangles). Each partition's part of the image needs only its own triangles.
std::vector<Triangle> ImageInPartitions(std::span<const Triangle> triangles,
  const TriangleBuckets& buckets, std::span<const VertexId> map, std::span<const VertexId> mapBegin,
  const Execution& execution = {});

}
