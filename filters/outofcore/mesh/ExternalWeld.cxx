// SPDX-License-Identifier: BSD-3-Clause
// Welding out of core: see ExternalWeld.h.
//   1. If not all vertices fit in memory: find those whose place has a hash that may occur more
//      than once. Step 2 uses only these. If they do not fit either, put them into buckets by a
//      hash of their bytes, so that equal vertices are in one bucket.
//   2. In each bucket, find each vertex that equals a lower one, and the lowest that it equals.
//   3. Make the map: first number the vertices that stay, by id; then give each removed vertex the
//      number of the one that it equals.
//   4. Move the vertices that stay together.
#include "filters/outofcore/mesh/ExternalWeld.h"

#include "filters/core/SeededHash.h"
#include "filters/outofcore/files/BucketFile.h"
#include "filters/outofcore/files/KeyTable.h"
#include "filters/outofcore/files/MemoryPlan.h"
#include "filters/outofcore/files/RepeatedHashes.h"
#include "filters/outofcore/files/ScatteredRead.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <numeric>
#include <optional>
#include <vector>

namespace kdstream
{
namespace
{

constexpr std::string_view weldStep = "weld";

// A vertex that is removed, and the lowest vertex that it equals.
struct Twin
{
  VertexId id = 0, lowest = 0;
};

class ExternalWelder
{
public:
  ExternalWelder(
    SpillFolder& folder, VertexFiles input, std::uint64_t memory, const Execution& execution)
    : Folder(folder)
    , Input(std::move(input))
    , KeyBytes(sizeof(Vec3) + this->Input.tupleBytes)
    , Memory(memory)
    , Exec(execution)
    , Sections(MapSections::Over(this->Input.count, memory / 2, sizeof(VertexId)))
    , Seed(RandomSeed())
  {
  }

  Result<ExternalWeld> Weld()
  {
    Result<RecordBuckets<Twin>> twins = this->MakeBuckets<Twin>("equal vertices");
    KDSTREAM_TRY(twins);
    KDSTREAM_TRY(this->FindTwins(*twins));
    KDSTREAM_TRY(twins->Finish());
    ExternalWeld result;
    if (this->Twins == 0)
    {
      result.vertices = std::move(this->Input);
      return result;
    }
    Result<VertexMap> map = this->MakeMap(*twins);
    KDSTREAM_TRY(map);
    result.welded = this->Twins;
    KDSTREAM_TRY(this->Compact(*map, result.vertices));
    result.map = std::move(*map);
    return result;
  }

private:
  template <class Record>
  Result<RecordBuckets<Record>> MakeBuckets(std::string_view purpose)
  {
    return RecordBuckets<Record>::Create(this->Folder, purpose,
      std::max<std::size_t>(1, this->Sections.Number()), 0, this->Memory / 8);
  }

  Status Report(double begin, double end, std::uint64_t done) const
  {
    return this->Exec.Report(
      weldStep, begin + (end - begin) * double(done) / double(std::max(1U, this->Input.count)));
  }

  // Calls visit(id, key) for each vertex.
  template <class Visit>
  Status ForEachVertex(const Visit& visit) const
  {
    const std::size_t most = RecordsOfBlock<Vec3>(
      std::max<std::size_t>(1, spillBlockBytes / this->KeyBytes) * sizeof(Vec3));
    std::vector<Vec3> points;
    std::vector<std::byte> tuples, key(this->KeyBytes);
    for (VertexId first = 0; first < this->Input.count; first += VertexId(points.size()))
    {
      points.resize(std::min<std::size_t>(most, this->Input.count - first));
      tuples.resize(points.size() * this->Input.tupleBytes);
      KDSTREAM_TRY(ReadRecords<Vec3>(this->Input.points, first, std::span<Vec3>(points)));
      if (!tuples.empty())
      {
        KDSTREAM_TRY(this->Input.tuples.Read(
          std::uint64_t{ first } * this->Input.tupleBytes, std::span<std::byte>(tuples)));
      }
      for (std::size_t i = 0; i < points.size(); ++i)
      {
        std::memcpy(key.data(), &points[i], sizeof(Vec3));
        if (this->Input.tupleBytes > 0)
        {
          std::memcpy(key.data() + sizeof(Vec3), tuples.data() + i * this->Input.tupleBytes,
            this->Input.tupleBytes);
        }
        KDSTREAM_TRY(visit(first + static_cast<VertexId>(i), std::span<const std::byte>(key)));
      }
    }
    return {};
  }

  std::uint64_t HashOf(std::span<const std::byte> key) const
  {
    return HashOfBytes(key, this->Seed);
  }

  // How many buckets this number of keys needs, so that each bucket fits in memory.
  std::size_t BucketsFor(std::uint64_t keys) const
  {
    return static_cast<std::size_t>(
      1 + keys * KeyTable::BytesOf(this->KeyBytes) / std::max<std::uint64_t>(1, this->Memory / 2));
  }

  // Steps 1 and 2.
  Status FindTwins(RecordBuckets<Twin>& twins)
  {
    std::size_t count = this->BucketsFor(this->Input.count);
    if (count > 1)
    {
      const Result<std::uint64_t> most = this->FindRepeated();
      KDSTREAM_TRY(most);
      count = this->BucketsFor(*most);
    }
    KeyTable table(this->KeyBytes);
    const auto look = [&](VertexId id, std::span<const std::byte> key) -> Status
    {
      const VertexId first = table.VertexOf(key, this->HashOf(key), id);
      if (first == id)
      {
        return {};
      }
      ++this->Twins;
      return twins.Add(this->Sections.Of(id), { id, first });
    };
    if (count == 1)
    {
      return this->Repeated ? this->ForEachRepeated(look) : this->ForEachVertex(look);
    }
    Result<BucketFile> buckets = this->BucketVertices(count);
    this->Repeated.reset();
    KDSTREAM_TRY(buckets);
    const std::size_t stride = this->KeyBytes + sizeof(VertexId);
    std::uint64_t done = 0;
    for (std::size_t b = 0; b < count; ++b)
    {
      table.Clear();
      KDSTREAM_TRY(buckets->ForEachBlock(b,
        [&](std::span<const std::byte> records) -> Status
        {
          for (std::size_t at = 0; at < records.size(); at += stride)
          {
            VertexId id = 0;
            std::memcpy(&id, records.data() + at + this->KeyBytes, sizeof(id));
            KDSTREAM_TRY(look(id, records.subspan(at, this->KeyBytes)));
          }
          return {};
        }));
      done += buckets->Size(b);
      KDSTREAM_TRY(this->Report(0.4, 0.8, done));
    }
    return {};
  }

  // Step 1: finds the vertices that may have an equal one. Returns an upper bound of their number.
  Result<std::uint64_t> FindRepeated()
  {
    RepeatedHashes& repeated =
      this->Repeated.emplace(std::uint64_t{ this->Input.count }, this->Memory / 4 * 3);
    const BatchShape shape = ShapeOfPass(this->Memory / 8, sizeof(Vec3));
    std::vector<std::vector<std::uint64_t>> hashes(shape.slots);
    std::vector<std::uint64_t> repeats(shape.slots, 0);
    BatchPass<Vec3> batches(shape, this->Exec);
    KDSTREAM_TRY(batches.Over(
      this->Input.points, 0, this->Input.count,
      [&](std::size_t slot, std::span<Vec3> points) -> Status
      {
        hashes[slot].resize(points.size());
        std::transform(points.begin(), points.end(), hashes[slot].begin(),
          [&](const Vec3& p) { return HashOfPlace(p, this->Seed); });
        repeats[slot] += repeated.Add(hashes[slot]);
        return {};
      },
      [&](std::size_t, std::uint64_t last) { return this->Report(0, 0.2, last); }));
    repeated.Finish();
    // Each repeat follows another hash in its class. Only the first hash of a class is not counted
    // as a repeat.
    return std::min<std::uint64_t>(
      this->Input.count, 2 * std::accumulate(repeats.begin(), repeats.end(), std::uint64_t{ 0 }));
  }

  // Calls visit(id, key) for each vertex that may have an equal one, ascending.
  template <class Visit>
  Status ForEachRepeated(const Visit& visit) const
  {
    const BatchShape shape = ShapeOfPass(this->Memory / 8, sizeof(Vec3));
    struct Found
    {
      std::vector<VertexId> ids;
      std::vector<Vec3> points;
      std::vector<std::byte> tuples;
    };
    std::vector<Found> found(shape.slots);
    BatchPass<Vec3> batches(shape, this->Exec);
    std::vector<std::byte> key(this->KeyBytes);
    return batches.Over(
      this->Input.points, 0, this->Input.count,
      [&](std::size_t slot, std::span<Vec3> points, std::uint64_t first) -> Status
      {
        Found& those = found[slot];
        those.ids.clear();
        those.points.clear();
        for (std::size_t i = 0; i < points.size(); ++i)
        {
          if (this->Repeated->MayRepeat(HashOfPlace(points[i], this->Seed)))
          {
            those.ids.push_back(static_cast<VertexId>(first + i));
            those.points.push_back(points[i]);
          }
        }
        those.tuples.resize(those.ids.size() * this->Input.tupleBytes);
        return those.tuples.empty() ? Status{}
                                    : ReadElementsAt(this->Input.tuples, this->Input.tupleBytes,
                                        those.ids, those.tuples);
      },
      [&](std::size_t used, std::uint64_t last) -> Status
      {
        KDSTREAM_TRY(this->Report(0.2, 0.4, last));
        for (std::size_t slot = 0; slot < used; ++slot)
        {
          const Found& those = found[slot];
          for (std::size_t i = 0; i < those.ids.size(); ++i)
          {
            std::memcpy(key.data(), &those.points[i], sizeof(Vec3));
            std::copy_n(those.tuples.begin() + std::ptrdiff_t(i * this->Input.tupleBytes),
              this->Input.tupleBytes, key.begin() + sizeof(Vec3));
            KDSTREAM_TRY(visit(those.ids[i], std::span<const std::byte>(key)));
          }
        }
        return {};
      });
  }

  // Buckets are chosen by the upper half of the hash, slots of a table by the lower half.
  Result<BucketFile> BucketVertices(std::size_t count)
  {
    const std::size_t stride = this->KeyBytes + sizeof(VertexId);
    Result<BucketFile> buckets = BucketFile::Create(
      this->Folder, "vertices by hash", stride, count, this->Input.count, this->Memory / 4);
    KDSTREAM_TRY(buckets);
    std::vector<std::byte> record(stride);
    KDSTREAM_TRY(this->ForEachRepeated(
      [&](VertexId id, std::span<const std::byte> key) -> Status
      {
        std::copy(key.begin(), key.end(), record.begin());
        std::memcpy(record.data() + this->KeyBytes, &id, sizeof(id));
        return buckets->Add(
          static_cast<std::size_t>(((this->HashOf(key) >> 32) * count) >> 32), record);
      }));
    KDSTREAM_TRY(buckets->Finish());
    return buckets;
  }

  // Step 3: the map.
  Result<VertexMap> MakeMap(const RecordBuckets<Twin>& twins)
  {
    VertexMap map;
    map.count = this->Input.count;
    Result<SpillFile> file = this->Folder.CreateFile(
      "numbers after welding", std::uint64_t{ map.count } * sizeof(VertexId));
    Result<RecordBuckets<Twin>> byLowest = this->MakeBuckets<Twin>("equal vertices by the lowest");
    Result<RecordBuckets<Twin>> numbered = this->MakeBuckets<Twin>("numbers of equal vertices");
    if (!file || !byLowest || !numbered)
    {
      return !file ? file.GetError() : !byLowest ? byLowest.GetError() : numbered.GetError();
    }
    map.file = std::move(*file);
    KDSTREAM_TRY(this->NumberThoseThatStay(twins, map, *byLowest));
    KDSTREAM_TRY(this->ForEachSection(map, *byLowest,
      [&](const Twin& twin, std::span<VertexId> entries, VertexId first) {
        return numbered->Add(this->Sections.Of(twin.id), { twin.id, entries[twin.lowest - first] });
      }));
    KDSTREAM_TRY(this->ForEachSection(map, *numbered,
      [&](const Twin& twin, std::span<VertexId> entries, VertexId first) -> Status
      {
        entries[twin.id - first] = twin.lowest;
        return {};
      }));
    return map;
  }

  // Removed vertices get noVertex until the numbers of the lowest equal vertices are known.
  Status NumberThoseThatStay(
    const RecordBuckets<Twin>& twins, VertexMap& map, RecordBuckets<Twin>& byLowest)
  {
    std::vector<VertexId> entries;
    for (std::size_t section = 0; section < this->Sections.Number(); ++section)
    {
      const VertexId first = this->Sections.Begin(section);
      entries.assign(this->Sections.End(section) - first, 0);
      KDSTREAM_TRY(twins.ForEach(section,
        [&](const Twin& twin)
        {
          entries[twin.id - first] = noVertex;
          return byLowest.Add(this->Sections.Of(twin.lowest), twin);
        }));
      for (VertexId& entry : entries)
      {
        entry = entry == noVertex ? noVertex : this->Kept++;
      }
      KDSTREAM_TRY(WriteRecords<VertexId>(map.file, first, std::span<const VertexId>(entries)));
    }
    return byLowest.Finish();
  }

  // Calls visit(twin, entries of the section, first number of the section) for each record, while
  // the record's section of the map is in memory. Changes to the entries are written back.
  template <class Visit>
  Status ForEachSection(VertexMap& map, RecordBuckets<Twin>& records, const Visit& visit)
  {
    KDSTREAM_TRY(records.Finish());
    std::vector<VertexId> entries;
    for (std::size_t section = 0; section < this->Sections.Number(); ++section)
    {
      if (records.Size(section) == 0)
      {
        continue;
      }
      const VertexId first = this->Sections.Begin(section);
      entries.resize(this->Sections.End(section) - first);
      KDSTREAM_TRY(ReadRecords<VertexId>(map.file, first, std::span<VertexId>(entries)));
      KDSTREAM_TRY(records.ForEach(section,
        [&](const Twin& twin) { return visit(twin, std::span<VertexId>(entries), first); }));
      KDSTREAM_TRY(WriteRecords<VertexId>(map.file, first, std::span<const VertexId>(entries)));
    }
    return {};
  }

  // Step 4. A vertex stays if its number is the next one; a removed vertex has a lower number.
  Status Compact(const VertexMap& map, VertexFiles& output)
  {
    output.count = this->Kept;
    output.tupleBytes = this->Input.tupleBytes;
    Result<SpillFile> points =
      this->Folder.CreateFile("welded vertices", std::uint64_t{ this->Kept } * sizeof(Vec3));
    Result<SpillFile> tuples = this->Folder.CreateFile(
      "attributes of welded vertices", std::uint64_t{ this->Kept } * this->Input.tupleBytes);
    if (!points || !tuples)
    {
      return !points ? points.GetError() : tuples.GetError();
    }
    output.points = std::move(*points);
    RecordWriter<Vec3> writer(output.points);
    RecordReader<VertexId> numbers(map.file, 0, map.count);
    std::span<const VertexId> block;
    std::vector<std::byte> waiting;
    std::uint64_t written = 0;
    VertexId next = 0;
    std::size_t at = 0;
    const auto flush = [&]() -> Status
    {
      KDSTREAM_TRY(waiting.empty() ? Status{} : tuples->Write(written, waiting));
      written += waiting.size();
      waiting.clear();
      return {};
    };
    KDSTREAM_TRY(this->ForEachVertex(
      [&](VertexId id, std::span<const std::byte> key) -> Status
      {
        if (at == block.size())
        {
          const Result<std::span<const VertexId>> read = numbers.Next();
          KDSTREAM_TRY(read);
          block = *read;
          at = 0;
        }
        if (block[at++] != next)
        {
          return {};
        }
        ++next;
        Vec3 point;
        std::memcpy(&point, key.data(), sizeof(point));
        writer.Append(point);
        const auto tuple = key.subspan(sizeof(Vec3));
        waiting.insert(waiting.end(), tuple.begin(), tuple.end());
        KDSTREAM_TRY(waiting.size() < spillBlockBytes ? Status{} : flush());
        return id % (1 << 20) == 0 ? this->Report(0.8, 1, id) : Status{};
      }));
    KDSTREAM_TRY(flush());
    KDSTREAM_TRY(writer.Finish());
    if (this->Input.tupleBytes > 0)
    {
      output.tuples = std::move(*tuples);
    }
    return {};
  }

  SpillFolder& Folder;
  VertexFiles Input;
  std::size_t KeyBytes;
  std::uint64_t Memory;
  const Execution& Exec;
  MapSections Sections;
  std::uint64_t Seed;
  std::optional<RepeatedHashes> Repeated; // of the hashes of places
  std::uint64_t Twins = 0;
  std::uint32_t Kept = 0;
};

}

Result<ExternalWeld> WeldExternally(
  SpillFolder& folder, VertexFiles input, std::uint64_t memory, const Execution& execution)
{
  return ExternalWelder(folder, std::move(input), memory, execution).Weld();
}

}
