// SPDX-License-Identifier: BSD-3-Clause
// A coarser level by clusters: see ClusterRound.h.
//   1. Inside each cell join clusters along triangles' edges and links.
//   2. Number the components by cell and lowest vertex; sum up, find representatives.
//   3. Make the image of the triangles; collapsed triangles leave links.
#include "filters/core/levels/ClusterRound.h"

#include "filters/core/DisjointSets.h"
#include "filters/core/levels/CellComponents.h"
#include "filters/core/levels/FinestClusters.h"
#include "filters/core/levels/LevelProgress.h"

#include <numeric>

namespace kdstream
{
namespace
{

class ClusterRound
{
public:
  ClusterRound(const ClusterPart& below, unsigned depth, const ClusterRules& rules)
    : Below(below)
    , Depth(depth)
    , Rules(rules)
    , Shift(rules.finest - depth)
  {
  }

  CollapseState Run(std::vector<VertexId>& parents, const Execution& execution)
  {
    this->FindComponents();
    this->NumberClusters(parents);
    RepresentClusters(this->Coarser.clusters, this->Rules.options.representative,
      this->Rules.origin, this->Coarser.level, execution);
    this->Coarser.ownEnd = static_cast<VertexId>(this->Coarser.clusters.size());
    return std::move(this->Coarser);
  }

private:
  std::uint32_t CellOf(std::size_t cluster) const
  {
    return this->Below.cellOf[cluster] >> this->Shift;
  }

  void FindComponents()
  {
    this->Root.resize(this->Below.clusters.size());
    std::iota(this->Root.begin(), this->Root.end(), VertexId{ 0 });
    for (const Triangle& t : this->Below.triangles)
    {
      this->JoinInCell(t[0], t[1]);
      this->JoinInCell(t[1], t[2]);
      this->JoinInCell(t[2], t[0]);
    }
    for (const Link& link : this->Below.links)
    {
      this->JoinInCell(link.first, link.second);
    }
  }

  // a, b: numbers in the level.
  void JoinInCell(VertexId a, VertexId b)
  {
    a -= this->Below.first; // huge if it was below the first one
    b -= this->Below.first;
    if (a < this->Root.size() && b < this->Root.size() && this->CellOf(a) == this->CellOf(b))
    {
      Join(this->Root, a, b);
    }
  }

  void NumberClusters(std::vector<VertexId>& parents)
  {
    const std::size_t count = this->Below.clusters.size();
    parents.resize(count);
    const std::size_t most =
      std::min(count, (this->Rules.options.byComponents ? mostCellComponents : 1) << this->Depth);
    this->Coarser.clusters.reserve(most);
    this->Coarser.cellOf.reserve(most);
    std::vector<VertexId> members;
    for (std::size_t first = 0; first < count;)
    {
      std::size_t end = first;
      members.clear();
      while (end < count && this->CellOf(end) == this->CellOf(first))
      {
        members.push_back(static_cast<VertexId>(end++));
      }
      std::sort(members.begin(), members.end(),
        [&](VertexId a, VertexId b)
        { return this->Below.clusters[a].lowest < this->Below.clusters[b].lowest; });
      this->AddCell(members, parents);
      first = end;
    }
  }

  // members: the clusters of a cell, by lowest original vertex.
  void AddCell(std::span<const VertexId> members, std::vector<VertexId>& parents)
  {
    const std::size_t offset = this->Coarser.clusters.size();
    const std::size_t count = GroupCell(
      members, this->Rules.options.byComponents,
      [&](VertexId m) { return FindRoot(this->Root, m); },
      [&](VertexId m)
      {
        const ClusterSum& c = this->Below.clusters[m];
        return CellComponent{ c.count, c.sum, c.surface, 0 };
      },
      [&](VertexId m, std::size_t local) { parents[m] = static_cast<VertexId>(offset + local); });
    this->Coarser.clusters.resize(offset + count);
    for (const VertexId m : members)
    {
      this->Coarser.clusters[parents[m]].Add(this->Below.clusters[m]);
      if (parents[m] == this->Coarser.cellOf.size()) // the child with the lowest vertex
      {
        this->Coarser.cellOf.push_back(this->Below.cellOf[m]);
      }
    }
  }

  const ClusterPart& Below;
  const unsigned Depth;
  const ClusterRules& Rules;
  const unsigned Shift; // from finest cells to those of the coarser level
  std::vector<VertexId> Root;
  CollapseState Coarser;
};

}

CollapseState MakeCoarserClusters(const ClusterPart& below, unsigned depth,
  const ClusterRules& rules, std::vector<VertexId>& parents, const Execution& execution)
{
  return ClusterRound(below, depth, rules).Run(parents, execution);
}

void SortLinks(std::vector<Link>& links)
{
  std::sort(links.begin(), links.end());
  links.erase(std::unique(links.begin(), links.end()), links.end());
}

std::vector<Link> ImageOfLinks(
  std::span<const Triangle> triangles, std::span<const Link> links, std::span<const VertexId> map)
{
  std::vector<Link> image;
  const auto add = [&](const Triangle& t) {
    AppendLinkOf({ map[t[0]], map[t[1]], map[t[2]] }, image);
  };
  std::for_each(triangles.begin(), triangles.end(), add);
  std::for_each(
    links.begin(), links.end(), [&](const Link& link) { add(CollapsedTriangleOf(link)); });
  SortLinks(image);
  return image;
}

Result<std::vector<ClusterLevel>> BuildCoarserClusterLevels(CollapseState state,
  std::vector<Link> links, unsigned depth, const ClusterRules& rules, const Execution& execution)
{
  std::vector<ClusterLevel> levels(depth + 1);
  while (depth > rules.options.coarsestDepth)
  {
    KDSTREAM_TRY(execution.Report(
      "levels", finestMadePart + (1 - finestMadePart) * CoarserPart(depth, rules.finest)));
    ClusterLevel& below = levels[depth] = std::move(state.level);
    state = MakeCoarserClusters({ state.clusters, state.cellOf, 0, below.triangles, links },
      --depth, rules, below.parents, execution);
    state.level.triangles = ImageOfTriangles(below.triangles, below.parents, execution);
    links = ImageOfLinks(below.triangles, links, below.parents);
  }
  levels[depth] = std::move(state.level);
  return levels;
}

}
