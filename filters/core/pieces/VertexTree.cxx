// SPDX-License-Identifier: BSD-3-Clause
// Numbering of the vertex tree of a mesh in memory: see VertexTree.h, and VertexNumbers.h for the
// steps.
#include "filters/core/pieces/VertexTree.h"

#include "filters/core/pieces/VertexNumbers.h"

#include <algorithm>

namespace kdstream
{
namespace
{

// The lowest numbered vertex of every cluster.
std::vector<std::vector<VertexId>> FirstVertices(
  const ClusterLevels& levels, const VertexTree& tree, const Execution& execution)
{
  const std::size_t stitch = tree.depths.stitch;
  const auto links = [&](std::size_t d)
  {
    const ClusterLevel& level = levels.levels[d];
    return ClusterParents{ level.parents, level.lowest, level.positions };
  };
  // First count the original vertices of each cluster, from the finest level up to S.
  std::vector<std::vector<VertexId>> first(levels.levels.size());
  first.back().assign(levels.levels.back().lowest.size(), 0);
  for (const VertexId cluster : levels.finest)
  {
    ++first.back()[cluster];
  }
  for (std::size_t d = levels.levels.size() - 1; d > stitch; --d)
  {
    first[d - 1].assign(levels.levels[d - 1].lowest.size(), 0);
    for (std::size_t child = 0; child < first[d].size(); ++child)
    {
      first[d - 1][levels.levels[d].parents[child]] += first[d][child];
    }
  }

  std::vector<ClusterParents> coarse;
  for (std::size_t d = 0; d <= stitch; ++d)
  {
    coarse.push_back(links(d));
  }
  std::vector<std::vector<VertexId>> ofCoarse =
    FirstOfCoarseClusters(coarse, first[stitch], tree.partitionBegin);
  std::move(ofCoarse.begin(), ofCoarse.end(), first.begin());
  for (std::size_t d = stitch + 1; d < first.size(); ++d)
  {
    first[d] = FirstOfChildren(links(d), first[d], first[d - 1], execution);
  }
  return first;
}

}

std::uint32_t VertexTree::PartitionOf(VertexId numbered, std::uint32_t guess) const
{
  if (numbered >= this->partitionBegin[guess] && numbered < this->partitionBegin[guess + 1])
  {
    return guess;
  }
  const auto above =
    std::upper_bound(this->partitionBegin.begin(), this->partitionBegin.end(), numbered);
  return static_cast<std::uint32_t>(above - this->partitionBegin.begin()) - 1;
}

VertexKey VertexTree::KeyOf(VertexId numbered, std::uint32_t guess) const
{
  const std::uint32_t partition = this->PartitionOf(numbered, guess);
  return MakeKey(partition, numbered - this->partitionBegin[partition]);
}

VertexId VertexTree::ClusterAt(unsigned depth, VertexId numbered) const
{
  const std::vector<VertexId>& first = this->levels[depth].first;
  return static_cast<VertexId>(
           std::upper_bound(first.begin(), first.end(), numbered) - first.begin()) -
         1;
}

VertexTree NumberVertices(const KdTree& tree, ClusterLevels levels, const Execution& execution)
{
  VertexTree numbered;
  numbered.depths = tree.depths;
  const std::size_t cells = std::size_t{ 1 } << (tree.depths.finest - tree.depths.partition);
  for (std::size_t cell = 0; cell < tree.cellBegin.size(); cell += cells)
  {
    numbered.partitionBegin.push_back(tree.cellBegin[cell]);
  }
  if (levels.levels.empty())
  {
    numbered.original = tree.order;
    return numbered;
  }
  std::vector<std::vector<VertexId>> first = FirstVertices(levels, numbered, execution);
  numbered.original = OrderVertices(levels.finest, first.back(), 0, {}, execution);
  numbered.levels.resize(levels.levels.size());
  std::vector<VertexId> places;
  for (std::size_t d = 0; d < levels.levels.size(); ++d)
  {
    OrderedLevel ordered = OrderLevel(std::move(levels.levels[d]), first[d], places, execution);
    numbered.levels[d] = std::move(ordered.level);
    places = std::move(ordered.places);
    first[d] = {};
  }
  for (unsigned d = PreviewLevel(numbered.depths); d < numbered.depths.stitch; ++d)
  {
    const VertexTreeLevel& children = numbered.levels[d + 1];
    numbered.levels[d].childNodes =
      ChildNodesOfParents(numbered, d + 1, children.first, children.parents);
  }
  return numbered;
}

}
