// SPDX-License-Identifier: BSD-3-Clause
// The search for equal vertices: see EqualVertices.h.
//   1. Send every vertex to a rank, which puts it into a bucket; both are chosen by the hash of its
//      bytes.
//   2. In each bucket find the lowest vertex of each key, then all others with the same key.
#include "filters/Parallel/EqualVertices.h"

#include "filters/core/SeededHash.h"
#include "filters/outofcore/files/BucketFile.h"
#include "filters/outofcore/files/KeyTable.h"
#include "filters/outofcore/files/RecordFile.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <optional>
#include <span>
#include <vector>

namespace kdstream
{
namespace
{

// Tables are faster if they fit in the caches; buckets are read faster if there are few.
constexpr std::uint64_t entriesInCache = std::uint64_t{ 1 } << 15;
constexpr std::uint64_t mostBucketsForCache = 256;

// An entry represents a vertex that is sent: its place, its tuples, and its number. Place and
// tuples are its key.
class EqualVertexSearch
{
public:
  EqualVertexSearch(MpiGroup& group, SpillFolder& folder, const VertexFiles& share, VertexId first,
    std::uint64_t allVertices, std::uint64_t memory, const Execution& execution)
    : Group(group)
    , Folder(folder)
    , Share(share)
    , First(first)
    , AllVertices(allVertices)
    , Memory(memory)
    , Exec(execution)
    , KeyBytes(sizeof(Vec3) + share.tupleBytes)
    , EntryBytes(this->KeyBytes + sizeof(VertexId))
    , OfRound(ElementsOfRound(this->EntryBytes))
  {
  }

  Result<WeldedVertexFile> Find()
  {
    KDSTREAM_TRY(this->CreateBuckets());
    KDSTREAM_TRY(this->SendEntries());
    return this->FindInBuckets();
  }

private:
  Status CreateBuckets()
  {
    const std::uint64_t most = this->Memory / 2 / KeyTable::BytesOf(this->KeyBytes) + 1;
    const std::uint64_t expected = this->AllVertices / this->Group.Count() * 9 / 8;
    const std::uint64_t buckets =
      std::max(expected / most + 1, std::min(expected / entriesInCache + 1, mostBucketsForCache));
    Result<BucketFile> file = BucketFile::Create(this->Folder, "vertices by their places",
      this->EntryBytes, static_cast<std::size_t>(buckets), 0, this->Memory / 4);
    KDSTREAM_TRY(file);
    this->Entries.emplace(std::move(*file));
    return {};
  }

  Status SendEntries()
  {
    const std::size_t ranks = this->Group.Count(), bytes = this->EntryBytes;
    const auto hashOf = [&](const std::byte* entry)
    { return HashOfBytes(std::span(entry, this->KeyBytes), agreedSeed); };
    const auto make = [&](std::uint64_t round, RankLists<std::byte>& out) -> Status
    {
      std::vector<std::byte> entries;
      KDSTREAM_TRY(this->ReadEntries(round * this->OfRound, entries));
      for (auto entry = entries.begin(); entry != entries.end(); entry += std::ptrdiff_t(bytes))
      {
        std::vector<std::byte>& list = out[hashOf(&*entry) % ranks];
        list.insert(list.end(), entry, entry + std::ptrdiff_t(bytes));
      }
      return this->Exec.Report("tree", 0);
    };
    const auto take = [&](std::size_t, std::span<const std::byte> entries) -> Status
    {
      for (std::size_t at = 0; at < entries.size(); at += bytes)
      {
        const std::uint64_t bucket =
          hashOf(entries.data() + at) / ranks % this->Entries->BucketCount();
        KDSTREAM_TRY(
          this->Entries->Add(static_cast<std::size_t>(bucket), entries.subspan(at, bytes)));
      }
      return {};
    };
    KDSTREAM_TRY(this->Group.ExchangeInRounds<std::byte>(
      RoundsOf(this->Share.count, this->OfRound), make, take));
    return this->Entries->Finish();
  }

  // Reads the vertices of a round, beginning with `first`.
  Status ReadEntries(std::uint64_t first, std::vector<std::byte>& entries) const
  {
    const std::size_t count = std::min<std::size_t>(this->OfRound, this->Share.count - first);
    const std::size_t tupleBytes = this->Share.tupleBytes;
    std::vector<Vec3> points(count);
    KDSTREAM_TRY(ReadRecords<Vec3>(this->Share.points, first, std::span<Vec3>(points)));
    std::vector<std::byte> tuples(count * tupleBytes);
    if (tupleBytes > 0)
    {
      KDSTREAM_TRY(this->Share.tuples.Read(first * tupleBytes, tuples));
    }
    entries.resize(count * this->EntryBytes);
    std::byte* to = entries.data();
    for (std::size_t i = 0; i < count; ++i)
    {
      const auto number = static_cast<VertexId>(this->First + first + i);
      std::memcpy(to, &points[i], sizeof(Vec3));
      if (tupleBytes > 0)
      {
        std::memcpy(to + sizeof(Vec3), tuples.data() + i * tupleBytes, tupleBytes);
      }
      std::memcpy(to + this->KeyBytes, &number, sizeof(number));
      to += this->EntryBytes;
    }
    return {};
  }

  // The hash for this rank's tables.
  std::uint64_t HashOf(std::span<const std::byte> key) const
  {
    return HashOfBytes(key, this->Seed);
  }

  // Calls visit(key, number) for each vertex of a bucket.
  template <class Visit>
  Status ForEachEntry(std::size_t bucket, const Visit& visit) const
  {
    return this->Entries->ForEachBlock(bucket,
      [&](std::span<const std::byte> entries) -> Status
      {
        for (std::size_t at = 0; at < entries.size(); at += this->EntryBytes)
        {
          VertexId number = 0;
          std::memcpy(&number, entries.data() + at + this->KeyBytes, sizeof(number));
          visit(entries.subspan(at, this->KeyBytes), number);
        }
        return {};
      });
  }

  Result<WeldedVertexFile> FindInBuckets()
  {
    Result<SpillFile> file = this->Folder.CreateFile("welded vertices", 0);
    KDSTREAM_TRY(file);
    RecordWriter<WeldedVertex> writer(*file);
    KeyTable lowest(this->KeyBytes); // with the lowest vertex of each key
    for (std::size_t bucket = 0; bucket < this->Entries->BucketCount(); ++bucket)
    {
      lowest.Clear();
      bool anyRepeats = false;
      KDSTREAM_TRY(this->ForEachEntry(bucket,
        [&](std::span<const std::byte> key, VertexId number)
        {
          VertexId& least = lowest.VertexOf(key, this->HashOf(key), number);
          anyRepeats = anyRepeats || least != number;
          least = std::min(least, number);
        }));
      if (anyRepeats)
      {
        KDSTREAM_TRY(this->ForEachEntry(bucket,
          [&](std::span<const std::byte> key, VertexId number)
          {
            if (const VertexId least = lowest.VertexOf(key, this->HashOf(key), number);
                least != number)
            {
              writer.Append({ number, least });
            }
          }));
      }
      KDSTREAM_TRY(this->Exec.Report("tree", 0));
    }
    KDSTREAM_TRY(writer.Finish());
    return WeldedVertexFile{ std::move(*file), writer.Position() };
  }

  MpiGroup& Group;
  SpillFolder& Folder;
  const VertexFiles& Share;
  const VertexId First;
  const std::uint64_t AllVertices;
  const std::uint64_t Memory;
  const Execution& Exec;
  const std::uint64_t Seed = RandomSeed();
  const std::size_t KeyBytes, EntryBytes;
  const std::size_t OfRound;
  std::optional<BucketFile> Entries;
};

}

Result<WeldedVertexFile> FindEqualVertices(MpiGroup& group, SpillFolder& folder,
  const VertexFiles& share, VertexId first, std::uint64_t allVertices, std::uint64_t memory,
  const Execution& execution)
{
  return EqualVertexSearch(group, folder, share, first, allVertices, memory, execution).Find();
}

}
