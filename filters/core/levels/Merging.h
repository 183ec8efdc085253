// SPDX-License-Identifier: BSD-3-Clause
// Decides which clusters of a level become one at the next coarser level: by merges of edges, and
// by grouping clusters that cannot merge. Only for the makers of levels.
#pragma once

#include "filters/core/collapse/EdgeCollapse.h"
#include "filters/core/levels/CollapseState.h"
#include "filters/core/tree/KdTree.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// Applies merges, in the order in which they were made. into: for each cluster the one that it goes
// to, at first itself. The vertex numbers of merges are positions in this list.
void ApplyMerges(std::span<const Merge> merges, std::span<VertexId> into);

// For each node whether it has any excess; empty if none has.
std::vector<std::uint8_t> FullNodes(std::span<const std::size_t> excess);

// The most clusters that may be at home in one node of a level's pieces.
std::size_t MostOfNode(const TreeDepths& depths, unsigned level);

// Where each own cluster of a block goes; at first to itself. A cluster that goes to itself is
// called standing. It is at home in the cells that hold its lowest original vertex, and keeps its
// position unless others merge into it or it is grouped.
class Merging
{
public:
  enum class Position : std::uint8_t
  {
    Kept,
    Moved,  // by a merge
    Grouped // to be computed from the sums
  };

  // below: a block of the level; depth: of the next coarser one. Keeps references to both.
  Merging(const CollapseState& below, const TreeDepths& depths, unsigned depth);

  // Applies merges in the order in which they were made; their numbers count from the first own
  // cluster. Homes are known after GroupLoose.
  void Apply(std::span<const Merge> merges);
  // Sets where ghosts go, in their order. Ghosts that go to the same cluster have equal numbers.
  void SetGhosts(std::span<const VertexId> targets);
  // Groups the own clusters that no triangle touches: one remains in each cell of this depth.
  // REQUIRED before the functions below.
  void GroupLoose();
  // Groups all own clusters that are at home in a node with full[node] != 0: by cells of this
  // depth, or by components of these cells. The nodes are those of the pieces of this depth.
  void GroupNodes(std::span<const std::uint8_t> full, bool byComponents);

  // The cluster that has replaced `cluster`.
  VertexId StandsFor(VertexId cluster) const { return this->Into[cluster]; }
  // Where each own cluster goes, numbered from the first of them.
  std::vector<VertexId> Targets() const;
  std::size_t NodeCount() const { return std::size_t{ 1 } << this->NodeDepth; }
  // The node in which a standing cluster is at home.
  std::size_t NodeOf(VertexId standing) const
  {
    return this->CellAt(this->NodeDepth, this->Cell[standing]);
  }
  // For each node, by how many own clusters it exceeds what a piece may hold.
  std::vector<std::size_t> ExcessOfNodes() const;
  // The own standing clusters, ordered by (cell of this depth, lowest original vertex).
  std::vector<VertexId> Standing() const;
  std::uint32_t FinestCellOf(VertexId standing) const { return this->Cell[standing]; }
  Position PositionOf(VertexId standing) const { return this->How[standing]; }
  // The new position, relative to CollapseSpace::origin. REQUIRES: PositionOf(standing) ==
  // Position::Moved.
  const Vec3& MovedTo(VertexId standing) const
  {
    return this->Positions[standing - this->Below.ownBegin];
  }

private:
  std::uint32_t CellAt(unsigned depth, std::uint32_t finestCell) const
  {
    return finestCell >> (this->Depths.finest - depth);
  }
  std::uint32_t CellOf(VertexId standing) const
  {
    return this->CellAt(this->Depth, this->Cell[standing]);
  }
  void FindHomes();
  void FindTouched();
  void Follow();
  void Group(VertexId cluster, VertexId to);
  void SortByCell(std::vector<VertexId>& standing) const;
  std::vector<VertexId> Components() const;
  template <class Visit>
  void ForEachCell(std::span<const VertexId> sorted, const Visit& visit) const;

  const CollapseState& Below;
  const TreeDepths& Depths;
  unsigned Depth;
  unsigned NodeDepth;
  // For all clusters, ghosts too:
  std::vector<VertexId> Into;
  std::vector<Position> How;
  std::vector<Vec3> Positions; // of own clusters, from the first one on
  // For clusters that did not merge into another:
  std::vector<VertexId> Lowest;      // original vertex
  std::vector<std::uint32_t> Cell;   // its finest cell; an invalid one for ghosts
  std::vector<std::uint8_t> Touched; // by a triangle of the new level
};

}
