// SPDX-License-Identifier: BSD-3-Clause
// Welding on several ranks: see DistributedWeld.h.
//   1. Find the vertices to remove, and the lowest vertex that each of them equals
//      (EqualVertices.h).
//   2. Report these to the ranks that have read them.
//   3. Write the vertices that stay, and count them.
//   4. Find the new numbers of all vertices. For a removed vertex, ask the rank that has the lowest
//      equal one.
#include "filters/Parallel/DistributedWeld.h"

#include "filters/Parallel/DistributedFiles.h"
#include "filters/Parallel/EqualVertices.h"
#include "filters/core/TakeResult.h"
#include "filters/outofcore/files/BucketFile.h"
#include "filters/outofcore/files/RecordFile.h"

#include <algorithm>
#include <optional>

namespace kdstream
{
namespace
{

// The first number of each rank, and the end; rank r has counts[r] vertices.
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

// Removes vertices from a rank's share, and numbers the rest.
class ShareWelder
{
public:
  ShareWelder(MpiGroup& group, SpillFolder& folder, VertexFiles share, std::uint64_t memory,
    DistributedVertices& vertices)
    : Group(group)
    , Folder(folder)
    , Share(std::move(share))
    , Memory(memory)
    , Vertices(vertices)
    , First(vertices.readBegin[group.Rank()])
    , Sections(MapSections::Over(this->Share.count, memory / 4, sizeof(VertexId)))
  {
  }

  // found: what this rank has found about vertices of any rank.
  Status Weld(WeldedVertexFile found)
  {
    KDSTREAM_TRY(this->SendToReaders(std::move(found)));
    KDSTREAM_TRY(this->KeepRest());
    KDSTREAM_TRY(this->NumberGone());
    return this->MergeNumbers();
  }

private:
  // Sends the results to the ranks that have read the vertices. They put them into buckets.
  Status SendToReaders(WeldedVertexFile found)
  {
    Result<RecordBuckets<WeldedVertex>> buckets = RecordBuckets<WeldedVertex>::Create(this->Folder,
      "welded vertices", std::max<std::size_t>(1, this->Sections.Number()), 0, this->Memory / 4);
    KDSTREAM_TRY(buckets);
    constexpr std::size_t ofRound = ElementsOfRound(sizeof(WeldedVertex));
    const auto make = [&](std::uint64_t round, RankLists<WeldedVertex>& out) -> Status
    {
      const std::uint64_t from = round * ofRound;
      std::vector<WeldedVertex> gone(std::min<std::uint64_t>(ofRound, found.count - from));
      KDSTREAM_TRY(ReadRecords<WeldedVertex>(found.file, from, std::span<WeldedVertex>(gone)));
      for (const WeldedVertex& one : gone)
      {
        out[RankOfEntry(this->Vertices.readBegin, one.vertex)].push_back(one);
      }
      return {};
    };
    const auto take = [&](std::size_t, std::span<const WeldedVertex> gone) -> Status
    {
      for (const WeldedVertex& one : gone)
      {
        const VertexId place = one.vertex - this->First;
        KDSTREAM_TRY(buckets->Add(this->Sections.Of(place), { place, one.lowest }));
      }
      return {};
    };
    KDSTREAM_TRY(
      this->Group.ExchangeInRounds<WeldedVertex>(RoundsOf(found.count, ofRound), make, take));
    KDSTREAM_TRY(buckets->Finish());
    this->GoneOfSection.emplace(std::move(*buckets));
    return {};
  }

  // Writes the vertices that stay; for each vertex read, its place among them; and the removed
  // vertices, ascending.
  Status KeepRest()
  {
    VertexFiles& kept = this->Vertices.kept;
    kept.tupleBytes = this->Share.tupleBytes;
    KDSTREAM_TRY(Take(this->Folder.CreateFile("vertices", 0), kept.points));
    KDSTREAM_TRY(Take(this->Folder.CreateFile("welded vertices", 0), this->Gone.file));
    KDSTREAM_TRY(Take(this->Folder.CreateFile("numbers of vertices", 0), this->Places));
    if (kept.tupleBytes > 0)
    {
      KDSTREAM_TRY(Take(this->Folder.CreateFile("attributes of vertices", 0), kept.tuples));
    }
    RecordWriter<WeldedVertex> goneWriter(this->Gone.file);
    RecordWriter<VertexId> places(this->Places);
    for (std::size_t section = 0; section < this->Sections.Number(); ++section)
    {
      KDSTREAM_TRY(this->KeepRestOf(section, goneWriter, places));
    }
    KDSTREAM_TRY(goneWriter.Finish());
    KDSTREAM_TRY(places.Finish());
    this->GoneOfSection.reset();
    this->Gone.count = goneWriter.Position();
    const Result<std::vector<std::uint64_t>> counts = this->Group.Gather(kept.count);
    KDSTREAM_TRY(counts);
    return Take(BeginsOf(*counts), this->Vertices.begin);
  }

  Status KeepRestOf(
    std::size_t section, RecordWriter<WeldedVertex>& goneWriter, RecordWriter<VertexId>& places)
  {
    const VertexId begin = this->Sections.Begin(section);
    std::vector<VertexId> lowest(this->Sections.End(section) - begin, noVertex);
    KDSTREAM_TRY(this->GoneOfSection->ForEach(section,
      [&](const WeldedVertex& gone) -> Status
      {
        lowest[gone.vertex - begin] = gone.lowest;
        return {};
      }));
    KDSTREAM_TRY(this->CopyKept(begin, lowest));
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
    return {};
  }

  // lowest: for the vertices from `begin` on; those with noVertex stay.
  Status CopyKept(VertexId begin, std::span<const VertexId> lowest)
  {
    VertexFiles& kept = this->Vertices.kept;
    const std::size_t bytes = kept.tupleBytes;
    const std::size_t ofRound = ElementsOfRound(sizeof(Vec3) + bytes + sizeof(VertexId));
    for (std::size_t at = 0; at < lowest.size(); at += ofRound)
    {
      const std::size_t count = std::min(ofRound, lowest.size() - at);
      std::vector<Vec3> points(count);
      KDSTREAM_TRY(ReadRecords<Vec3>(this->Share.points, begin + at, std::span<Vec3>(points)));
      std::vector<std::byte> tuples(count * bytes);
      if (bytes > 0)
      {
        KDSTREAM_TRY(this->Share.tuples.Read((begin + at) * bytes, tuples));
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
      KDSTREAM_TRY(WriteRecords<Vec3>(kept.points, kept.count, std::span<const Vec3>(points)));
      if (bytes > 0)
      {
        KDSTREAM_TRY(kept.tuples.Write(kept.count * std::uint64_t{ bytes }, tuples));
      }
      kept.count += static_cast<std::uint32_t>(stay);
    }
    return {};
  }

  // Finds the new numbers of the lowest equal vertices, in the order of the removed vertices.
  Status NumberGone()
  {
    this->Share = {};
    Result<NumberTable> table =
      NumberTable::Open(std::move(this->Places), this->Sections.count, this->Memory / 4);
    KDSTREAM_TRY(table);
    KDSTREAM_TRY(Take(this->Folder.CreateFile("numbers of vertices", 0), this->GoneNumbers));
    constexpr std::size_t ofRound = ElementsOfRound(sizeof(WeldedVertex));
    const Result<std::uint64_t> rounds = this->Group.Most(RoundsOf(this->Gone.count, ofRound));
    KDSTREAM_TRY(rounds);
    const DistributedVertices& all = this->Vertices;
    for (std::uint64_t round = 0; round < *rounds; ++round)
    {
      const std::uint64_t from = std::min(round * ofRound, this->Gone.count);
      std::vector<WeldedVertex> gone(std::min<std::uint64_t>(ofRound, this->Gone.count - from));
      KDSTREAM_TRY(ReadRecords<WeldedVertex>(this->Gone.file, from, std::span<WeldedVertex>(gone)));
      std::vector<VertexId> wanted(gone.size());
      std::transform(gone.begin(), gone.end(), wanted.begin(),
        [](const WeldedVertex& one) { return one.lowest; });
      Result<std::vector<VertexId>> places =
        LookUpEntries(this->Group, all.readBegin, *table, wanted);
      KDSTREAM_TRY(places);
      for (std::size_t i = 0; i < wanted.size(); ++i)
      {
        (*places)[i] += all.begin[RankOfEntry(all.readBegin, wanted[i])];
      }
      KDSTREAM_TRY(
        WriteRecords<VertexId>(this->GoneNumbers, from, std::span<const VertexId>(*places)));
    }
    this->Places = table->GiveFile();
    return {};
  }

  // Writes the new numbers of all vertices that this rank read: for those that stay, from their
  // place; for removed ones, ascending, the results of NumberGone.
  Status MergeNumbers()
  {
    KDSTREAM_TRY(Take(this->Folder.CreateFile("numbers of vertices", 0), this->Vertices.numberOf));
    RecordWriter<VertexId> writer(this->Vertices.numberOf);
    RecordReader<VertexId> places(this->Places, 0, this->Sections.count);
    RecordReader<WeldedVertex> goneReader(
      this->Gone.file, 0, this->Gone.count, sizeof(WeldedVertex) << 15);
    RecordReader<VertexId> numberReader(
      this->GoneNumbers, 0, this->Gone.count, sizeof(VertexId) << 15);
    std::span<const WeldedVertex> gone;
    std::span<const VertexId> numbers;
    std::size_t next = 0;
    const auto readGone = [&]() -> Status
    {
      next = 0;
      KDSTREAM_TRY(Take(goneReader.Next(), gone));
      return Take(numberReader.Next(), numbers);
    };
    KDSTREAM_TRY(readGone());
    const VertexId first = this->Vertices.begin[this->Group.Rank()];
    for (VertexId i = 0; i < this->Sections.count;)
    {
      const Result<std::span<const VertexId>> read = places.Next();
      KDSTREAM_TRY(read);
      for (const VertexId place : *read)
      {
        if (next < gone.size() && gone[next].vertex == i)
        {
          writer.Append(numbers[next++]);
          if (next == gone.size())
          {
            KDSTREAM_TRY(readGone());
          }
        }
        else
        {
          writer.Append(first + place);
        }
        ++i;
      }
    }
    return writer.Finish();
  }

  MpiGroup& Group;
  SpillFolder& Folder;
  VertexFiles Share;
  const std::uint64_t Memory;
  DistributedVertices& Vertices;
  const VertexId First;
  const MapSections Sections; // of the vertices that this rank read
  std::optional<RecordBuckets<WeldedVertex>> GoneOfSection;
  WeldedVertexFile Gone; // removed ones of the vertices that this rank read; numbers minus First
  // VertexId: for each vertex that this rank read, its place among those that stay.
  SpillFile Places;
  // VertexId: for each removed vertex, the new number of its lowest equal vertex.
  SpillFile GoneNumbers;
};

}

Result<DistributedVertices> WeldCollectively(MpiGroup& group, SpillFolder& folder,
  VertexFiles share, bool weld, std::uint64_t memory, const Execution& execution)
{
  DistributedVertices vertices;
  const Result<std::vector<std::uint64_t>> counts = group.Gather(share.count);
  KDSTREAM_TRY(counts);
  KDSTREAM_TRY(Take(BeginsOf(*counts), vertices.readBegin));
  const VertexId all = vertices.readBegin.back();
  if (all == 0)
  {
    return Error{ ErrorCode::InvalidInput, "the mesh has no vertices" };
  }
  vertices.begin = vertices.readBegin;
  WeldedVertexFile gone;
  if (weld)
  {
    KDSTREAM_TRY(Take(FindEqualVertices(group, folder, share, vertices.readBegin[group.Rank()], all,
                        memory, execution),
      gone));
    vertices.welded = gone.count;
    KDSTREAM_TRY(group.Sum(std::span(&vertices.welded, 1)));
  }
  if (vertices.welded == 0)
  {
    vertices.kept = std::move(share);
    return vertices;
  }
  KDSTREAM_TRY(
    ShareWelder(group, folder, std::move(share), memory, vertices).Weld(std::move(gone)));
  return vertices;
}

}
