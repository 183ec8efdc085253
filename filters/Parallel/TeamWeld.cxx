// Welding on several ranks: see TeamWeld.h.
//   1. Every vertex to a rank, and there into a bucket, by the hash of its bytes.
//   2. Bucket by bucket: pairs of a vertex that goes and the lowest one that equals it.
//   3. The pairs to those who have read the vertices: what stays is written anew and counted.
//   4. The numbers of all: of those that go, asked from who has the lowest one.
#include "filters/Parallel/TeamWeld.h"

#include "filters/Parallel/NumberSet.h"
#include "filters/core/BitCast.h"
#include "filters/core/TakeResult.h"
#include "filters/outofcore/files/BucketFile.h"
#include "filters/outofcore/files/KeyTable.h"
#include "filters/outofcore/files/RecordFile.h"
#include "filters/outofcore/files/RepeatedHashes.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <cstring>
#include <optional>

namespace kdstream
{
namespace
{

// Tables are faster where the caches hold them; buckets are read faster where they are few.
constexpr std::uint64_t entriesInCache = std::uint64_t{ 1 } << 15;
constexpr std::uint64_t mostBucketsForCache = 256;

std::uint64_t Mix(std::uint64_t x)
{
  x ^= x >> 32;
  x *= 0xd6e8feb86659fd93U;
  x ^= x >> 32;
  x *= 0xd6e8feb86659fd93U;
  return x ^ x >> 32;
}

// The first number of each rank, and the end, where rank r has counts[r].
Result<std::vector<VertexId>> BeginsOf(const std::vector<std::uint64_t>& counts)
{
  std::vector<VertexId> begins{ 0 };
  std::uint64_t all = 0;
  for (const std::uint64_t count : counts)
  {
    all += count;
    if (all >= noVertex)
    {
      return Error{ ErrorCode::LimitExceeded, "more than 4294967294 vertices" };
    }
    begins.push_back(static_cast<VertexId>(all));
  }
  return begins;
}

// A vertex that goes, and the lowest one that equals it.
struct Gone
{
  VertexId vertex, lowest;
};

class Welder
{
public:
  Welder(MpiTeam& team, SpillFolder& folder, VertexFiles share, std::uint64_t memory,
    const Execution& execution, TeamVertices& vertices)
    : Team(team)
    , Folder(folder)
    , Share(std::move(share))
    , Memory(memory)
    , Exec(execution)
    , Vertices(vertices)
    , KeyBytes(sizeof(Vec3) + this->Share.tupleBytes)
    , First(vertices.readBegin[team.Rank()])
    , OfRound(ElementsOfRound(this->KeyBytes + sizeof(VertexId)))
  {
  }

  Status Weld()
  {
    Status status = this->SendEntries();
    status = status ? this->FindGone() : status;
    this->Entries.reset();
    std::uint64_t gone = this->GoneCount;
    status = status ? this->Team.Sum(std::span(&gone, 1)) : status;
    if (!status || gone == 0)
    {
      this->Vertices.kept = std::move(this->Share);
      return status;
    }
    status = this->SendGone();
    status = status ? this->KeepRest() : status;
    status = status ? this->NumberGone() : status;
    status = status ? this->MergeNumbers() : status;
    this->Vertices.welded = gone;
    return status;
  }

private:
  Status SendEntries()
  {
    const std::size_t ranks = this->Team.Count(), bytes = this->KeyBytes + sizeof(VertexId);
    const std::uint64_t most = this->Memory / 2 / KeyTable::BytesOf(this->KeyBytes) + 1;
    const std::uint64_t expected = this->Vertices.readBegin.back() / ranks * 9 / 8;
    const std::uint64_t buckets =
      std::max(expected / most + 1, std::min(expected / entriesInCache + 1, mostBucketsForCache));
    Result<BucketFile> file = BucketFile::Create(this->Folder, "vertices by their places", bytes,
      static_cast<std::size_t>(buckets), 0, this->Memory / 4);
    KDSTREAM_TRY(file);
    this->Entries.emplace(std::move(*file));
    const auto hashOf = [&](const std::byte* entry)
    { return Mix(this->HashOf(std::span(entry, this->KeyBytes))); };
    const auto make = [&](std::uint64_t round, RankLists<std::byte>& out)
    {
      std::vector<std::byte> entries;
      const Status status = this->ReadEntries(round * this->OfRound, entries);
      for (auto entry = entries.begin(); entry != entries.end(); entry += std::ptrdiff_t(bytes))
      {
        std::vector<std::byte>& list = out[hashOf(&*entry) % ranks];
        list.insert(list.end(), entry, entry + std::ptrdiff_t(bytes));
      }
      return status ? this->Exec.Report("tree", 0) : status;
    };
    const auto take = [&](std::size_t, std::span<const std::byte> entries)
    {
      Status status;
      for (std::size_t at = 0; status && at < entries.size(); at += bytes)
      {
        const std::uint64_t bucket = hashOf(entries.data() + at) / ranks % buckets;
        status = this->Entries->Add(static_cast<std::size_t>(bucket), entries.subspan(at, bytes));
      }
      return status;
    };
    const Status status = this->Team.ExchangeInRounds<std::byte>(
      RoundsOf(this->Share.count, this->OfRound), make, take);
    return status ? this->Entries->Finish() : status;
  }

  // A round's vertices from `first` on, each with its number behind its bytes.
  Status ReadEntries(std::uint64_t first, std::vector<std::byte>& entries) const
  {
    const std::size_t count = std::min<std::size_t>(this->OfRound, this->Share.count - first);
    const std::size_t tupleBytes = this->Share.tupleBytes;
    std::vector<Vec3> points(count);
    std::vector<std::byte> tuples(count * tupleBytes);
    Status status = ReadRecords<Vec3>(this->Share.points, first, std::span<Vec3>(points));
    if (status && tupleBytes > 0)
    {
      status = this->Share.tuples.Read(first * tupleBytes, tuples);
    }
    entries.resize(count * (this->KeyBytes + sizeof(VertexId)));
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
      to += this->KeyBytes + sizeof(VertexId);
    }
    return status;
  }

  static std::uint64_t HashOf(std::span<const std::byte> key)
  {
    return XXH3_64bits(key.data(), key.size());
  }

  // visit(key, number) for each vertex of a bucket.
  template <class Visit>
  Status ForEachEntry(std::size_t bucket, const Visit& visit) const
  {
    const std::size_t bytes = this->KeyBytes + sizeof(VertexId);
    return this->Entries->ForEachBlock(bucket,
      [&](std::span<const std::byte> entries) -> Status
      {
        for (std::size_t at = 0; at < entries.size(); at += bytes)
        {
          VertexId number = 0;
          std::memcpy(&number, entries.data() + at + this->KeyBytes, sizeof(number));
          visit(entries.subspan(at, this->KeyBytes), number);
        }
        return {};
      });
  }

  Status FindGone()
  {
    Status status = Take(this->Folder.CreateFile("welded vertices", 0), this->GoneFile);
    RecordWriter<Gone> writer(this->GoneFile);
    KeyTable lowest(this->KeyBytes); // with the lowest vertex of each
    for (std::size_t bucket = 0; status && bucket < this->Entries->BucketCount(); ++bucket)
    {
      lowest.Clear();
      bool anyRepeats = false;
      status = this->ForEachEntry(bucket,
        [&](std::span<const std::byte> key, VertexId number)
        {
          VertexId& least = lowest.VertexOf(key, this->HashOf(key), number);
          anyRepeats = anyRepeats || least != number;
          least = std::min(least, number);
        });
      if (status && anyRepeats)
      {
        status = this->ForEachEntry(bucket,
          [&](std::span<const std::byte> key, VertexId number)
          {
            if (const VertexId least = lowest.VertexOf(key, this->HashOf(key), number);
                least != number)
            {
              writer.Append({ number, least });
            }
          });
      }
      status = status ? this->Exec.Report("tree", 0) : status;
    }
    this->GoneCount = writer.Position();
    return status ? writer.Finish() : status;
  }

  Status SendGone()
  {
    this->Sections = MapSections::Over(this->Share.count, this->Memory / 4, sizeof(VertexId));
    Result<RecordBuckets<Gone>> buckets = RecordBuckets<Gone>::Create(this->Folder,
      "welded vertices", std::max<std::size_t>(1, this->Sections.Number()), 0, this->Memory / 4);
    KDSTREAM_TRY(buckets);
    this->GoneOfSection.emplace(std::move(*buckets));
    constexpr std::size_t ofRound = ElementsOfRound(sizeof(Gone));
    const auto make = [&](std::uint64_t round, RankLists<Gone>& out)
    {
      const std::uint64_t from = round * ofRound;
      std::vector<Gone> gone(std::min<std::uint64_t>(ofRound, this->GoneCount - from));
      const Status status = ReadRecords<Gone>(this->GoneFile, from, std::span<Gone>(gone));
      const std::vector<VertexId>& begin = this->Vertices.readBegin;
      for (const Gone& one : gone)
      {
        const auto behind = std::upper_bound(begin.begin(), begin.end() - 1, one.vertex);
        out[static_cast<std::size_t>(behind - begin.begin() - 1)].push_back(one);
      }
      return status;
    };
    const auto take = [&](std::size_t, std::span<const Gone> gone)
    {
      Status status;
      for (std::size_t i = 0; status && i < gone.size(); ++i)
      {
        const VertexId place = gone[i].vertex - this->First;
        status = this->GoneOfSection->Add(this->Sections.Of(place), { place, gone[i].lowest });
      }
      return status;
    };
    const Status status =
      this->Team.ExchangeInRounds<Gone>(RoundsOf(this->GoneCount, ofRound), make, take);
    this->GoneFile.Remove();
    return status ? this->GoneOfSection->Finish() : status;
  }

  // Writes the vertices that stay, and for each that was read its place among them; those that go
  // once more, ascending.
  Status KeepRest()
  {
    VertexFiles& kept = this->Vertices.kept;
    kept.tupleBytes = this->Share.tupleBytes;
    Status status = Take(this->Folder.CreateFile("vertices", 0), kept.points);
    status = status ? Take(this->Folder.CreateFile("welded vertices", 0), this->GoneFile) : status;
    status =
      status ? Take(this->Folder.CreateFile("numbers of vertices", 0), this->Places) : status;
    if (status && kept.tupleBytes > 0)
    {
      status = Take(this->Folder.CreateFile("attributes of vertices", 0), kept.tuples);
    }
    RecordWriter<Gone> goneWriter(this->GoneFile);
    RecordWriter<VertexId> places(this->Places);
    for (std::size_t section = 0; status && section < this->Sections.Number(); ++section)
    {
      const VertexId begin = this->Sections.Begin(section);
      std::vector<VertexId> lowest(this->Sections.End(section) - begin, noVertex);
      status = this->GoneOfSection->ForEach(section,
        [&](const Gone& gone) -> Status
        {
          lowest[gone.vertex - begin] = gone.lowest;
          return {};
        });
      status = status ? this->CopyKept(begin, lowest) : status;
      auto stays = static_cast<VertexId>(places.Position() - goneWriter.Position());
      for (VertexId i = 0; i < lowest.size(); ++i)
      {
        places.Append(stays);
        if (lowest[i] == noVertex)
        {
          ++stays;
        }
        else
        {
          goneWriter.Append({ begin + i, lowest[i] });
        }
      }
    }
    this->GoneOfSection.reset();
    this->GoneCount = goneWriter.Position();
    status = status ? goneWriter.Finish() : status;
    status = status ? places.Finish() : status;
    const Result<std::vector<std::uint64_t>> counts =
      status ? this->Team.Gather(kept.count) : status.GetError();
    return counts ? Take(BeginsOf(*counts), this->Vertices.begin) : Status(counts.GetError());
  }

  // lowest: of the vertices from `begin` on; those with noVertex stay.
  Status CopyKept(VertexId begin, std::span<const VertexId> lowest)
  {
    VertexFiles& kept = this->Vertices.kept;
    const std::size_t bytes = kept.tupleBytes;
    for (std::size_t at = 0; at < lowest.size(); at += this->OfRound)
    {
      const std::size_t count = std::min(this->OfRound, lowest.size() - at);
      std::vector<Vec3> points(count);
      std::vector<std::byte> tuples(count * bytes);
      Status status = ReadRecords<Vec3>(this->Share.points, begin + at, std::span<Vec3>(points));
      if (status && bytes > 0)
      {
        status = this->Share.tuples.Read((begin + at) * bytes, tuples);
      }
      std::size_t stay = 0;
      for (std::size_t i = 0; i < count; ++i)
      {
        if (lowest[at + i] == noVertex)
        {
          points[stay] = points[i];
          std::copy_n(tuples.begin() + std::ptrdiff_t(i * bytes), bytes,
            tuples.begin() + std::ptrdiff_t(stay * bytes));
          ++stay;
        }
      }
      points.resize(stay);
      tuples.resize(stay * bytes);
      if (status)
      {
        status = WriteRecords<Vec3>(kept.points, kept.count, std::span<const Vec3>(points));
      }
      if (status && bytes > 0)
      {
        status = kept.tuples.Write(kept.count * std::uint64_t{ bytes }, tuples);
      }
      kept.count += static_cast<std::uint32_t>(stay);
      KDSTREAM_TRY(status);
    }
    return {};
  }

  // The numbers of the lowest ones, in the order of those that go.
  Status NumberGone()
  {
    this->Share = {};
    Result<NumberTable> table =
      NumberTable::Open(std::move(this->Places), this->Sections.count, this->Memory / 4);
    Status status = table ? Status{} : Status(table.GetError());
    status =
      status ? Take(this->Folder.CreateFile("numbers of vertices", 0), this->GoneNumbers) : status;
    constexpr std::size_t ofRound = ElementsOfRound(sizeof(Gone));
    const Result<std::uint64_t> rounds =
      status ? this->Team.Most(RoundsOf(this->GoneCount, ofRound)) : status.GetError();
    status = rounds ? status : Status(rounds.GetError());
    for (std::uint64_t round = 0; status && round < *rounds; ++round)
    {
      const std::uint64_t from = std::min(round * ofRound, this->GoneCount);
      std::vector<Gone> gone(std::min<std::uint64_t>(ofRound, this->GoneCount - from));
      status = ReadRecords<Gone>(this->GoneFile, from, std::span<Gone>(gone));
      std::vector<VertexId> wanted(gone.size());
      std::transform(
        gone.begin(), gone.end(), wanted.begin(), [](const Gone& one) { return one.lowest; });
      Result<std::vector<VertexId>> places =
        status ? this->Team.LookUp(this->Vertices.readBegin, *table, wanted) : status.GetError();
      status = places ? status : Status(places.GetError());
      for (std::size_t i = 0; status && i < wanted.size(); ++i)
      {
        (*places)[i] += this->Vertices.begin[this->ReaderOf(wanted[i])];
      }
      status =
        status ? WriteRecords<VertexId>(this->GoneNumbers, from, std::span<const VertexId>(*places))
               : status;
    }
    if (status)
    {
      this->Places = table->GiveFile();
    }
    return status;
  }

  std::size_t ReaderOf(VertexId vertex) const
  {
    const std::vector<VertexId>& begin = this->Vertices.readBegin;
    return static_cast<std::size_t>(
      std::upper_bound(begin.begin(), begin.end() - 1, vertex) - begin.begin() - 1);
  }

  Status MergeNumbers()
  {
    Status status =
      Take(this->Folder.CreateFile("numbers of vertices", 0), this->Vertices.numberOf);
    RecordWriter<VertexId> writer(this->Vertices.numberOf);
    RecordReader<VertexId> places(this->Places, 0, this->Sections.count);
    RecordReader<Gone> goneReader(this->GoneFile, 0, this->GoneCount, sizeof(Gone) << 15);
    RecordReader<VertexId> numberReader(
      this->GoneNumbers, 0, this->GoneCount, sizeof(VertexId) << 15);
    std::vector<Gone> gone;
    std::vector<VertexId> numbers;
    std::size_t next = 0;
    const auto readGone = [&]() -> Status
    {
      const Result<std::span<const Gone>> read = goneReader.Next();
      const Result<std::span<const VertexId>> numbersRead = numberReader.Next();
      if (!read || !numbersRead)
      {
        return read ? numbersRead.GetError() : read.GetError();
      }
      gone.assign(read->begin(), read->end());
      numbers.assign(numbersRead->begin(), numbersRead->end());
      next = 0;
      return {};
    };
    status = status ? readGone() : status;
    const VertexId first = this->Vertices.begin[this->Team.Rank()];
    for (VertexId i = 0; status && i < this->Sections.count;)
    {
      const Result<std::span<const VertexId>> read = places.Next();
      status = read ? Status{} : Status(read.GetError());
      for (std::size_t k = 0; status && k < read->size(); ++k, ++i)
      {
        if (next < gone.size() && gone[next].vertex == i)
        {
          writer.Append(numbers[next++]);
          status = next == gone.size() ? readGone() : Status{};
        }
        else
        {
          writer.Append(first + (*read)[k]);
        }
      }
    }
    return status ? writer.Finish() : status;
  }

  MpiTeam& Team;
  SpillFolder& Folder;
  VertexFiles Share;
  const std::uint64_t Memory;
  const Execution& Exec;
  TeamVertices& Vertices;
  const std::size_t KeyBytes; // of a vertex: its place and tuples
  const VertexId First;
  const std::size_t OfRound;
  std::optional<BucketFile> Entries;
  SpillFile GoneFile; // Gone
  std::uint64_t GoneCount = 0;
  MapSections Sections; // of the vertices that were read here
  std::optional<RecordBuckets<Gone>> GoneOfSection;
  SpillFile Places;      // VertexId: of each vertex that was read here, its place among those kept
  SpillFile GoneNumbers; // VertexId: of each that goes the number of the lowest one
};

}

Result<TeamVertices> WeldTogether(MpiTeam& team, SpillFolder& folder, VertexFiles share, bool weld,
  std::uint64_t memory, const Execution& execution)
{
  TeamVertices vertices;
  const Result<std::vector<std::uint64_t>> counts = team.Gather(share.count);
  KDSTREAM_TRY(counts);
  Status status = Take(BeginsOf(*counts), vertices.readBegin);
  if (status && vertices.readBegin.back() == 0)
  {
    status = Error{ ErrorCode::InvalidInput, "the mesh has no vertices" };
  }
  KDSTREAM_TRY(status);
  vertices.begin = vertices.readBegin;
  if (!weld)
  {
    vertices.kept = std::move(share);
    return vertices;
  }
  status = Welder(team, folder, std::move(share), memory, execution, vertices).Weld();
  return status ? Result<TeamVertices>(std::move(vertices)) : status.GetError();
}

Result<std::uint64_t> CountPlacesTogether(MpiTeam& team, SpillFolder& folder,
  const VertexFiles& vertices, std::uint64_t allVertices,
  const std::function<Vec3(const Vec3&)>& placeOf, std::uint64_t memory)
{
  const std::uint64_t most = memory / 4 / sizeof(std::uint64_t) + 1;
  const std::uint64_t buckets = allVertices / team.Count() * 9 / 8 / most + 1;
  Result<RecordBuckets<std::uint64_t>> hashes = RecordBuckets<std::uint64_t>::Create(
    folder, "places", static_cast<std::size_t>(buckets), 0, memory / 4);
  KDSTREAM_TRY(hashes);
  constexpr std::size_t ofRound = ElementsOfRound(sizeof(Vec3));
  const auto make = [&](std::uint64_t round, RankLists<std::uint64_t>& out)
  {
    const std::uint64_t from = round * ofRound;
    std::vector<Vec3> points(std::min<std::uint64_t>(ofRound, vertices.count - from));
    const Status status = ReadRecords<Vec3>(vertices.points, from, std::span<Vec3>(points));
    for (const Vec3& point : points)
    {
      std::uint64_t hash = 0;
      for (const double x : placeOf(point))
      {
        hash = Mix(hash + 0x9e3779b97f4a7c15U + BitCast<std::uint64_t>(x + 0.0)); // no -0.0
      }
      out[hash % team.Count()].push_back(hash);
    }
    return status;
  };
  const auto take = [&](std::size_t, std::span<const std::uint64_t> list)
  {
    Status status;
    for (std::size_t i = 0; status && i < list.size(); ++i)
    {
      status = hashes->Add(static_cast<std::size_t>(list[i] / team.Count() % buckets), list[i]);
    }
    return status;
  };
  Status status =
    team.ExchangeInRounds<std::uint64_t>(RoundsOf(vertices.count, ofRound), make, take);
  status = status ? hashes->Finish() : status;
  std::uint64_t count = 0;
  for (std::size_t bucket = 0; status && bucket < buckets; ++bucket)
  {
    // Most hashes come once: only the others are sorted.
    RepeatedHashes repeated(hashes->Size(bucket), memory / 4);
    status = hashes->ForEach(bucket,
      [&](std::uint64_t hash) -> Status
      {
        repeated.Add(std::span(&hash, 1));
        return {};
      });
    repeated.Finish();
    NumberSet<std::uint64_t> different;
    const auto addIfShared = [&](std::uint64_t hash) -> Status
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
    };
    status = status ? hashes->ForEach(bucket, addIfShared) : status;
    count += different.Take().size();
  }
  status = status ? team.Sum(std::span(&count, 1)) : status;
  return status ? Result<std::uint64_t>(count) : status.GetError();
}

}
