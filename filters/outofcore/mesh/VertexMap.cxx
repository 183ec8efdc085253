// SPDX-License-Identifier: BSD-3-Clause
#include "filters/outofcore/mesh/VertexMap.h"

#include "filters/outofcore/files/BucketFile.h"
#include "filters/outofcore/files/LoadAhead.h"

#include <algorithm>
#include <optional>
#include <vector>

namespace kdstream
{
namespace
{

constexpr std::string_view mapStep = "faces";
constexpr std::size_t trianglesPerTask = 1 << 14;

using Visit = std::function<Status(std::span<const NumberedTriangle>)>;
using CornerBuckets = RecordBuckets<NumberedTriangle>; // by the section of one corner

class TriangleMapper
{
public:
  TriangleMapper(SpillFolder& folder, const SpillFile& triangles, std::uint64_t count,
    const VertexMap& map, std::uint64_t memory, const Execution& execution, const Visit& visit)
    : Folder(folder)
    , Triangles(triangles)
    , Count(count)
    , Map(map)
    , Memory(memory)
    , Exec(execution)
    , Output(visit)
    , Sections(MapSections::Over(map.count, memory / 2, sizeof(VertexId)))
  {
  }

  Status Run() { return this->Sections.Number() <= 1 ? this->MapAtOnce() : this->MapBySections(); }

private:
  Status Load(std::size_t section)
  {
    this->First = this->Sections.Begin(section);
    this->Entries.resize(this->Sections.End(section) - this->First);
    return ReadRecords<VertexId>(this->Map.file, this->First, std::span<VertexId>(this->Entries));
  }

  Status Report(std::uint64_t done, std::uint64_t of)
  {
    return this->Exec.Report(mapStep, double(done) / double(std::max<std::uint64_t>(1, of)));
  }

  Status MapAtOnce()
  {
    KDSTREAM_TRY(this->Map.count > 0 ? this->Load(0) : Status{});
    const std::uint64_t most = RecordsOfBlock<NumberedTriangle>(
      static_cast<std::size_t>(std::min<std::uint64_t>(this->Memory / 16, 4 * spillBlockBytes)));
    std::vector<NumberedTriangle> blocks[2]; // one is passed on while the other is read
    std::uint64_t done = 0;
    return ForEachLoaded(
      static_cast<std::size_t>((this->Count + most - 1) / most),
      [&](std::size_t i) -> Result<std::vector<NumberedTriangle>*>
      {
        std::vector<NumberedTriangle>& block = blocks[i % 2];
        block.resize(static_cast<std::size_t>(std::min(most, this->Count - i * most)));
        KDSTREAM_TRY(this->ReadMapped(i * most, block));
        return &block;
      },
      [&](const std::vector<NumberedTriangle>* block) -> Status
      {
        KDSTREAM_TRY(this->Output(*block));
        done += block->size();
        return this->Report(done, this->Count);
      },
      this->Exec);
  }

  // Reads triangles, beginning with number `first`, and replaces all their corners.
  Status ReadMapped(std::uint64_t first, std::span<NumberedTriangle> triangles)
  {
    KDSTREAM_TRY(ReadRecords<NumberedTriangle>(this->Triangles, first, triangles));
    this->Exec.parallelFor(triangles.size(), trianglesPerTask,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t i = begin; i < end; ++i)
        {
          for (VertexId& corner : triangles[i].corners)
          {
            corner = this->Entries[corner];
          }
        }
      });
    return {};
  }

  // Makes buckets for triangles, by the section of one corner.
  Result<CornerBuckets> MakeBuckets()
  {
    return CornerBuckets::Create(this->Folder, "triangles by their vertices",
      this->Sections.Number(), this->Count, this->Memory / 4);
  }

  Status MapBySections()
  {
    Result<CornerBuckets> buckets = this->MakeBuckets();
    KDSTREAM_TRY(buckets);
    RecordReader<NumberedTriangle> reader(this->Triangles, 0, this->Count);
    for (std::uint64_t done = 0; done < this->Count;)
    {
      const Result<std::span<const NumberedTriangle>> block = reader.Next();
      KDSTREAM_TRY(block);
      for (const NumberedTriangle& t : *block)
      {
        KDSTREAM_TRY(buckets->Add(this->Sections.Of(t.corners[0]), t));
      }
      done += block->size();
      KDSTREAM_TRY(this->Report(done, 4 * this->Count));
    }
    for (std::size_t corner = 0; corner < 3; ++corner)
    {
      KDSTREAM_TRY(this->MapCorner(*buckets, corner));
    }
    return {};
  }

  // Replaces one corner of all triangles. Then sorts them by the next corner, or passes them on
  // after the last one.
  Status MapCorner(CornerBuckets& buckets, std::size_t corner)
  {
    KDSTREAM_TRY(buckets.Finish());
    std::optional<CornerBuckets> next;
    if (corner < 2)
    {
      Result<CornerBuckets> made = this->MakeBuckets();
      KDSTREAM_TRY(made);
      next.emplace(std::move(*made));
    }
    std::vector<NumberedTriangle> mapped;
    const auto flush = [&]() -> Status
    {
      const Status given = mapped.empty() ? Status{} : this->Output(mapped);
      mapped.clear();
      return given;
    };
    std::uint64_t done = (corner + 1) * this->Count;
    for (std::size_t section = 0; section < this->Sections.Number(); ++section)
    {
      KDSTREAM_TRY(this->Load(section));
      KDSTREAM_TRY(buckets.ForEach(section,
        [&](NumberedTriangle t) -> Status
        {
          t.corners[corner] = this->Entries[t.corners[corner] - this->First];
          if (next)
          {
            return next->Add(this->Sections.Of(t.corners[corner + 1]), t);
          }
          mapped.push_back(t);
          return mapped.size() * sizeof(t) < spillBlockBytes ? Status{} : flush();
        }));
      done += buckets.Size(section);
      KDSTREAM_TRY(this->Report(done, 4 * this->Count));
    }
    KDSTREAM_TRY(flush());
    if (next)
    {
      buckets = std::move(*next);
    }
    return {};
  }

  SpillFolder& Folder;
  const SpillFile& Triangles;
  std::uint64_t Count;
  const VertexMap& Map;
  std::uint64_t Memory;
  const Execution& Exec;
  const Visit& Output;
  MapSections Sections;
  VertexId First = 0; // first entry of the loaded section
  std::vector<VertexId> Entries;
};

}

MapSections MapSections::Over(std::uint32_t count, std::uint64_t memory, std::size_t entryBytes)
{
  const std::uint64_t most = std::max<std::uint64_t>(1, memory / entryBytes);
  return { count, static_cast<std::uint32_t>(std::min<std::uint64_t>(most, noVertex)) };
}

Status MapTriangles(SpillFolder& folder, const SpillFile& triangles, std::uint64_t count,
  const VertexMap& map, std::uint64_t memory, const Execution& execution, const Visit& visit)
{
  return TriangleMapper(folder, triangles, count, map, memory, execution, visit).Run();
}

}
