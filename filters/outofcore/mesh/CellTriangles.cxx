// SPDX-License-Identifier: BSD-3-Clause
#include "filters/outofcore/mesh/CellTriangles.h"

#include "filters/core/RadixSort.h"
#include "filters/core/tree/KdTree.h"
#include "filters/outofcore/files/BatchPass.h"
#include "filters/outofcore/files/MemoryPlan.h"

#include <algorithm>

namespace kdstream
{
namespace
{

constexpr std::string_view cellStep = "faces";
constexpr std::size_t trianglesOfRun = 1 << 13;

// Fills in the ranks of all vertices, by id, when they fit in memory.
template <class Scalar>
Status FillRanks(const SpillFile& records, std::span<VertexId> ranks, std::uint64_t memory,
  const Execution& execution)
{
  using Record = PointRecord<Scalar>;
  BatchPass<Record> batches(ShapeOfPass(memory, sizeof(Record)), execution);
  return batches.Over(
    records, 0, ranks.size(),
    [&](std::size_t, std::span<Record> block, std::uint64_t first) -> Status
    {
      for (std::size_t i = 0; i < block.size(); ++i)
      {
        ranks[block[i].id] = static_cast<VertexId>(first + i);
      }
      return {};
    },
    [&](std::size_t, std::uint64_t last)
    { return execution.Report(cellStep, double(last) / double(ranks.size())); });
}

struct RankedVertex
{
  VertexId id = 0, rank = 0;
};

// Puts the ranks into buckets, by sections of the ids.
template <class Scalar>
Status BucketRanks(const SpillFile& records, std::uint32_t count, const MapSections& sections,
  RecordBuckets<RankedVertex>& buckets, const Execution& execution)
{
  RecordReader<PointRecord<Scalar>> reader(records, 0, count);
  VertexId rank = 0;
  while (rank < count)
  {
    const auto block = reader.Next();
    KDSTREAM_TRY(block);
    for (const PointRecord<Scalar>& record : *block)
    {
      KDSTREAM_TRY(buckets.Add(sections.Of(record.id), { record.id, rank++ }));
    }
    KDSTREAM_TRY(execution.Report(cellStep, 0.5 * double(rank) / double(count)));
  }
  return buckets.Finish();
}

// Takes one pass. Memory: `memory` besides the ranks.
template <class Scalar>
Result<VertexMap> RankAtOnce(SpillFolder& folder, const SpillFile& records, std::uint32_t count,
  std::uint64_t memory, const Execution& execution)
{
  Result<SpillFile> file =
    folder.CreateFile("ranks of vertices", std::uint64_t{ count } * sizeof(VertexId));
  KDSTREAM_TRY(file);
  std::vector<VertexId> ranks(count);
  KDSTREAM_TRY(FillRanks<Scalar>(records, ranks, memory, execution));
  KDSTREAM_TRY(WriteRecords<VertexId>(*file, 0, std::span<const VertexId>(ranks)));
  return VertexMap{ std::move(*file), count };
}

// Puts the triangles of a block that touch the same cell next to each other, and adds them to the
// cells.
class CellRuns
{
public:
  void Sort(std::span<const NumberedTriangle> block, const CellOfRank& cellOf)
  {
    this->Entries.clear();
    for (std::size_t i = 0; i < block.size(); ++i)
    {
      const Triangle& corners = block[i].corners;
      const std::uint64_t a = cellOf(corners[0]), b = cellOf(corners[1]), c = cellOf(corners[2]);
      this->Entries.push_back(a << 32 | i);
      if (b != a)
      {
        this->Entries.push_back(b << 32 | i);
      }
      if (c != a && c != b)
      {
        this->Entries.push_back(c << 32 | i);
      }
    }
    SortByUpperHalf(this->Entries);
    this->Sorted.clear();
    for (const std::uint64_t entry : this->Entries)
    {
      this->Sorted.push_back(block[static_cast<std::uint32_t>(entry)]);
    }
  }

  Status AddTo(RecordBuckets<NumberedTriangle>& cells) const
  {
    const std::span<const NumberedTriangle> sorted(this->Sorted);
    for (std::size_t begin = 0, end = 0; begin < sorted.size(); begin = end)
    {
      const std::uint64_t cell = this->Entries[begin] >> 32;
      while (end < sorted.size() && this->Entries[end] >> 32 == cell)
      {
        ++end;
      }
      KDSTREAM_TRY(cells.Add(static_cast<std::size_t>(cell), sorted.subspan(begin, end - begin)));
    }
    return {};
  }

private:
  std::vector<std::uint64_t> Entries; // cell, index in the block
  std::vector<NumberedTriangle> Sorted;
};

}

template <class Scalar>
Result<VertexMap> RankVertices(SpillFolder& folder, const SpillFile& records, std::uint32_t count,
  std::uint64_t memory, const Execution& execution)
{
  const MapSections sections = MapSections::Over(count, memory / 2, sizeof(VertexId));
  if (sections.Number() == 1)
  {
    return RankAtOnce<Scalar>(folder, records, count, memory / 8, execution);
  }
  Result<RecordBuckets<RankedVertex>> buckets = RecordBuckets<RankedVertex>::Create(
    folder, "ranks by vertex", std::max<std::size_t>(1, sections.Number()), count, memory / 4);
  Result<SpillFile> file =
    folder.CreateFile("ranks of vertices", std::uint64_t{ count } * sizeof(VertexId));
  if (!buckets || !file)
  {
    return !buckets ? buckets.GetError() : file.GetError();
  }
  VertexMap map{ std::move(*file), count };
  KDSTREAM_TRY(BucketRanks<Scalar>(records, count, sections, *buckets, execution));
  std::vector<VertexId> entries;
  for (std::size_t section = 0; section < sections.Number(); ++section)
  {
    const VertexId first = sections.Begin(section);
    entries.assign(sections.End(section) - first, 0);
    KDSTREAM_TRY(buckets->ForEach(section,
      [&](const RankedVertex& vertex) -> Status
      {
        entries[vertex.id - first] = vertex.rank;
        return {};
      }));
    KDSTREAM_TRY(WriteRecords<VertexId>(map.file, first, std::span<const VertexId>(entries)));
    KDSTREAM_TRY(
      execution.Report(cellStep, 0.5 + 0.5 * double(sections.End(section)) / double(count)));
  }
  return map;
}

template Result<VertexMap> RankVertices<float>(
  SpillFolder&, const SpillFile&, std::uint32_t, std::uint64_t, const Execution&);
template Result<VertexMap> RankVertices<double>(
  SpillFolder&, const SpillFile&, std::uint32_t, std::uint64_t, const Execution&);

CellOfRank::CellOfRank(std::uint32_t vertices, unsigned depth)
  : Scale(double(std::uint64_t{ 1 } << depth) / double(std::max(1U, vertices)))
{
  const std::uint64_t cells = std::uint64_t{ 1 } << depth;
  for (std::uint64_t cell = 0; cell < cells; ++cell)
  {
    this->Begin.push_back(RangeOfCell(vertices, depth, cell).begin);
  }
  this->Begin.push_back(vertices);
}

CellOfRank::CellOfRank(std::span<const VertexId> begin)
  : Scale(0)
  , Begin(begin.begin(), begin.end())
{
}

std::size_t CellOfRank::operator()(VertexId rank) const
{
  if (this->Scale == 0)
  {
    return static_cast<std::size_t>(
      std::upper_bound(this->Begin.begin() + 1, this->Begin.end() - 1, rank) - this->Begin.begin() -
      1);
  }
  // First a guess as if all cells had equal size; a few steps correct it.
  std::size_t cell = std::min(static_cast<std::size_t>(rank * this->Scale), this->Count() - 1);
  while (this->Begin[cell] > rank)
  {
    --cell;
  }
  while (this->Begin[cell + 1] <= rank)
  {
    ++cell;
  }
  return cell;
}

Result<RecordBuckets<NumberedTriangle>> SortTrianglesIntoCells(SpillFolder& folder,
  const SpillFile& triangles, std::uint64_t count, const VertexMap& ranks, const CellOfRank& cellOf,
  std::uint64_t memory, const Execution& execution)
{
  Result<RecordBuckets<NumberedTriangle>> cells = RecordBuckets<NumberedTriangle>::Create(
    folder, "triangles of cells", cellOf.Count(), count, memory / 4);
  KDSTREAM_TRY(cells);
  std::vector<CellRuns> runs;
  const auto add = [&](std::span<const NumberedTriangle> block) -> Status
  {
    const std::size_t parts = (block.size() + trianglesOfRun - 1) / trianglesOfRun;
    runs.resize(std::max(runs.size(), parts));
    execution.parallelFor(parts, 1,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t part = begin; part < end; ++part)
        {
          const std::size_t first = part * trianglesOfRun;
          runs[part].Sort(
            block.subspan(first, std::min(trianglesOfRun, block.size() - first)), cellOf);
        }
      });
    for (std::size_t part = 0; part < parts; ++part)
    {
      KDSTREAM_TRY(runs[part].AddTo(*cells));
    }
    return {};
  };
  KDSTREAM_TRY(MapTriangles(folder, triangles, count, ranks, memory - memory / 4, execution, add));
  KDSTREAM_TRY(cells->Finish());
  return std::move(*cells);
}

}
