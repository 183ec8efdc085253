// SPDX-License-Identifier: BSD-3-Clause
// Coincident vertices: see CoincidentRanks.h.
//   1. Put each place with its rank into a bucket, by the hash of the place. Ranks ascend in each
//      bucket.
//   2. In each bucket remember the last rank at each place.
#include "filters/outofcore/mesh/CoincidentRanks.h"

#include "filters/outofcore/files/BucketFile.h"
#include "filters/outofcore/mesh/LastRanks.h"

#include <algorithm>

namespace kdstream
{
namespace
{

using VisitPair = std::function<Status(VertexId, VertexId)>;

// Calls visit(record) for each vertex. In the record the id is the rank, and no zero is negative.
template <class Scalar, class Visit>
Status ForEachRank(const SpillFile& records, std::uint32_t count, const Visit& visit)
{
  RecordReader<PointRecord<Scalar>> reader(records, 0, count);
  for (VertexId rank = 0; rank < count;)
  {
    const auto block = reader.Next();
    KDSTREAM_TRY(block);
    for (const PointRecord<Scalar>& vertex : *block)
    {
      KDSTREAM_TRY(visit(RankedPlace(vertex, rank++)));
    }
  }
  return {};
}

}

template <class Scalar>
Status ForEachCoincidentPair(SpillFolder& folder, const SpillFile& records, std::uint32_t count,
  std::uint64_t memory, const VisitPair& visit)
{
  LastRanks<Scalar> last(visit);
  const auto add = [&](const PointRecord<Scalar>& vertex) { return last.Add(vertex); };
  const std::uint64_t most =
    std::max<std::uint64_t>(1, memory / 2 / LastRanks<Scalar>::bytesPerPlace);
  const std::uint64_t buckets = (std::uint64_t{ count } + most - 1) / most;
  if (buckets <= 1)
  {
    return ForEachRank<Scalar>(records, count, add);
  }
  Result<RecordBuckets<PointRecord<Scalar>>> sorted = RecordBuckets<PointRecord<Scalar>>::Create(
    folder, "places", static_cast<std::size_t>(buckets), count, memory / 4);
  KDSTREAM_TRY(sorted);
  KDSTREAM_TRY(ForEachRank<Scalar>(records, count,
    [&](const PointRecord<Scalar>& vertex)
    {
      const std::uint64_t hash = HashOfPlace(vertex.p, agreedSeed);
      return sorted->Add(static_cast<std::size_t>(((hash >> 32) * buckets) >> 32), vertex);
    }));
  KDSTREAM_TRY(sorted->Finish());
  for (std::size_t bucket = 0; bucket < buckets; ++bucket)
  {
    KDSTREAM_TRY(sorted->ForEach(bucket, add));
    last.Clear();
  }
  return {};
}

template Status ForEachCoincidentPair<float>(
  SpillFolder&, const SpillFile&, std::uint32_t, std::uint64_t, const VisitPair&);
template Status ForEachCoincidentPair<double>(
  SpillFolder&, const SpillFile&, std::uint32_t, std::uint64_t, const VisitPair&);

}
