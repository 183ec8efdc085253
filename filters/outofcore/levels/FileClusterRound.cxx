// SPDX-License-Identifier: BSD-3-Clause
#include "filters/outofcore/levels/FileClusterRound.h"

#include "filters/outofcore/files/RecordFile.h"

#include <algorithm>

namespace kdstream
{
namespace
{

// The clusters of a block, and the triangles and links that connect them.
struct ClusterBlock
{
  std::vector<ClusterSum> clusters;
  std::vector<std::uint32_t> cellOf;
  std::vector<Triangle> triangles;
  std::vector<Link> links;
};

Status Load(const LinkedLevel& from, std::size_t index, ClusterBlock& block)
{
  const LevelFile& level = from.level;
  const VertexId begin = level.begin[index], end = level.begin[index + 1];
  block.clusters.reserve(end - begin);
  block.cellOf.reserve(end - begin);
  KDSTREAM_TRY(ForEachBlockOf<ClusterState>(from.states.sums, begin, end,
    [&](std::span<const ClusterState> states)
    {
      for (const ClusterState& state : states)
      {
        block.clusters.push_back(state.sum);
        block.cellOf.push_back(state.cellOf);
      }
    }));
  KDSTREAM_TRY(from.links.Load(index, index + 1, block.triangles));
  for (const Triangle& link : block.triangles)
  {
    AppendLinkOf(link, block.links);
  }
  const std::uint64_t first = level.triangleBegin[index];
  block.triangles.resize(static_cast<std::size_t>(level.triangleBegin[index + 1] - first));
  return ReadRecords<Triangle>(level.triangles, first, std::span(block.triangles));
}

}

Status MakeCoarserClustersInFiles(SpillFolder& folder, const LinkedLevel& below, unsigned depth,
  const LevelArrays& arrays, const ClusterRules& rules, LevelWriter& coarser,
  const Execution& execution, const std::function<Status(double)>& report)
{
  LevelFile& level = below.level;
  Result<SpillFile> file = folder.CreateFile(
    "parents of clusters", level.ClusterCount() * std::uint64_t{ sizeof(VertexId) });
  KDSTREAM_TRY(file);
  level.parents = std::move(*file);
  for (std::size_t index = below.here.begin; index < below.here.end; ++index)
  {
    const VertexId first = level.begin[index], base = coarser.ClusterCount();
    ClusterBlock block;
    KDSTREAM_TRY(Load(below, index, block));
    std::vector<VertexId> parents;
    const CollapseState made =
      MakeCoarserClusters({ block.clusters, block.cellOf, first, block.triangles, block.links },
        depth, rules, parents, execution);
    const Result<AttributeSums> sums =
      LoadAttributeSums(below.states, arrays, first, parents.size());
    KDSTREAM_TRY(sums);
    std::vector<VertexId> lowest;
    std::transform(block.clusters.begin(), block.clusters.end(), std::back_inserter(lowest),
      [](const ClusterSum& cluster) { return cluster.lowest; });
    KDSTREAM_TRY(coarser.Append(made, sums->MakeCoarser(parents, lowest, made.clusters.size())));
    std::for_each(parents.begin(), parents.end(), [&](VertexId& parent) { parent += base; });
    KDSTREAM_TRY(WriteRecords<VertexId>(level.parents, first, std::span<const VertexId>(parents)));
    KDSTREAM_TRY(
      report(double(index + 1 - below.here.begin) / double(below.here.end - below.here.begin)));
  }
  return {};
}

}
