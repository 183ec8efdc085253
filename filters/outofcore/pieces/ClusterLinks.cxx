// SPDX-License-Identifier: BSD-3-Clause
#include "filters/outofcore/pieces/ClusterLinks.h"

#include <algorithm>
#include <string>
#include <utility>

namespace kdstream
{

VertexId ClusterCount(const ExternalLevels& levels, unsigned depth)
{
  return depth < levels.firstInFiles ? static_cast<VertexId>(levels.coarse[depth].lowest.size())
                                     : levels.files[depth].ClusterCount();
}

Result<ParentLinks> ReadParents(const ExternalLevels& levels, unsigned depth, std::size_t block)
{
  const LevelFile& level = levels.files[depth];
  const VertexId begin = level.begin[block], end = level.begin[block + 1];
  ParentLinks links;
  if (depth == 0 || begin == end)
  {
    return links;
  }
  Result<std::vector<VertexId>> parents = ReadInterval<VertexId>(level.parents, begin, end);
  KDSTREAM_TRY(parents);
  const VertexId count = ClusterCount(levels, depth - 1);
  const auto least = std::min_element(parents->begin(), parents->end());
  const auto most = std::max_element(parents->begin(), parents->end());
  if (*most >= count)
  {
    const auto wrong = std::find_if(
      parents->begin(), parents->end(), [&](VertexId parent) { return parent >= count; });
    return Error{ ErrorCode::Damaged,
      "level " + std::to_string(depth) + ": the parent of cluster " +
        std::to_string(begin + (wrong - parents->begin())) + " is " + std::to_string(*wrong) +
        " of " + std::to_string(count) };
  }
  links.begin = *least;
  links.end = *most + 1;
  links.parents = std::move(*parents);
  for (VertexId& parent : links.parents)
  {
    parent -= links.begin;
  }
  return links;
}

Result<ClusterLinks> ReadLinks(const ExternalLevels& levels, unsigned depth, std::size_t block)
{
  Result<ParentLinks> above = ReadParents(levels, depth, block);
  KDSTREAM_TRY(above);
  const LevelFile& level = levels.files[depth];
  const VertexId begin = level.begin[block], end = level.begin[block + 1];
  ClusterLinks links;
  links.above = std::move(*above);
  links.lowest.reserve(end - begin);
  links.positions.reserve(end - begin);
  links.counts.reserve(end - begin);
  KDSTREAM_TRY(ForEachBlockOf<ClusterRecord>(level.clusters, begin, end,
    [&](std::span<const ClusterRecord> clusters)
    {
      for (const ClusterRecord& cluster : clusters)
      {
        links.lowest.push_back(cluster.lowest);
        links.positions.push_back(cluster.position);
        links.counts.push_back(cluster.count);
      }
    }));
  return links;
}

}
