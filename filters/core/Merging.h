// Which clusters of a level become one at the next coarser level: by merges of edges, and by
// grouping what cannot merge. For the makers of levels alone.
#pragma once

#include "filters/core/CollapseAttributes.h"
#include "filters/core/EdgeCollapse.h"
#include "filters/core/KdTree.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// A level, and what is known of its clusters beside it.
struct CollapseState
{
  ClusterLevel level;
  std::vector<ClusterSum> clusters;
  std::vector<std::uint32_t> cellOf; // finest cell of each cluster's lowest original vertex
  CollapseAttributes attributes;
};

// Every cluster of a level stands for itself at first. A cluster is at home in the cells that hold
// its lowest original vertex; it keeps the place it has, unless merged or grouped.
class Merging
{
public:
  enum class Position : std::uint8_t
  {
    Kept,
    Moved,  // by a merge
    Grouped // to be taken from the sums
  };

  // below: the level; depth: of the next coarser one. Keeps references to both.
  Merging(const CollapseState& below, const TreeDepths& depths, unsigned depth);

  // Applies merges that were made one after the other. Homes are known after GroupLoose.
  void Apply(std::span<const Merge> merges);
  // Groups the clusters that no triangle touches, one a cell of this depth. REQUIRED before
  // anything below is asked for.
  void GroupLoose();
  // Groups all clusters at home in the nodes for which full[node] is not 0 by cells of this depth,
  // or by the sheets of cells. Nodes are those that pieces of this depth are made of.
  void GroupNodes(std::span<const std::uint8_t> full, bool sheets);

  // The cluster that now stands for `cluster`.
  VertexId StandsFor(VertexId cluster) const { return this->Into[cluster]; }
  std::size_t NodeCount() const { return std::size_t{ 1 } << this->NodeDepth; }
  // The node that a standing cluster is at home in.
  std::size_t NodeOf(VertexId standing) const
  {
    return this->CellAt(this->NodeDepth, this->Cell[standing]);
  }
  // By how many clusters each node is above what a piece may hold.
  std::vector<std::size_t> ExcessOfNodes() const;
  // Standing clusters, by (cell of this depth, lowest original vertex).
  std::vector<VertexId> Standing() const;
  std::uint32_t FinestCellOf(VertexId standing) const { return this->Cell[standing]; }
  Position PositionOf(VertexId standing) const { return this->How[standing]; }
  // Relative. REQUIRES: PositionOf(standing) == Position::Moved.
  const Vec3& MovedTo(VertexId standing) const { return this->Positions[standing]; }

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
  std::vector<VertexId> Into;
  std::vector<Vec3> Positions;
  std::vector<Position> How;
  // Of standing clusters:
  std::vector<VertexId> Lowest;      // original vertex
  std::vector<std::uint32_t> Cell;   // finest, that holds it
  std::vector<std::uint8_t> Touched; // by a triangle of the new level
};

}
