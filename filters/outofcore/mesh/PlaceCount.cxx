// SPDX-License-Identifier: BSD-3-Clause
// Counting of places: see PlaceCount.h.
//   1. Find the hashes that may occur more than once. All others count as one place each. If these
//      hashes fit in memory, sort them and count the distinct ones.
//   2. If not, put the hash of each place into a bucket, by its upper bits.
//   3. Count the distinct hashes of each bucket.
#include "filters/outofcore/mesh/PlaceCount.h"

#include "filters/core/SeededHash.h"
#include "filters/core/VectorMath.h"
#include "filters/outofcore/files/BatchPass.h"
#include "filters/outofcore/files/BucketFile.h"
#include "filters/outofcore/files/MemoryPlan.h"
#include "filters/outofcore/files/NumberSet.h"
#include "filters/outofcore/files/RepeatedHashes.h"

#include <algorithm>
#include <numeric>
#include <optional>
#include <vector>

namespace kdstream
{
namespace
{

constexpr std::string_view placeStep = "tree";
constexpr std::size_t hashesPerTask = 1 << 12;

using PlaceOf = std::function<Vec3(const Vec3&)>;

std::uint64_t HashOf(const Vec3& place)
{
  return HashOfPlace(WithPositiveZeros(place), agreedSeed);
}

// Step 1. It counts all places if the hashes that may occur more than once fit in memory.
template <class Scalar>
class PlaceCounter
{
public:
  PlaceCounter(const SpillFile& records, std::uint32_t count, const PlaceOf& placeOf,
    std::uint64_t memory, const Execution& execution)
    : Records(records)
    , Count(count)
    , Place(placeOf)
    , Memory(memory)
    , Exec(execution)
    , Shape(ShapeOfPass(memory / 8, sizeof(Record)))
    , Hashes(this->Shape.slots)
    , Repeated(count, memory / 2)
  {
  }

  // Returns nothing if the hashes do not fit.
  Result<std::optional<std::uint64_t>> CountPlaces()
  {
    std::vector<std::uint64_t> repeats(this->Shape.slots, 0);
    KDSTREAM_TRY(this->ForEachBlock(
      0, [&](std::size_t slot) { repeats[slot] += this->Repeated.Add(this->Hashes[slot]); },
      [](std::size_t) {}));
    this->Repeated.Finish();
    const auto most = 2 * std::accumulate(repeats.begin(), repeats.end(), std::uint64_t{ 0 });
    if (most * sizeof(std::uint64_t) > this->Memory / 2)
    {
      return std::optional<std::uint64_t>{};
    }
    std::vector<std::uint64_t> shared;
    KDSTREAM_TRY(this->ForEachBlock(
      0.5,
      [&](std::size_t slot) {
        std::erase_if(
          this->Hashes[slot], [&](auto hash) { return !this->Repeated.MayRepeat(hash); });
      },
      [&](std::size_t slot)
      { shared.insert(shared.end(), this->Hashes[slot].begin(), this->Hashes[slot].end()); }));
    const std::uint64_t alone = this->Count - shared.size();
    std::sort(shared.begin(), shared.end());
    const auto end = std::unique(shared.begin(), shared.end());
    return std::optional(alone + static_cast<std::uint64_t>(end - shared.begin()));
  }

private:
  using Record = PointRecord<Scalar>;

  // Calls work(slot) on any thread once the hashes of a block are in that slot; then take(slot), in
  // the order of the blocks.
  template <class Work, class Take>
  Status ForEachBlock(double progress, const Work& work, const Take& take)
  {
    BatchPass<Record> batches(this->Shape, this->Exec);
    return batches.Over(
      this->Records, 0, this->Count,
      [&](std::size_t slot, std::span<Record> records) -> Status
      {
        std::vector<std::uint64_t>& hashes = this->Hashes[slot];
        hashes.clear();
        for (const Record& record : records)
        {
          const Vec3 point{ record.p[0], record.p[1], record.p[2] };
          hashes.push_back(HashOf(this->Place ? this->Place(point) : point));
        }
        work(slot);
        return {};
      },
      [&](std::size_t used, std::uint64_t last) -> Status
      {
        for (std::size_t slot = 0; slot < used; ++slot)
        {
          take(slot);
        }
        return this->Exec.Report(placeStep, progress + 0.5 * double(last) / double(this->Count));
      });
  }

  const SpillFile& Records;
  std::uint32_t Count;
  const PlaceOf& Place;
  std::uint64_t Memory;
  const Execution& Exec;
  BatchShape Shape;
  std::vector<std::vector<std::uint64_t>> Hashes; // of each slot's block
  RepeatedHashes Repeated;
};

// Calls visit(hash) for each record.
template <class Scalar, class Visit>
Status ForEachHash(const SpillFile& records, std::uint32_t count, const PlaceOf& placeOf,
  const Execution& execution, const Visit& visit)
{
  RecordReader<PointRecord<Scalar>> reader(records, 0, count);
  std::vector<std::uint64_t> hashes;
  for (std::uint64_t done = 0; done < count; done += hashes.size())
  {
    const auto block = reader.Next();
    KDSTREAM_TRY(block);
    hashes.resize(block->size());
    execution.parallelFor(hashes.size(), hashesPerTask,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t i = begin; i < end; ++i)
        {
          const auto& p = (*block)[i].p;
          const Vec3 point{ p[0], p[1], p[2] };
          hashes[i] = HashOf(placeOf ? placeOf(point) : point);
        }
      });
    for (const std::uint64_t hash : hashes)
    {
      KDSTREAM_TRY(visit(hash));
    }
    KDSTREAM_TRY(execution.Report(placeStep, double(done + hashes.size()) / double(count)));
  }
  return {};
}

}

template <class Scalar>
Result<std::uint64_t> CountPlacesExternally(SpillFolder& folder, const SpillFile& records,
  std::uint32_t count, const PlaceOf& placeOf, std::uint64_t memory, const Execution& execution)
{
  const Result<std::optional<std::uint64_t>> counted =
    PlaceCounter<Scalar>(records, count, placeOf, memory, execution).CountPlaces();
  KDSTREAM_TRY(counted);
  if (*counted)
  {
    return **counted;
  }
  // Half of the memory is for distinct hashes. The average bucket holds about half of what fits.
  const std::uint64_t most = std::max<std::uint64_t>(64, memory / 2 / sizeof(std::uint64_t));
  const std::uint64_t buckets = count <= most ? 1 : 1 + 2 * std::uint64_t{ count } / most;
  NumberSet<std::uint64_t> different(static_cast<std::size_t>(most));
  different.Reserve(count);
  if (buckets == 1)
  {
    KDSTREAM_TRY(ForEachHash<Scalar>(records, count, placeOf, execution,
      [&](std::uint64_t hash) -> Status
      {
        different.Add(hash);
        return {};
      }));
    return different.CountAndClear();
  }
  Result<RecordBuckets<std::uint64_t>> sorted = RecordBuckets<std::uint64_t>::Create(
    folder, "hashes of places", static_cast<std::size_t>(buckets), count, memory / 4);
  KDSTREAM_TRY(sorted);
  KDSTREAM_TRY(ForEachHash<Scalar>(records, count, placeOf, execution,
    [&](std::uint64_t hash)
    { return sorted->Add(static_cast<std::size_t>(((hash >> 32) * buckets) >> 32), hash); }));
  KDSTREAM_TRY(sorted->Finish());
  std::uint64_t places = 0;
  for (std::size_t bucket = 0; bucket < buckets; ++bucket)
  {
    KDSTREAM_TRY(sorted->ForEach(bucket,
      [&](std::uint64_t hash) -> Status
      {
        different.Add(hash);
        return {};
      }));
    places += different.CountAndClear();
  }
  return places;
}

template Result<std::uint64_t> CountPlacesExternally<float>(
  SpillFolder&, const SpillFile&, std::uint32_t, const PlaceOf&, std::uint64_t, const Execution&);
template Result<std::uint64_t> CountPlacesExternally<double>(
  SpillFolder&, const SpillFile&, std::uint32_t, const PlaceOf&, std::uint64_t, const Execution&);

}
