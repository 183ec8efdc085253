// SPDX-License-Identifier: BSD-3-Clause
#include "filters/outofcore/pieces/CoarseTree.h"

#include "filters/core/pieces/VertexNumbers.h"
#include "filters/outofcore/files/ScatteredRead.h"
#include "filters/outofcore/pieces/ClusterLinks.h"
#include "filters/outofcore/pieces/CoarseNumbers.h"

#include <algorithm>
#include <utility>

namespace kdstream
{

CoarseTree::CoarseTree(
  const MeshBlocks& mesh, const ExternalLevels& levels, const ExternalNumbers& numbers)
  : Input(mesh)
  , Levels(levels)
  , Numbers(numbers)
  , WholeLevels(levels.firstInFiles)
{
}

Status CoarseTree::Load(BlockGroup& group)
{
  if (group.IsFirst())
  {
    KDSTREAM_TRY(this->LoadWhole());
    KDSTREAM_TRY(this->LoadChildNodes());
  }
  KDSTREAM_TRY(this->Spread(group));
  return this->FindPartitions();
}

// Fills in `first` and `parents` of the levels above those in files, by place.
Status CoarseTree::LoadWhole()
{
  Result<std::vector<std::vector<VertexId>>> first = FirstAboveFiles(this->Levels, this->Numbers);
  KDSTREAM_TRY(first);
  this->FirstOfWhole = std::move(*first);
  for (std::size_t d = 0; d < this->WholeLevels.size(); ++d)
  {
    const std::vector<VertexId>& numbers = this->FirstOfWhole[d];
    VertexTreeLevel& level = this->WholeLevels[d];
    std::vector<VertexId> places(numbers.size());
    for (const VertexId cluster : OrderByKey(numbers))
    {
      places[cluster] = static_cast<VertexId>(level.first.size());
      level.first.push_back(numbers[cluster]);
      if (d > 0)
      {
        level.parents.push_back(this->PlacesAboveFiles[this->Levels.coarse[d].parents[cluster]]);
      }
    }
    this->PlacesAboveFiles = std::move(places);
  }
  return {};
}

// Finds the child nodes of the finest level in memory from the coarsest level in files; then those
// of coarser levels, level by level.
Status CoarseTree::LoadChildNodes()
{
  const unsigned inFiles = this->Levels.firstInFiles;
  const VertexTree tree = TreeOfPartitions(this->Input);
  for (unsigned d = PreviewLevel(tree.depths); d < std::min(inFiles, tree.depths.stitch); ++d)
  {
    std::vector<ChildNode>& childNodes = this->WholeLevels[d].childNodes;
    if (d + 1 < inFiles)
    {
      const VertexTreeLevel& children = this->WholeLevels[d + 1];
      childNodes = ChildNodesOfParents(tree, d + 1, children.first, children.parents);
      continue;
    }
    for (std::size_t block = 0; block < this->Levels.files[inFiles].BlockCount(); ++block)
    {
      const Result<std::vector<ChildNode>> ofBlock =
        ReadChildNodesOfParents(this->Levels, this->Numbers, tree, inFiles, block);
      KDSTREAM_TRY(ofBlock);
      for (const ChildNode& entry : *ofBlock)
      {
        childNodes.push_back({ this->PlacesAboveFiles[entry.cluster], entry.node });
      }
    }
    std::sort(childNodes.begin(), childNodes.end());
    childNodes.erase(std::unique(childNodes.begin(), childNodes.end()), childNodes.end());
  }
  return {};
}

Status CoarseTree::Spread(BlockGroup& group)
{
  for (VertexTreeLevel& level : this->WholeLevels)
  {
    KDSTREAM_TRY(group.Spread(level.first));
    KDSTREAM_TRY(group.Spread(level.parents));
  }
  return {};
}

Status CoarseTree::FindPartitions()
{
  const std::uint64_t partitions = std::uint64_t{ 1 } << this->Input.depths.partition;
  const unsigned stitch = this->Input.depths.stitch;
  this->PartitionOf.emplace(this->Input.vertexCount, this->Input.depths.partition);
  VertexId rank = 0;
  KDSTREAM_TRY(ForEachBlockOf<RankedCluster>(this->Numbers.ranked[stitch], 0,
    this->Levels.files[stitch].ClusterCount(),
    [&](std::span<const RankedCluster> clusters)
    {
      for (const RankedCluster& cluster : clusters)
      {
        const std::size_t partition = (*this->PartitionOf)(cluster.first);
        while (this->StitchBegin.size() <= partition)
        {
          this->StitchBegin.push_back(rank);
        }
        ++rank;
      }
    }));
  this->StitchBegin.resize(static_cast<std::size_t>(partitions + 1), rank);
  return {};
}

Status CoarseTree::AppendOwn(const CellRange& own, VertexTreeLevel& level) const
{
  if (own.size == 0)
  {
    return {};
  }
  const auto first = static_cast<VertexId>(own.begin);
  const VertexId begin = this->StitchBegin[(*this->PartitionOf)(first)];
  const std::size_t last = (*this->PartitionOf)(static_cast<VertexId>(first + own.size - 1));
  const Result<std::vector<RankedCluster>> clusters = ReadInterval<RankedCluster>(
    this->Numbers.ranked[this->Input.depths.stitch], begin, this->StitchBegin[last + 1]);
  KDSTREAM_TRY(clusters);
  for (std::size_t i = 0; i < clusters->size(); ++i)
  {
    level.first.push_back((*clusters)[i].first);
    level.ranks.push_back(begin + static_cast<VertexId>(i));
    level.parents.push_back((*clusters)[i].parentRank);
  }
  return {};
}

Status CoarseTree::AppendHolders(std::span<const VertexId> numbers, VertexTreeLevel& level) const
{
  std::vector<VertexId> ranks; // of all clusters in the partitions of the numbers
  std::size_t next = 0;        // the next partition
  for (const VertexId number : numbers)
  {
    const std::size_t partition = (*this->PartitionOf)(number);
    if (partition >= next)
    {
      next = partition + 1;
      for (VertexId rank = this->StitchBegin[partition]; rank < this->StitchBegin[next]; ++rank)
      {
        ranks.push_back(rank);
      }
    }
  }
  std::vector<RankedCluster> clusters(ranks.size());
  KDSTREAM_TRY(ReadRecordsAt<RankedCluster>(
    this->Numbers.ranked[this->Input.depths.stitch], ranks, std::span<RankedCluster>(clusters)));
  for (std::size_t i = 0, at = 0; at < numbers.size() && i < clusters.size(); ++i)
  {
    const bool last = i + 1 == clusters.size();
    const std::size_t before = at;
    while (at < numbers.size() && (last || numbers[at] < clusters[i + 1].first))
    {
      ++at;
    }
    if (at > before)
    {
      level.first.push_back(clusters[i].first);
      level.ranks.push_back(ranks[i]);
      level.parents.push_back(clusters[i].parentRank);
    }
  }
  return {};
}

Result<std::vector<VertexTreeLevel>> CoarseTree::AncestorsOf(
  const CellRange& own, std::span<const VertexId> ghosts) const
{
  const unsigned stitch = this->Input.depths.stitch;
  std::vector<VertexTreeLevel> levels(stitch + std::size_t{ 1 });
  const std::size_t before = static_cast<std::size_t>(
    std::lower_bound(ghosts.begin(), ghosts.end(), own.begin) - ghosts.begin());
  KDSTREAM_TRY(this->AppendHolders(ghosts.first(before), levels[stitch]));
  KDSTREAM_TRY(this->AppendOwn(own, levels[stitch]));
  KDSTREAM_TRY(this->AppendHolders(ghosts.subspan(before), levels[stitch]));
  KDSTREAM_TRY(this->AddAncestors(levels));
  return levels;
}

Result<std::vector<VertexTreeLevel>> CoarseTree::AncestorsOfRanks(
  unsigned depth, std::vector<VertexId> ranks) const
{
  std::vector<VertexTreeLevel> levels(depth + std::size_t{ 1 });
  levels[depth].ranks = std::move(ranks);
  KDSTREAM_TRY(this->ReadParentRanks(depth, levels[depth]));
  KDSTREAM_TRY(this->AddAncestors(levels));
  return levels;
}

// Reads the ranks of the parents of clusters whose own ranks are known.
Status CoarseTree::ReadParentRanks(unsigned depth, VertexTreeLevel& level) const
{
  std::vector<RankedCluster> clusters(level.ranks.size());
  KDSTREAM_TRY(ReadRecordsAt<RankedCluster>(
    this->Numbers.ranked[depth], level.ranks, std::span<RankedCluster>(clusters)));
  level.parents.reserve(clusters.size());
  for (const RankedCluster& cluster : clusters)
  {
    level.parents.push_back(cluster.parentRank);
  }
  return {};
}

// Goes up from the last level. The parents of the last level are still ranks, and become indices.
Status CoarseTree::AddAncestors(std::vector<VertexTreeLevel>& levels) const
{
  const unsigned coarsest = PreviewLevel(this->Input.depths);
  for (std::size_t d = levels.size() - 1; d > std::max(coarsest, this->Levels.firstInFiles); --d)
  {
    std::vector<VertexId>& parents = levels[d].parents;
    std::vector<VertexId>& ranks = levels[d - 1].ranks;
    ranks = parents;
    std::sort(ranks.begin(), ranks.end());
    ranks.erase(std::unique(ranks.begin(), ranks.end()), ranks.end());
    for (VertexId& parent : parents)
    {
      parent =
        static_cast<VertexId>(std::lower_bound(ranks.begin(), ranks.end(), parent) - ranks.begin());
    }
    KDSTREAM_TRY(this->ReadParentRanks(static_cast<unsigned>(d - 1), levels[d - 1]));
  }
  const auto last = static_cast<unsigned>(levels.size() - 1);
  const unsigned top = std::min(last, std::max(coarsest, this->Levels.firstInFiles));
  if (top <= coarsest)
  {
    levels[top].parents.clear(); // nobody uses coarser levels
  }
  return {};
}

}
