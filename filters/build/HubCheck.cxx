// SPDX-License-Identifier: BSD-3-Clause
#include "filters/build/HubCheck.h"

#include "filters/core/tree/PointRecord.h"
#include "filters/outofcore/files/RecordFile.h"

#include <algorithm>
#include <string>
#include <vector>

namespace kdstream
{
namespace
{

constexpr std::uint64_t bytesPerTriangle = 480; // of a fan with its ghosts: measured

template <class Scalar>
Result<std::string> PlaceOf(const SpillFile& records, std::uint64_t rank)
{
  PointRecord<Scalar> record{};
  KDSTREAM_TRY(
    ReadRecords<PointRecord<Scalar>>(records, rank, std::span<PointRecord<Scalar>>(&record, 1)));
  std::string text;
  for (const Scalar x : record.p)
  {
    text += (text.empty() ? "(" : ", ") + std::to_string(double(x));
  }
  return text + ")";
}

}

Status CheckHubs(
  const MeshBlocks& mesh, const RecordBuckets<NumberedTriangle>& triangles, std::uint64_t limit)
{
  const std::uint64_t most = limit / bytesPerTriangle;
  for (std::size_t block = 0; block < triangles.BucketCount(); ++block)
  {
    if (triangles.Size(block) <= most)
    {
      continue;
    }
    const CellRange range = mesh.RangeOf(block);
    std::vector<std::uint32_t> counts(static_cast<std::size_t>(range.size), 0);
    KDSTREAM_TRY(triangles.ForEach(block,
      [&](const NumberedTriangle& t) -> Status
      {
        for (const VertexId rank : t.corners)
        {
          if (rank >= range.begin && rank - range.begin < range.size)
          {
            ++counts[static_cast<std::size_t>(rank - range.begin)];
          }
        }
        return {};
      }));
    const auto hub = std::max_element(counts.begin(), counts.end());
    if (hub == counts.end() || *hub <= most)
    {
      continue;
    }
    const auto rank = range.begin + static_cast<std::uint64_t>(hub - counts.begin());
    const Result<std::string> place =
      mesh.floats ? PlaceOf<float>(mesh.records, rank) : PlaceOf<double>(mesh.records, rank);
    KDSTREAM_TRY(place);
    const std::uint64_t need = ((*hub * bytesPerTriangle) >> 20) + 1;
    return Error{ ErrorCode::LimitExceeded,
      "the vertex at " + *place + " has " + std::to_string(*hub) +
        " triangles, which must be in memory together: use --memory " + std::to_string(need) +
        "M" };
  }
  return {};
}

}
