// SPDX-License-Identifier: BSD-3-Clause
#include "filters/outofcore/levels/LevelGeometricErrors.h"

#include "filters/core/levels/GeometricErrorBins.h"
#include "filters/outofcore/files/RecordFile.h"

#include <algorithm>

namespace kdstream
{
namespace
{

constexpr std::uint64_t batch = 1 << 14; // clusters read at once

// Adds the geometric errors of the clusters of some blocks to the bins.
Status AddBlocks(const LevelFile& level, const BlockRange& blocks, GeometricErrorBins& bins)
{
  const std::uint64_t end = level.begin[blocks.end];
  std::vector<ClusterRecord> clusters;
  for (std::uint64_t first = level.begin[blocks.begin]; first < end; first += clusters.size())
  {
    clusters.resize(static_cast<std::size_t>(std::min(batch, end - first)));
    KDSTREAM_TRY(
      ReadRecords<ClusterRecord>(level.clusters, first, std::span<ClusterRecord>(clusters)));
    for (const ClusterRecord& cluster : clusters)
    {
      bins.Add(cluster.geometricError);
    }
  }
  return {};
}

// Adds the geometric errors of the clusters of all processes in `group`.
Status AddLevel(
  const ExternalLevels& levels, unsigned depth, const BlockGroup& group, GeometricErrorBins& bins)
{
  if (depth >= levels.firstInFiles)
  {
    const LevelFile& file = levels.files[depth];
    return AddBlocks(file, group.Here(file.blockDepth), bins);
  }
  for (const double geometricError : levels.coarse[depth].geometricErrors)
  {
    bins.Add(geometricError);
  }
  return {};
}

}

Result<std::vector<double>> GeometricErrorsOfLevels(
  const ExternalLevels& levels, const TreeDepths& depths, BlockGroup* group)
{
  BlockGroup alone;
  BlockGroup& all = group ? *group : alone;
  std::vector<double> geometricErrors;
  for (unsigned depth = 0; depth <= depths.finest; ++depth)
  {
    GeometricErrorBins bins;
    if (depth > depths.stitch || all.IsFirst())
    {
      KDSTREAM_TRY(AddLevel(levels, depth, depth > depths.stitch ? all : alone, bins));
    }
    KDSTREAM_TRY(all.Sum(bins.Counts()));
    geometricErrors.push_back(bins.Most99());
  }
  return geometricErrors;
}

}
