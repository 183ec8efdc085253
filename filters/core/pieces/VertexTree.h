// SPDX-License-Identifier: BSD-3-Clause
// The numbered vertex tree, from which pieces are cut. Steps "number" and "cut" of the pipeline
// picture.
//
// Within a partition the original vertices are numbered depth-first in the vertex tree. So a
// cluster of a level >= S is an interval of one partition's numbers (doc/design.md#numbers). Below,
// a "numbered vertex" is a vertex's position in the list of all vertices, one partition after the
// other: partitionBegin[partition] + index.
//
// For a mesh that does not fit in memory, only a part of the tree is held: one resolution around
// some pieces, and its ancestors at the levels 0 … S (PieceCutter, ModelPart).
#pragma once

#include "filters/core/Types.h"
#include "filters/core/levels/ClusterLevels.h"
#include "filters/core/pieces/Piece.h"
#include "filters/core/tree/KdTree.h"

#include <compare>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace kdstream
{

// A cluster (its number, or its place), and a node of the next level's pieces that holds children
// of this cluster.
struct ChildNode
{
  VertexId cluster = 0;
  NodeId node = 0;

  friend auto operator<=>(const ChildNode&, const ChildNode&) = default;
};

// The clusters of a level that are in memory. The place of a cluster is its position in these
// lists; its rank is its place in the whole level.
struct VertexTreeLevel
{
  std::vector<VertexId> first;   // lowest numbered vertex of each cluster, ascending
  std::vector<VertexId> parents; // places in the next coarser level; empty at level 0 and in a part
  std::vector<Vec3> positions;
  std::vector<double> geometricErrors;
  std::vector<Triangle> triangles;     // places; lowest first, sorted
  std::vector<Attribute> attributes{}; // a tuple a cluster
  std::vector<VertexId> ranks{};       // ascending; empty: all clusters are in memory
  std::vector<ChildNode> childNodes{}; // by places, sorted; only if HasChildNodes

  VertexId RankOf(VertexId place) const { return this->ranks.empty() ? place : this->ranks[place]; }
};

struct VertexTree
{
  TreeDepths depths;
  // The numbered vertices in memory, ascending; empty: all. A vertex's place is its position here.
  std::vector<VertexId> numbers{};
  std::vector<VertexId> original;       // of each place: original vertex, as numbered in the mesh
  std::vector<VertexId> partitionBegin; // 2^P + 1 numbered vertices
  std::vector<VertexTreeLevel> levels;  // 0 … L

  VertexId NumberAt(VertexId place) const
  {
    return this->numbers.empty() ? place : this->numbers[place];
  }
  // The partition that holds a numbered vertex. guess: the partition to look at first.
  std::uint32_t PartitionOf(VertexId numbered, std::uint32_t guess = 0) const;
  VertexKey KeyOf(VertexId numbered, std::uint32_t guess = 0) const;
  // The place of the cluster of level `depth` >= S that holds a numbered vertex. O(log). REQUIRES:
  // it is in memory.
  VertexId ClusterAt(unsigned depth, VertexId numbered) const;
};

// Numbers the vertices, and orders every level by the lowest numbered vertex of each cluster.
// Inside a finest cluster vertices are numbered by id (but see OrderLeaves).
// Without levels (TreeOfClustering) the vertices of a partition are numbered by id.
// REQUIRES: either there are no levels and L = P; or `levels` go down to depth 0, and each cluster
// of a level >= S lies in one partition.
// O(n + clusters log clusters).
VertexTree NumberVertices(
  const KdTree& tree, ClusterLevels levels, const Execution& execution = {});

// Which pieces of a resolution are cut, and what they need to know of the whole model, if only a
// part of it is in memory.
struct ModelPart
{
  std::size_t firstPiece = 0; // among the resolution's 2^PieceDepth pieces, by node
  std::size_t pieceCount = 0;
  PrimitiveType primitive = PrimitiveType::Triangles; // of the whole model
};

// The pieces of a resolution that lie in cell `index` of `depth`. REQUIRES: depth <= PieceDepth.
ModelPart PartOfCell(Resolution resolution, const TreeDepths& depths, unsigned depth,
  std::size_t index, PrimitiveType primitive);

// Cuts the pieces of one resolution. Keeps references to the tree and the mesh.
class PieceCutter
{
public:
  // mesh: the (welded) original; its triangles and attributes are only used for the original.
  // Pieces of the original get all arrays, point arrays first; pieces of a level get those of the
  // level.
  //
  // part: the pieces to be cut. Without it all pieces are cut, and the tree and the mesh must be
  // whole. Pieces cut from a part are the same, bit for bit, as those cut from the whole. A part
  // needs at least:
  // - for a level: all clusters of its pieces, every triangle that touches one of them, and the
  //   other clusters of these triangles (ghosts), in the order of OrderLevel;
  // - for the original: the corresponding vertices and triangles as a mesh, where triangles have
  //   the order of the whole mesh, and the vertices' numbers in tree.numbers (NumberPart in
  //   VertexNumbers.h);
  // - for a resolution coarser than S: the ranks of its clusters; for a level R <= d < S also their
  //   childNodes;
  // - for a resolution finer than R: on the levels R … S the ancestors, with parents and ranks, of
  //   all its clusters (if it is a level up to S) or of its ghosts (if it is finer; then also
  //   `first` of level S). O(size of the part + pieces).
  PieceCutter(const VertexTree& tree, const Mesh& mesh, Resolution resolution,
    const Execution& execution = {}, const std::optional<ModelPart>& part = {});

  // The number of pieces to cut.
  std::size_t PieceCount() const { return this->OwnBegin.size() - 1; }
  // Cuts the i-th piece of the part, by node. Any number of threads may cut at once.
  Piece Cut(std::size_t i) const;
  // The number of triangles whose lowest vertex is an own vertex of these pieces. Over all parts,
  // each triangle of the resolution counts once.
  std::size_t TriangleCount() const { return this->OwnTriangles; }
  // The number of own vertices of these pieces.
  std::size_t VertexCount() const { return this->OwnBegin.back() - this->OwnBegin.front(); }

private:
  bool IsBelowStitch() const { return this->Which < Resolution::Level(this->Tree.depths.stitch); }
  void FindOwn(const ModelPart& part);
  void PlaceMesh(const Execution& execution);
  void FindTriangles(const Execution& execution);
  VertexId NumberedAt(VertexId place) const;
  VertexKey KeyOf(VertexId place, VertexKey near) const;
  void AppendAncestors(VertexId place, std::vector<std::uint32_t>& ranks) const;
  void AppendVertex(VertexId place, Piece& piece) const;
  void AddChildNodes(Piece& piece, VertexId begin, VertexId end) const;
  void AddTriangles(Piece& piece, VertexId begin, const std::vector<VertexId>& ghosts,
    std::vector<std::pair<Triangle, std::uint32_t>>&& triangles) const;
  VertexId PlaceOf(VertexId v) const { return this->Places.empty() ? v : this->Places[v]; }
  void AddPointArrays(Piece& piece, VertexId begin, const std::vector<VertexId>& ghosts) const;

  const VertexTree& Tree;
  const Mesh& Input;
  Resolution Which;
  PrimitiveType Primitive = PrimitiveType::Triangles;
  NodeId FirstNode = 1;           // of the pieces
  std::vector<VertexId> OwnBegin; // place of the first own vertex of each piece, and the end
  std::vector<VertexId> Places;   // of each vertex of the mesh; empty for a level
  std::span<const Triangle> Triangles;
  std::size_t OwnTriangles = 0;
  // One bucket for each piece, and one for triangles in no piece of the part.
  TriangleBuckets Buckets;
};

}
