// SPDX-License-Identifier: BSD-3-Clause
#include "filters/Parallel/DistributedPlaceCount.h"

#include "filters/core/SeededHash.h"
#include "filters/core/VectorMath.h"
#include "filters/outofcore/files/BucketFile.h"
#include "filters/outofcore/files/NumberSet.h"
#include "filters/outofcore/files/RecordFile.h"
#include "filters/outofcore/files/RepeatedHashes.h"

#include <algorithm>
#include <span>
#include <vector>

namespace kdstream
{
namespace
{

std::uint64_t HashOf(const Vec3& place)
{
  return HashOfPlace(WithPositiveZeros(place), agreedSeed);
}

// Sends the hash of every place to the rank that the hash determines, and puts it into a bucket
// there.
Status SendHashes(MpiGroup& group, const VertexFiles& vertices,
  const std::function<Vec3(const Vec3&)>& placeOf, RecordBuckets<std::uint64_t>& hashes)
{
  constexpr std::size_t ofRound = ElementsOfRound(sizeof(Vec3));
  const auto make = [&](std::uint64_t round, RankLists<std::uint64_t>& out) -> Status
  {
    const std::uint64_t from = round * ofRound;
    std::vector<Vec3> points(std::min<std::uint64_t>(ofRound, vertices.count - from));
    KDSTREAM_TRY(ReadRecords<Vec3>(vertices.points, from, std::span<Vec3>(points)));
    for (const Vec3& point : points)
    {
      const std::uint64_t hash = HashOf(placeOf ? placeOf(point) : point);
      out[hash % group.Count()].push_back(hash);
    }
    return {};
  };
  const auto take = [&](std::size_t, std::span<const std::uint64_t> list) -> Status
  {
    for (const std::uint64_t hash : list)
    {
      KDSTREAM_TRY(
        hashes.Add(static_cast<std::size_t>(hash / group.Count() % hashes.BucketCount()), hash));
    }
    return {};
  };
  KDSTREAM_TRY(
    group.ExchangeInRounds<std::uint64_t>(RoundsOf(vertices.count, ofRound), make, take));
  return hashes.Finish();
}

// Counts the distinct hashes of a bucket. Most occur once; only the others are sorted.
Result<std::uint64_t> CountDifferent(
  const RecordBuckets<std::uint64_t>& hashes, std::size_t bucket, std::uint64_t memory)
{
  RepeatedHashes repeated(hashes.Size(bucket), memory);
  KDSTREAM_TRY(hashes.ForEach(bucket,
    [&](std::uint64_t hash) -> Status
    {
      repeated.Add(std::span(&hash, 1));
      return {};
    }));
  repeated.Finish();
  std::uint64_t count = 0;
  NumberSet<std::uint64_t> different;
  KDSTREAM_TRY(hashes.ForEach(bucket,
    [&](std::uint64_t hash) -> Status
    {
      if (repeated.MayRepeat(hash))
      {
        different.Add(hash);
      }
      else
      {
        ++count;
      }
      return {};
    }));
  return count + different.CountAndClear();
}

}

Result<std::uint64_t> CountPlacesCollectively(MpiGroup& group, SpillFolder& folder,
  const VertexFiles& vertices, std::uint64_t allVertices,
  const std::function<Vec3(const Vec3&)>& placeOf, std::uint64_t memory)
{
  const std::uint64_t most = memory / 4 / sizeof(std::uint64_t) + 1;
  const std::uint64_t buckets = allVertices / group.Count() * 9 / 8 / most + 1;
  Result<RecordBuckets<std::uint64_t>> hashes = RecordBuckets<std::uint64_t>::Create(
    folder, "places", static_cast<std::size_t>(buckets), 0, memory / 4);
  KDSTREAM_TRY(hashes);
  KDSTREAM_TRY(SendHashes(group, vertices, placeOf, *hashes));
  std::uint64_t all = 0;
  for (std::size_t bucket = 0; bucket < hashes->BucketCount(); ++bucket)
  {
    const Result<std::uint64_t> count = CountDifferent(*hashes, bucket, memory / 4);
    KDSTREAM_TRY(count);
    all += *count;
  }
  KDSTREAM_TRY(group.Sum(std::span(&all, 1)));
  return all;
}

}
