// The vertex tree, numbered: what pieces are cut from. Step "number" of the README's picture.
//
// Within a partition the original vertices are numbered depth-first in the vertex tree, so that a
// cluster of a level
// >= S is an interval of one partition's numbers (DESIGN section 4, "Pieces"). A numbered vertex
// below is the position in the list of all partitions' vertices, one partition after the other:
// partitionBegin[partition] + index.
#pragma once

#include "filters/core/ClusterLevels.h"
#include "filters/core/KdTree.h"
#include "filters/core/Piece.h"
#include "filters/core/Types.h"

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace kdstream
{

struct VertexTreeLevel
{
  std::vector<VertexId>
    first; // lowest numbered vertex of each cluster, ascending: a cluster's place is its rank
  std::vector<VertexId> parents; // rank in the next coarser level; empty at level 0
  std::vector<Vec3> positions;
  std::vector<double> deviations;
  std::vector<Triangle> triangles;     // ranks; lowest first, sorted
  std::vector<Attribute> attributes{}; // a tuple a cluster
};

struct VertexTree
{
  TreeDepths depths;
  std::vector<VertexId> original;       // numbered vertex -> original vertex
  std::vector<VertexId> partitionBegin; // 2^P + 1 numbered vertices
  std::vector<VertexTreeLevel> levels;  // 0 … L

  std::uint32_t PartitionOf(VertexId numbered) const;
  VertexKey KeyOf(VertexId numbered) const;
  // The cluster of level `depth` >= S that holds a numbered vertex. O(log).
  VertexId ClusterAt(unsigned depth, VertexId numbered) const;
};

// Numbers the vertices and orders every level by its clusters' lowest numbered vertices.
// Without levels (TreeOfClustering) the vertices of a partition are numbered by id.
// REQUIRES: `levels` go down to depth 0; a cluster of a level >= S lies in one partition; or no
// levels and L = P.
// O(n + clusters log clusters).
VertexTree NumberVertices(
  const KdTree& tree, ClusterLevels levels, const Execution& execution = {});

// The pieces of one resolution. Keeps references to what it is made from.
class PieceCutter
{
public:
  // mesh: the (welded) original; its triangles and attributes are needed for the original only.
  // Pieces of the original get all arrays, point arrays first; those of a level the level's.
  PieceCutter(const VertexTree& tree, const Mesh& mesh, Resolution resolution,
    const Execution& execution = {});

  std::size_t PieceCount() const { return this->OwnBegin.size() - 1; }
  // The i-th piece, nodes ascending. Any number of threads may cut at once.
  Piece Cut(std::size_t i) const;
  // Triangles of the resolution, each once.
  std::size_t TriangleCount() const { return this->Triangles.size(); }
  std::size_t VertexCount() const { return this->OwnBegin.back(); }

private:
  VertexKey KeyOf(VertexId vertex) const;
  void AppendAncestors(VertexId vertex, std::vector<std::uint32_t>& ranks) const;
  void AppendVertex(VertexId vertex, Piece& piece) const;
  void FindReach();
  void AddReach(Piece& piece, VertexId begin, VertexId end) const;
  void AddTriangles(Piece& piece, VertexId begin, const std::vector<VertexId>& ghosts,
    std::vector<std::pair<Triangle, std::uint32_t>>&& triangles) const;
  VertexId NumberOf(VertexId v) const { return this->Number.empty() ? v : this->Number[v]; }
  void AddPointArrays(Piece& piece, VertexId begin, const std::vector<VertexId>& ghosts) const;

  const VertexTree& Tree;
  const Mesh& Input;
  Resolution Which;
  std::vector<VertexId>
    OwnBegin; // first own vertex of each piece (rank, or numbered vertex), and the end
  std::vector<VertexId> Number; // of each original vertex; empty for a level
  std::span<const Triangle> Triangles;
  TriangleBuckets Buckets;
  std::vector<std::pair<VertexId, NodeId>>
    Reach; // below S: (cluster, node of a level-S piece), sorted
};

// Edges that more than one triangle uses, and not equally often in both directions: where the input
// is not consistently oriented or not manifold, "no cracks" does not hold (DESIGN section 3.5). O(t
// log t) over partitions in parallel.
std::size_t CountInconsistentEdges(
  std::span<const Triangle> triangles, std::size_t vertices, const Execution& execution = {});

}
