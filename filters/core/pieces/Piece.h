// SPDX-License-Identifier: BSD-3-Clause
// A piece: the unit that is stored and streamed (doc/design.md#pieces).
//
// Pieces of all resolutions have the same form: the part of one level, or of the original, in one
// node of the tree. Its own vertices come first, then the ghosts: vertices of other pieces,
// repeated so that the triangles on the boundary are whole. Its triangles are all that touch an own
// vertex.
#pragma once

#include "filters/core/Attribute.h"
#include "filters/core/Types.h"
#include "filters/core/tree/KdTree.h"
#include "filters/core/tree/PieceDepth.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace kdstream
{

// Identity of a vertex inside its resolution.
// Original, and levels d >= S: (partition << 32) | index, where index is the vertex's number in its
// partition. (For a level it is the first number of the interval of original vertices that the
// cluster covers.) Levels d < S: the cluster's rank in its level. Own vertices of a piece have
// ascending keys.
using VertexKey = std::uint64_t;

constexpr VertexKey MakeKey(std::uint32_t partition, std::uint32_t index)
{
  return (static_cast<VertexKey>(partition) << 32) | index;
}
constexpr std::uint32_t PartitionOfKey(VertexKey key)
{
  return static_cast<std::uint32_t>(key >> 32);
}
constexpr std::uint32_t IndexOfKey(VertexKey key)
{
  return static_cast<std::uint32_t>(key);
}

// Names a piece: a resolution and a node.
struct PieceId
{
  Resolution resolution;
  NodeId node = 1;
  auto operator<=>(const PieceId&) const = default;
};

// The piece of `resolution` that holds the vertices of `partition`.
PieceId PieceOfPartition(Resolution resolution, std::uint32_t partition, const TreeDepths& depths);

struct Piece
{
  PieceId id;
  PrimitiveType primitive = PrimitiveType::Triangles;
  std::uint32_t ownVertices = 0;

  std::vector<Vec3> positions; // own, then ghosts
  std::vector<VertexKey> keys; // own (ascending), then ghosts (ascending)
  // For own vertices of a level: their geometric errors in model units. Only while the piece is
  // built: blobs do not contain them, and a page of the tree contains only the largest of each
  // piece.
  std::vector<float> geometricErrors;

  // The ranks of the ancestors at the levels R … min(d, S) - 1, R first (AncestorLevelsOf): for all
  // vertices of the levels up to S, and for the ghosts of every finer resolution. Empty for levels
  // up to R, and if S <= R.
  std::vector<std::uint32_t> ancestors;

  // For own vertices of the levels R <= d < S: the nodes of the pieces of level d + 1 that hold
  // their children, ascending, at least one: childNodes[childBegin[i]] … childNodes[childBegin[i +
  // 1] - 1]. Empty otherwise.
  std::vector<std::uint32_t> childBegin;
  std::vector<NodeId> childNodes;

  std::vector<Triangle>
    triangles; // local indices, ordered; orientation of the input, lowest index first
  std::vector<Attribute> attributes; // point arrays: own vertices, then ghosts

  std::uint32_t VertexCount() const { return static_cast<std::uint32_t>(this->positions.size()); }
  std::uint32_t GhostCount() const { return this->VertexCount() - this->ownVertices; }

  // The ranks of the ancestors of local vertex `v`, level R first; empty if the piece has none for
  // it.
  std::span<const std::uint32_t> AncestorsOf(std::uint32_t v, const TreeDepths& depths) const;
  // Whether no piece with a lower number has the triangle: keys ascend from piece to piece.
  bool Owns(const Triangle& triangle) const
  {
    return *std::min_element(triangle.begin(), triangle.end(),
             [this](VertexId a, VertexId b)
             { return this->keys[a] < this->keys[b]; }) < this->ownVertices;
  }
};

// Checks that a builder for a tree of these depths could have written `piece`: sizes agree; keys
// ascend and lie in the piece's node (own) or outside it (ghosts); indices are in range; a cluster
// has one parent, and its child pieces exist at the next level. For decoders: the drawing rule
// relies only on what is checked here, so hostile bytes cannot break it. O(size), plus O(log size)
// each time that an ancestor appears again.
Status CheckPiece(const Piece& piece, const TreeDepths& depths);

// Checks that the ranks of ancestors, and of vertices of a level coarser than S, are below the
// number of clusters of their level. clusters: this number for each level; if empty, nothing is
// checked. REQUIRES: the sizes in the piece agree. Errors: InvalidInput.
Status CheckRanks(
  const Piece& piece, const TreeDepths& depths, std::span<const std::uint64_t> clusters);

}
