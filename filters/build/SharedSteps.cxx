// SPDX-License-Identifier: BSD-3-Clause
#include "filters/build/SharedSteps.h"

#include "filters/core/EdgeCount.h"

#include <algorithm>

namespace kdstream
{

std::string InputNameOf(const std::filesystem::path& input, const BuildOptions& options)
{
  return options.inputName.empty() ? input.filename().string() : options.inputName;
}

Status CheckAttributeNames(std::span<const AttributeInfo> attributes)
{
  for (std::size_t i = 0; i < attributes.size(); ++i)
  {
    if (!IsAttributeName(attributes[i].name))
    {
      return Error{ ErrorCode::InvalidInput,
        "attribute " + std::to_string(i) + " has a name that is not valid UTF-8" };
    }
  }
  return {};
}

std::size_t ChunkOfRead(std::uint64_t memory)
{
  return static_cast<std::size_t>(std::min<std::uint64_t>(memory / 16, std::uint64_t{ 8 } << 20));
}

Result<std::uint64_t> CountMergedByGrid(const CoordinateGrid& grid, std::uint64_t vertices,
  bool mayCoincide, const std::function<Result<std::uint64_t>(const PlaceOfPoint&)>& count)
{
  if (grid.Lossless())
  {
    return std::uint64_t{ 0 };
  }
  const Result<std::uint64_t> exact = mayCoincide ? count({}) : Result<std::uint64_t>(vertices);
  KDSTREAM_TRY(exact);
  const Result<std::uint64_t> snapped = count([&](const Vec3& p) { return grid.Snap(p); });
  KDSTREAM_TRY(snapped);
  return *exact - std::min(*exact, *snapped);
}

std::uint64_t CountInconsistentEdges(const TreeBlock& block, const Execution& execution)
{
  return CountInconsistentEdges(block.mesh.triangles, block.mesh.points.size(), execution,
    [&](VertexId v) { return block.IsOwn(v); });
}

void MeasurePartitions(
  ModelFacts& facts, const std::function<std::uint64_t(std::size_t partition)>& sizeOf)
{
  facts.smallestPartition = facts.vertices;
  facts.largestPartition = 0;
  for (std::size_t p = 0; p < facts.partitions; ++p)
  {
    const std::uint64_t size = sizeOf(p);
    facts.smallestPartition = std::min(facts.smallestPartition, size);
    facts.largestPartition = std::max(facts.largestPartition, size);
  }
}

}
