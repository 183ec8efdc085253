// SPDX-License-Identifier: BSD-3-Clause
// Numbers the vertex tree from the top down, for the whole mesh or block by block. Step "number" of
// the pipeline picture.
//
// A cluster of a level >= S is an interval of the numbered vertices (VertexTree.h), so its lowest
// number follows from its parent's and from how many vertices the siblings before it hold:
//   1. FirstOfCoarseClusters: the levels 0 … S as a whole. Or in parts: FirstOfStitch for level S,
//      and LowerFirst for coarser ones.
//   2. FirstOfChildren: each finer level, all of it or the clusters of one block.
//   3. OrderVertices: the original vertices of the mesh, or of the block.
//   4. OrderLevel: puts a level, or a part of it, into the order that PieceCutter needs; NumberPart
//      does this for the original.
// A block is a cell of a depth <= P: its partitions are numbered one after the other. The parents
// and siblings of its clusters finer than S are in the same block. NumberVertices (VertexTree.h)
// does all of it for a mesh in memory.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Types.h"
#include "filters/core/levels/ClusterLevels.h"
#include "filters/core/pieces/VertexTree.h"

#include <span>
#include <vector>

namespace kdstream
{

// The data of one level that numbering needs: an entry for each cluster, as in ClusterLevel.
struct ClusterParents
{
  std::span<const VertexId> parents; // cluster of the next coarser level; not read at level 0
  std::span<const VertexId> lowest;  // lowest original vertex
  std::span<const Vec3> positions;   // representatives
};

// The lowest numbered vertex of each cluster of level S, for all clusters or those in some
// partitions. Inside a partition clusters are ordered by place (x, then y, then z), and in the same
// place by lowest original vertex: the codec stores this order in few bytes. counts: the number of
// original vertices of each cluster; each cluster lies in one partition, and clusters are ordered
// by partition. partitionBegin: the first number of each partition, and the end. O(c log c); 12
// bytes a cluster. REQUIRES: the counts of each partition add up to its vertices.
std::vector<VertexId> FirstOfStitch(const ClusterParents& level, std::span<const VertexId> counts,
  std::span<const VertexId> partitionBegin);

// Lowers firstOfParents, the lowest numbered vertex of each cluster, to the lowest of its children,
// which are of a level <= S. An entry is noVertex before its first child is seen.
void LowerFirst(std::span<const VertexId> parents, std::span<const VertexId> first,
  std::span<VertexId> firstOfParents);

// For the parents of clusters of level `depth`: the nodes of this level's pieces that hold their
// children, sorted, without duplicates. first: the lowest numbered vertex of each cluster. O(c log
// c).
std::vector<ChildNode> ChildNodesOfParents(const VertexTree& tree, unsigned depth,
  std::span<const VertexId> first, std::span<const VertexId> parents);

// The lowest numbered vertex of every cluster of the levels 0 … S.
// levels: those of depth 0 … S. counts: the number of original vertices of each cluster of level S;
// each lies in one partition, and they are ordered by partition. partitionBegin: 2^P + 1 numbers.
// O(c log c) for c clusters, 12 bytes a cluster. REQUIRES: the counts of each partition add up to
// its vertices.
std::vector<std::vector<VertexId>> FirstOfCoarseClusters(std::span<const ClusterParents> levels,
  std::span<const VertexId> counts, std::span<const VertexId> partitionBegin);

// The lowest numbered vertex of each cluster of a level finer than S. The vertices of a cluster's
// children follow each other, from the cluster's own first vertex on; children are ordered as in
// FirstOfStitch. level: clusters and all their siblings, in any order. counts: the number of
// original vertices of each. firstOfParents: for the list of clusters to which level.parents refer.
// O(c log(siblings)); 12 bytes a cluster. Parents in parallel.
std::vector<VertexId> FirstOfChildren(const ClusterParents& level, std::span<const VertexId> counts,
  std::span<const VertexId> firstOfParents, const Execution& execution = {});

// The own vertices of a mesh or block in the order of their numbers: the i-th has the number begin
// + i. Vertices of a finest cluster are ordered by place (SortByPlace, LeafOrder.h), or stay as
// they are if `points` is empty. clusterOf: the finest cluster of each vertex; noVertex for
// vertices of other blocks, which are left out. first: the lowest number of each finest cluster.
// points: of each vertex; vertices ascend by id. begin: the lowest number of the block. O(n
// log(vertices of a cluster)); 8 bytes a vertex. Clusters in parallel. REQUIRES: `first` is the
// result of FirstOfChildren for all clusters of the block.
std::vector<VertexId> OrderVertices(std::span<const VertexId> clusterOf,
  std::span<const VertexId> first, VertexId begin, std::span<const Vec3> points,
  const Execution& execution = {});

struct OrderedLevel
{
  VertexTreeLevel level;
  std::vector<VertexId> places; // of each cluster, by its old place: its new place
};

// Orders the clusters of a level, or of a part of it, by their lowest numbers. first: the lowest
// number of each cluster; all differ. placesAbove: `places` of the next coarser level, to which
// parents refer; if it is empty, the result has no parents. O(c log c + t log t); 28 bytes a
// cluster beside the result.
OrderedLevel OrderLevel(ClusterLevel level, std::span<const VertexId> first,
  std::span<const VertexId> placesAbove, const Execution& execution = {});

// The numbers 0 … keys.size() - 1 in the order of their keys, which must all differ. O(n).
std::vector<VertexId> OrderByKey(std::span<const VertexId> keys);

// Sets which original vertices the tree has: fills tree.numbers and tree.original. numbers: the
// number of each vertex of the mesh part, own and ghosts; all differ. O(n log n).
void NumberPart(VertexTree& tree, std::span<const VertexId> numbers);

}
