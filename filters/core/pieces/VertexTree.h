// SPDX-License-Identifier: BSD-3-Clause
// The numbered vertex tree, from which pieces are cut. Steps "number" and "cut" of the pipeline
// picture.
//
// Within a partition the original vertices are numbered depth-first in the vertex tree. So a
// cluster of a level >= S is an interval of one partition's numbers (doc/design.md#numbers). A
// numbered vertex below is the position in the list of all partitions' vertices, one partition
// after the other: partitionBegin[partition] + index.
//
// For a mesh that does not fit the memory only a part of the tree is held: one resolution around
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

// A node of the pieces of the next level that has children of a cluster, or of the one at a place.
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
  std::vector<VertexId> parents; // place in the next coarser level; empty at level 0, and in a part
  std::vector<Vec3> positions;
  std::vector<double> geometricErrors;
  std::vector<Triangle> triangles;     // places; lowest first, sorted
  std::vector<Attribute> attributes{}; // a tuple a cluster
  std::vector<VertexId> ranks{};       // ascending; empty: all clusters are at hand
  std::vector<ChildNode> childNodes{}; // of places; sorted. Of levels that have it (HasChildNodes)

  VertexId RankOf(VertexId place) const { return this->ranks.empty() ? place : this->ranks[place]; }
};

struct VertexTree
{
  TreeDepths depths;
  // The numbered vertices at hand, ascending; empty: all. A vertex's place is its position here.
  std::vector<VertexId> numbers{};
  std::vector<VertexId> original;       // place -> original vertex, as numbered in the mesh at hand
  std::vector<VertexId> partitionBegin; // 2^P + 1 numbered vertices
  std::vector<VertexTreeLevel> levels;  // 0 … L

  VertexId NumberAt(VertexId place) const
  {
    return this->numbers.empty() ? place : this->numbers[place];
  }
  // guess: a partition that is looked at first.
  std::uint32_t PartitionOf(VertexId numbered, std::uint32_t guess = 0) const;
  VertexKey KeyOf(VertexId numbered, std::uint32_t guess = 0) const;
  // The place of the cluster of level `depth` >= S that holds a numbered vertex. O(log). REQUIRES:
  // it is in memory.
  VertexId ClusterAt(unsigned depth, VertexId numbered) const;
};

// Numbers the vertices and orders every level by its clusters' lowest numbered vertices; vertices
// of a finest cluster by id (see OrderLeaves).
// Without levels (TreeOfClustering) the vertices of a partition are numbered by id.
// REQUIRES: `levels` go down to depth 0; a cluster of a level >= S lies in one partition; or no
// levels and L = P.
// O(n + clusters log clusters).
VertexTree NumberVertices(
  const KdTree& tree, ClusterLevels levels, const Execution& execution = {});

// The pieces of a resolution that are cut, and what they need to know of the whole model, where
// only a part of it is in memory.
struct ModelPart
{
  std::size_t firstPiece = 0; // of the resolution's 2^PieceDepth, nodes ascending
  std::size_t pieceCount = 0;
  PrimitiveType primitive = PrimitiveType::Triangles; // of the whole model
};

// The pieces of a resolution that lie in cell `index` of `depth`. REQUIRES: depth <= PieceDepth.
ModelPart PartOfCell(Resolution resolution, const TreeDepths& depths, unsigned depth,
  std::size_t index, PrimitiveType primitive);

// The pieces of one resolution. Keeps references to what it is made from.
class PieceCutter
{
public:
  // mesh: the (welded) original; its triangles and attributes are needed for the original only.
  // Pieces of the original get all arrays, point arrays first; those of a level the level's.
  //
  // part: the pieces to be cut; without it, all pieces, and tree and mesh must be whole. The pieces
  // of a part are the same, bit for bit, as those of the whole. A part needs at least:
  // - of a level: all clusters of its pieces, every triangle that touches one of them, and the
  //   other
  //   clusters of these triangles (ghosts);
  // - of the original: the same vertices and triangles as a mesh, in which the triangles have the
  //   order
  //   of the whole, and their numbers in tree.numbers (NumberPart, OrderLevel in VertexNumbers.h);
  // - for a resolution coarser than S: the ranks of its clusters, and of a level R <= d < S their
  //   childNodes;
  // - for a resolution finer than R: the ancestors, with parents and ranks, on the levels R … S of
  //   all clusters of a level up to S, or of the ghosts of a finer resolution; there also `first`
  //   of level S. O(size of the part + pieces).
  PieceCutter(const VertexTree& tree, const Mesh& mesh, Resolution resolution,
    const Execution& execution = {}, const std::optional<ModelPart>& part = {});

  // The number of the part's pieces.
  std::size_t PieceCount() const { return this->OwnBegin.size() - 1; }
  // The i-th piece of the part, nodes ascending. Any number of threads may cut at once.
  Piece Cut(std::size_t i) const;
  // The triangles of the resolution whose lowest vertex is an own one of these pieces: over all
  // parts, each triangle counts once.
  std::size_t TriangleCount() const { return this->OwnTriangles; }
  // Own vertices of these pieces.
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
  std::vector<VertexId> Places;   // of each vertex of the mesh at hand; empty for a level
  std::span<const Triangle> Triangles;
  std::size_t OwnTriangles = 0;
  // One bucket for each piece, and one for triangles in no piece of the part.
  TriangleBuckets Buckets;
};

}
