// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/levels/Merging.h"

#include "filters/core/DisjointSets.h"
#include "filters/core/levels/CellComponents.h"
#include "filters/core/tree/PieceDepth.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace kdstream
{

Merging::Merging(const CollapseState& below, const TreeDepths& depths, unsigned depth)
  : Below(below)
  , Depths(depths)
  , Depth(depth)
  , NodeDepth(PieceDepth(Resolution::Level(depth), depths))
  , Into(below.Count())
  , How(below.Count(), Position::Kept)
  , Positions(below.OwnCount())
  , Lowest(below.level.lowest)
  , Cell(below.Count(), std::numeric_limits<std::uint32_t>::max())
{
  std::iota(this->Into.begin(), this->Into.end(), VertexId{ 0 });
}

void ApplyMerges(std::span<const Merge> merges, std::span<VertexId> into)
{
  for (std::size_t i = merges.size(); i-- > 0;) // backwards: it is already known where `to` goes
  {
    into[merges[i].from] = into[merges[i].to];
  }
}

std::vector<std::uint8_t> FullNodes(std::span<const std::size_t> excess)
{
  std::vector<std::uint8_t> full(excess.size());
  std::transform(excess.begin(), excess.end(), full.begin(),
    [](std::size_t count) { return static_cast<std::uint8_t>(count > 0); });
  if (std::find(full.begin(), full.end(), 1) == full.end())
  {
    full.clear();
  }
  return full;
}

std::size_t MostOfNode(const TreeDepths& depths, unsigned level)
{
  return mostCellComponents << (level - PieceDepth(Resolution::Level(level), depths));
}

void Merging::Apply(std::span<const Merge> merges)
{
  const VertexId first = this->Below.ownBegin;
  for (std::size_t i = merges.size(); i-- > 0;) // backwards: as above
  {
    const VertexId to = merges[i].to + first;
    this->Into[merges[i].from + first] = this->Into[to];
    if (this->Into[to] == to && this->How[to] == Position::Kept)
    {
      this->Positions[merges[i].to] = merges[i].position;
      this->How[to] = Position::Moved;
    }
  }
}

void Merging::SetGhosts(std::span<const VertexId> targets)
{
  std::vector<std::pair<VertexId, VertexId>> ghosts; // target, ghost
  for (VertexId c = 0; c < this->Into.size(); ++c)
  {
    if (!this->Below.IsOwn(c))
    {
      ghosts.emplace_back(targets[ghosts.size()], c);
    }
  }
  std::sort(ghosts.begin(), ghosts.end());
  for (std::size_t i = 0; i < ghosts.size(); ++i)
  {
    const bool first = i == 0 || ghosts[i].first != ghosts[i - 1].first;
    const VertexId ghost = ghosts[i].second;
    this->Into[ghost] = first ? ghost : this->Into[ghosts[i - 1].second];
  }
}

std::vector<VertexId> Merging::Targets() const
{
  std::vector<VertexId> targets(this->Below.OwnCount());
  for (std::size_t i = 0; i < targets.size(); ++i)
  {
    targets[i] = this->Into[this->Below.ownBegin + i] - this->Below.ownBegin;
  }
  return targets;
}

void Merging::FindHomes()
{
  std::fill(this->Lowest.begin(), this->Lowest.end(), noVertex);
  for (VertexId c = this->Below.ownBegin; c < this->Below.ownEnd; ++c)
  {
    const VertexId to = this->Into[c];
    if (this->Below.level.lowest[c] < this->Lowest[to])
    {
      this->Lowest[to] = this->Below.level.lowest[c];
      this->Cell[to] = this->Below.cellOf[c - this->Below.ownBegin];
    }
  }
}

void Merging::FindTouched()
{
  this->Touched.assign(this->Into.size(), 0);
  for (const Triangle& t : this->Below.level.triangles)
  {
    const VertexId a = this->Into[t[0]], b = this->Into[t[1]], c = this->Into[t[2]];
    if (a != b && b != c && c != a)
    {
      this->Touched[a] = this->Touched[b] = this->Touched[c] = 1;
    }
  }
}

// After grouping: a cluster that had merged into another goes where that one went.
void Merging::Follow()
{
  for (VertexId& to : this->Into)
  {
    to = this->Into[to];
  }
  this->FindHomes();
  this->FindTouched();
}

void Merging::Group(VertexId cluster, VertexId to)
{
  if (cluster != to)
  {
    this->Into[cluster] = to;
    this->How[to] = Position::Grouped;
  }
}

void Merging::SortByCell(std::vector<VertexId>& standing) const
{
  std::sort(standing.begin(), standing.end(),
    [&](VertexId a, VertexId b)
    {
      const std::uint32_t cellOfA = this->CellOf(a), cellOfB = this->CellOf(b);
      return cellOfA != cellOfB ? cellOfA < cellOfB : this->Lowest[a] < this->Lowest[b];
    });
}

std::vector<VertexId> Merging::Standing() const
{
  std::vector<VertexId> standing;
  for (VertexId c = this->Below.ownBegin; c < this->Below.ownEnd; ++c)
  {
    if (this->Into[c] == c)
    {
      standing.push_back(c);
    }
  }
  this->SortByCell(standing);
  return standing;
}

// Calls visit(clusters) for the clusters of each cell in a sorted list.
template <class Visit>
void Merging::ForEachCell(std::span<const VertexId> sorted, const Visit& visit) const
{
  for (std::size_t begin = 0; begin < sorted.size();)
  {
    std::size_t end = begin;
    while (end < sorted.size() && this->CellOf(sorted[end]) == this->CellOf(sorted[begin]))
    {
      ++end;
    }
    visit(sorted.subspan(begin, end - begin));
    begin = end;
  }
}

void Merging::GroupLoose()
{
  this->FindHomes();
  this->FindTouched();
  std::vector<VertexId> loose;
  for (VertexId c = this->Below.ownBegin; c < this->Below.ownEnd; ++c)
  {
    if (this->Into[c] == c && !this->Touched[c])
    {
      loose.push_back(c);
    }
  }
  this->SortByCell(loose);
  this->ForEachCell(loose,
    [&](std::span<const VertexId> cell)
    {
      for (const VertexId c : cell)
      {
        this->Group(c, cell[0]);
      }
    });
  this->Follow();
}

// The components of standing clusters that triangles link inside a cell, as a forest.
std::vector<VertexId> Merging::Components() const
{
  std::vector<VertexId> parent(this->Into.size());
  std::iota(parent.begin(), parent.end(), VertexId{ 0 });
  for (const Triangle& t : this->Below.level.triangles)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      const VertexId a = this->Into[t[k]], b = this->Into[t[(k + 1) % 3]];
      if (this->CellOf(a) == this->CellOf(b))
      {
        Join(parent, a, b);
      }
    }
  }
  return parent;
}

void Merging::GroupNodes(std::span<const std::uint8_t> full, bool byComponents)
{
  std::vector<VertexId> parent = this->Components();
  std::vector<CellComponent> components(this->Into.size());
  for (VertexId c = this->Below.ownBegin; c < this->Below.ownEnd; ++c)
  {
    CellComponent& component = components[this->Into[c]];
    const ClusterSum& cluster = this->Below.clusters[c - this->Below.ownBegin];
    component.count += cluster.count;
    for (std::size_t k = 0; k < 3; ++k)
    {
      component.sum[k] += cluster.sum[k];
    }
    component.surface = this->Touched[this->Into[c]] != 0;
  }
  std::vector<VertexId> members = this->Standing();
  std::erase_if(members, [&](VertexId c) { return full[this->NodeOf(c)] == 0; });
  this->ForEachCell(members,
    [&](std::span<const VertexId> cell)
    {
      std::vector<VertexId> first; // of each group
      GroupCell(
        cell, byComponents, [&](VertexId c) { return FindRoot(parent, c); },
        [&](VertexId c) { return components[c]; },
        [&](VertexId c, std::size_t group)
        {
          if (group == first.size())
          {
            first.push_back(c);
          }
          this->Group(c, first[group]);
        });
    });
  this->Follow();
}

std::vector<std::size_t> Merging::ExcessOfNodes() const
{
  std::vector<std::size_t> counts(this->NodeCount(), 0);
  for (VertexId c = this->Below.ownBegin; c < this->Below.ownEnd; ++c)
  {
    if (this->Into[c] == c)
    {
      ++counts[this->NodeOf(c)];
    }
  }
  const std::size_t limit = MostOfNode(this->Depths, this->Depth);
  for (std::size_t& count : counts)
  {
    count -= std::min(count, limit);
  }
  return counts;
}

}
