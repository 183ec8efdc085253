// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. Mark the vertices that each rank has read and that triangles use: every rank sends the corners
//    of its triangles to the ranks that have read them.
// 2. If vertices were welded, mark those that stay: the rank that has read a marked vertex sends
//    its number to the rank that has it.
// 3. Each rank separates its vertices by the marks.
// 4. Give new numbers to all vertices that were read.
// 5. Send vertices that no triangle uses to rank 0.
#include "filters/Parallel/DistributedUnused.h"

#include "filters/Parallel/DistributedFiles.h"
#include "filters/Parallel/NumberTable.h"
#include "filters/core/TakeResult.h"
#include "filters/outofcore/files/RecordFile.h"
#include "filters/outofcore/mesh/ExternalUnused.h"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace kdstream
{
namespace
{

class UnusedParting
{
public:
  UnusedParting(MpiGroup& group, SpillFolder& folder, const SpilledMesh& share,
    DistributedVertices& vertices, std::uint64_t memory, const Execution& execution)
    : Group(group)
    , Folder(folder)
    , Share(share)
    , Vertices(vertices)
    , Memory(memory)
    , Exec(execution)
  {
  }

  Result<DistributedUnused> Part()
  {
    VertexMarks marks;
    KDSTREAM_TRY(this->MarkRead(marks));
    if (this->Vertices.numberOf.IsOpen())
    {
      KDSTREAM_TRY(this->MarkKept(marks));
    }
    DistributedUnused unused;
    std::uint64_t count = marks.count - marks.marked;
    KDSTREAM_TRY(this->Group.Sum(std::span(&count, 1)));
    unused.count = count;
    if (count == 0)
    {
      return unused;
    }
    PartedVertices parted;
    KDSTREAM_TRY(Take(PartVertices(this->Folder, std::move(this->Vertices.kept), marks), parted));
    this->Vertices.kept = std::move(parted.used);
    KDSTREAM_TRY(this->Renumber(marks.count, std::move(parted.map)));
    KDSTREAM_TRY(this->SendToFirst(std::move(parted.unused), unused.vertices));
    return unused;
  }

private:
  // Lists vertices that this rank uses: list(round, name) calls name(vertex) for those of a round.
  using Name = std::function<void(VertexId)>;
  using ListRound = std::function<Status(std::uint64_t round, const Name& name)>;

  // Marks those of this rank's vertices [begin[rank], begin[rank + 1]) that any rank lists.
  Status Mark(const std::vector<VertexId>& begin, std::uint64_t rounds, const ListRound& list,
    VertexMarks& marks)
  {
    const VertexId own = begin[this->Group.Rank()];
    const MapSections sections =
      SectionsOfMarks(begin[this->Group.Rank() + 1] - own, this->Memory / 4);
    const Result<std::uint64_t> passes = this->Group.Most(sections.Number());
    KDSTREAM_TRY(passes);
    const auto pass = [&](std::size_t section, SectionMarks* mark) -> Status
    {
      // All ranks have the same memory, so their sections have the same length.
      const auto make = [&](std::uint64_t round, RankLists<VertexId>& out) -> Status
      {
        KDSTREAM_TRY(list(round,
          [&](VertexId vertex)
          {
            const std::size_t rank = RankOfEntry(begin, vertex);
            if (sections.Of(vertex - begin[rank]) == section)
            {
              out[rank].push_back(vertex);
            }
          }));
        for (std::vector<VertexId>& named : out)
        {
          std::sort(named.begin(), named.end());
          named.erase(std::unique(named.begin(), named.end()), named.end());
        }
        return this->Exec.Report("tree", 0);
      };
      const auto take = [&](std::size_t, std::span<const VertexId> named) -> Status
      {
        for (const VertexId vertex : named)
        {
          (*mark)(vertex - own);
        }
        return {};
      };
      return this->Group.ExchangeInRounds<VertexId>(rounds, make, take);
    };
    KDSTREAM_TRY(
      Take(MarkVertices(this->Folder, sections,
             [&](std::size_t section, SectionMarks& mark) { return pass(section, &mark); }),
        marks));
    // Other ranks may have more sections; this rank has no vertices in them.
    for (std::uint64_t section = sections.Number(); section < *passes; ++section)
    {
      KDSTREAM_TRY(pass(static_cast<std::size_t>(section), nullptr));
    }
    return {};
  }

  // Step 1: marks used vertices that this rank has read.
  Status MarkRead(VertexMarks& marks)
  {
    constexpr std::size_t ofRound = ElementsOfRound(4 * sizeof(VertexId)); // triangles
    std::vector<NumberedTriangle> triangles;
    return this->Mark(
      this->Vertices.readBegin, RoundsOf(this->Share.triangleCount, ofRound),
      [&](std::uint64_t round, const Name& name) -> Status
      {
        const std::uint64_t from = round * ofRound;
        triangles.resize(std::min<std::uint64_t>(ofRound, this->Share.triangleCount - from));
        KDSTREAM_TRY(ReadRecords<NumberedTriangle>(
          this->Share.triangles, from, std::span<NumberedTriangle>(triangles)));
        for (const NumberedTriangle& t : triangles)
        {
          std::for_each(t.corners.begin(), t.corners.end(), name);
        }
        return {};
      },
      marks);
  }

  // Step 2: marks used vertices that stay on this rank. marks: before, those of the vertices that
  // were read.
  Status MarkKept(VertexMarks& marks)
  {
    const VertexMarks read = std::move(marks);
    marks = {};
    constexpr std::size_t ofRound = ElementsOfRound(2 * sizeof(VertexId));
    std::vector<VertexId> numbers;
    std::vector<std::uint8_t> marked;
    return this->Mark(
      this->Vertices.begin, RoundsOf(read.count, ofRound),
      [&](std::uint64_t round, const Name& name) -> Status
      {
        const std::uint64_t from = round * ofRound;
        numbers.resize(std::min<std::uint64_t>(ofRound, read.count - from));
        marked.resize(numbers.size());
        KDSTREAM_TRY(
          ReadRecords<VertexId>(this->Vertices.numberOf, from, std::span<VertexId>(numbers)));
        KDSTREAM_TRY(ReadRecords<std::uint8_t>(read.file, from, std::span<std::uint8_t>(marked)));
        for (std::size_t i = 0; i < numbers.size(); ++i)
        {
          if (marked[i] != 0)
          {
            name(numbers[i]);
          }
        }
        return {};
      },
      marks);
  }

  // Step 4: gives new numbers. map: for each of the `count` vertices that were kept here, its place
  // among the used ones; empty if all are used. An unused vertex gets an arbitrary number, which is
  // never looked up.
  Status Renumber(std::uint32_t count, std::optional<VertexMap> map)
  {
    const std::vector<VertexId> before = this->Vertices.begin;
    const Result<std::vector<std::uint64_t>> counts = this->Group.Gather(this->Vertices.kept.count);
    KDSTREAM_TRY(counts);
    std::vector<VertexId>& begin = this->Vertices.begin;
    for (std::size_t rank = 0; rank < counts->size(); ++rank)
    {
      begin[rank + 1] = begin[rank] + static_cast<VertexId>((*counts)[rank]);
    }
    SpillFile numbers;
    KDSTREAM_TRY(this->NumbersOfKept(count, map, numbers));
    if (!this->Vertices.numberOf.IsOpen())
    {
      this->Vertices.numberOf = std::move(numbers); // the vertices that this rank read are those
                                                    // that it kept
      return {};
    }
    NumberTable table;
    KDSTREAM_TRY(Take(NumberTable::Open(std::move(numbers), count, this->Memory / 4), table));
    return this->NumbersOfRead(before, table);
  }

  Status NumbersOfKept(std::uint32_t count, const std::optional<VertexMap>& map, SpillFile& numbers)
  {
    KDSTREAM_TRY(Take(this->Folder.CreateFile("numbers of vertices", 0), numbers));
    RecordWriter<VertexId> writer(numbers);
    const std::vector<VertexId>& begin = this->Vertices.begin;
    const VertexId first = begin[this->Group.Rank()], last = begin.back() - 1;
    if (!map)
    {
      for (VertexId v = 0; v < count; ++v)
      {
        writer.Append(first + v);
      }
      return writer.Finish();
    }
    KDSTREAM_TRY(ForEachBlockOf<VertexId>(map->file, 0, count,
      [&](std::span<const VertexId> places)
      {
        for (const VertexId place : places)
        {
          writer.Append(std::min(first + place, last));
        }
      }));
    return writer.Finish();
  }

  // before: the first old number of each rank, and the end.
  Status NumbersOfRead(const std::vector<VertexId>& before, const NumberTable& table)
  {
    const std::vector<VertexId>& readBegin = this->Vertices.readBegin;
    const std::uint64_t count = readBegin[this->Group.Rank() + 1] - readBegin[this->Group.Rank()];
    constexpr std::size_t ofRound = ElementsOfRound(4 * sizeof(VertexId));
    const Result<std::uint64_t> rounds = this->Group.Most(RoundsOf(count, ofRound));
    KDSTREAM_TRY(rounds);
    SpillFile renewed;
    KDSTREAM_TRY(Take(this->Folder.CreateFile("numbers of vertices", 0), renewed));
    for (std::uint64_t round = 0; round < *rounds; ++round)
    {
      const std::uint64_t from = std::min(round * ofRound, count);
      std::vector<VertexId> numbers(std::min<std::uint64_t>(ofRound, count - from));
      KDSTREAM_TRY(
        ReadRecords<VertexId>(this->Vertices.numberOf, from, std::span<VertexId>(numbers)));
      const Result<std::vector<VertexId>> found =
        LookUpEntries(this->Group, before, table, numbers);
      KDSTREAM_TRY(found);
      KDSTREAM_TRY(WriteRecords<VertexId>(renewed, from, std::span<const VertexId>(*found)));
    }
    this->Vertices.numberOf = std::move(renewed);
    return {};
  }

  // Step 5: sends unused vertices to rank 0.
  Status SendToFirst(VertexFiles own, VertexFiles& all)
  {
    const Result<std::vector<std::uint64_t>> counts = this->Group.Gather(own.count);
    KDSTREAM_TRY(counts);
    const std::size_t bytes = this->Vertices.kept.tupleBytes, entryBytes = sizeof(Vec3) + bytes;
    std::vector<std::uint64_t> next{ 0 }; // for each rank, where its next vertices are written
    for (const std::uint64_t count : *counts)
    {
      next.push_back(next.back() + count);
    }
    all.tupleBytes = bytes;
    if (this->Group.IsFirst())
    {
      all.count = static_cast<std::uint32_t>(next.back());
      KDSTREAM_TRY(Take(this->Folder.CreateFile("unused vertices", 0), all.points));
      KDSTREAM_TRY(bytes > 0
                     ? Take(this->Folder.CreateFile("attributes of unused vertices", 0), all.tuples)
                     : Status{});
    }
    const std::size_t ofRound = ElementsOfRound(entryBytes);
    const auto make = [&](std::uint64_t round, RankLists<std::byte>& out) -> Status
    {
      const std::uint64_t from = round * ofRound;
      std::vector<Vec3> points(std::min<std::uint64_t>(ofRound, own.count - from));
      std::vector<std::byte> tuples(points.size() * bytes);
      KDSTREAM_TRY(ReadRecords<Vec3>(own.points, from, std::span<Vec3>(points)));
      if (!tuples.empty())
      {
        KDSTREAM_TRY(own.tuples.Read(from * bytes, tuples));
      }
      const auto raw = std::as_bytes(std::span(points));
      out[0].assign(raw.begin(), raw.end());
      out[0].insert(out[0].end(), tuples.begin(), tuples.end());
      return {};
    };
    const auto take = [&](std::size_t from, std::span<const std::byte> entries) -> Status
    {
      const std::size_t count = entries.size() / entryBytes;
      if (count == 0)
      {
        return {};
      }
      const auto points = entries.first(count * sizeof(Vec3));
      KDSTREAM_TRY(all.points.Write(next[from] * sizeof(Vec3), points));
      if (bytes > 0)
      {
        KDSTREAM_TRY(all.tuples.Write(next[from] * bytes, entries.subspan(points.size())));
      }
      next[from] += count;
      return {};
    };
    return this->Group.ExchangeInRounds<std::byte>(RoundsOf(own.count, ofRound), make, take);
  }

  MpiGroup& Group;
  SpillFolder& Folder;
  const SpilledMesh& Share;
  DistributedVertices& Vertices;
  const std::uint64_t Memory;
  const Execution& Exec;
};

}

Result<DistributedUnused> SetUnusedAside(MpiGroup& group, SpillFolder& folder,
  const SpilledMesh& share, DistributedVertices& vertices, std::uint64_t memory,
  const Execution& execution)
{
  return UnusedParting(group, folder, share, vertices, memory, execution).Part();
}

}
