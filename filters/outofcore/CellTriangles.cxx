#include "filters/outofcore/CellTriangles.h"

#include "filters/core/KdTree.h"

#include <algorithm>

namespace kdstream
{
namespace
{

constexpr std::string_view step = "faces";

struct RankedVertex
{
  VertexId id = 0, rank = 0;
};

// The ranks into buckets by sections of the ids.
template <class Scalar>
Status BucketRanks(const SpillFile& records, std::uint32_t count, const MapSections& sections,
  RecordBuckets<RankedVertex>& buckets, const Execution& execution)
{
  RecordReader<PointRecord<Scalar>> reader(records, 0, count);
  VertexId rank = 0;
  while (rank < count)
  {
    const auto block = reader.Next();
    if (!block)
    {
      return block.GetError();
    }
    for (const PointRecord<Scalar>& record : *block)
    {
      if (Status status = buckets.Add(sections.Of(record.id), { record.id, rank++ }); !status)
      {
        return status;
      }
    }
    if (Status status = execution.Report(step, 0.5 * double(rank) / double(count)); !status)
    {
      return status;
    }
  }
  return buckets.Finish();
}

}

template <class Scalar>
Result<VertexMap> RankVertices(SpillFolder& folder, const SpillFile& records, std::uint32_t count,
  std::uint64_t memory, const Execution& execution)
{
  const MapSections sections = MapSections::Over(count, memory / 2, sizeof(VertexId));
  Result<RecordBuckets<RankedVertex>> buckets = RecordBuckets<RankedVertex>::Create(
    folder, "ranks by vertex", std::max<std::size_t>(1, sections.Number()), count, memory / 4);
  Result<SpillFile> file =
    folder.CreateFile("ranks of vertices", std::uint64_t{ count } * sizeof(VertexId));
  if (!buckets || !file)
  {
    return !buckets ? buckets.GetError() : file.GetError();
  }
  VertexMap map{ std::move(*file), count };
  Status status = BucketRanks<Scalar>(records, count, sections, *buckets, execution);
  std::vector<VertexId> entries;
  for (std::size_t section = 0; status && section < sections.Number(); ++section)
  {
    const VertexId first = sections.Begin(section);
    entries.assign(sections.End(section) - first, 0);
    status = buckets->ForEach(section,
      [&](const RankedVertex& vertex) -> Status
      {
        entries[vertex.id - first] = vertex.rank;
        return {};
      });
    if (status)
    {
      status = WriteRecords<VertexId>(map.file, first, std::span<const VertexId>(entries));
    }
    if (status)
    {
      status = execution.Report(step, 0.5 + 0.5 * double(sections.End(section)) / double(count));
    }
  }
  if (!status)
  {
    return status.GetError();
  }
  return map;
}

template Result<VertexMap> RankVertices<float>(
  SpillFolder&, const SpillFile&, std::uint32_t, std::uint64_t, const Execution&);
template Result<VertexMap> RankVertices<double>(
  SpillFolder&, const SpillFile&, std::uint32_t, std::uint64_t, const Execution&);

CellOfRank::CellOfRank(std::uint32_t vertices, unsigned depth)
  : Vertices(vertices)
{
  const std::uint64_t cells = std::uint64_t{ 1 } << depth;
  for (std::uint64_t cell = 0; cell < cells; ++cell)
  {
    this->Begin.push_back(RangeOfCell(vertices, depth, cell).begin);
  }
  this->Begin.push_back(vertices);
}

std::size_t CellOfRank::operator()(VertexId rank) const
{
  // As if all were of equal size; a few steps make up for it.
  auto cell = static_cast<std::size_t>(rank * std::uint64_t{ this->Count() } / this->Vertices);
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
  const SpillFile& triangles, std::uint64_t count, const VertexMap& ranks, unsigned depth,
  std::uint64_t memory, const Execution& execution)
{
  const CellOfRank cellOf(ranks.count, depth);
  Result<RecordBuckets<NumberedTriangle>> cells = RecordBuckets<NumberedTriangle>::Create(
    folder, "triangles of cells", cellOf.Count(), count, memory / 4);
  if (!cells)
  {
    return cells.GetError();
  }
  const auto add = [&](std::span<const NumberedTriangle> block) -> Status
  {
    for (const NumberedTriangle& t : block)
    {
      const std::size_t a = cellOf(t.corners[0]), b = cellOf(t.corners[1]),
                        c = cellOf(t.corners[2]);
      Status status = cells->Add(a, t);
      if (status && b != a)
      {
        status = cells->Add(b, t);
      }
      if (status && c != a && c != b)
      {
        status = cells->Add(c, t);
      }
      if (!status)
      {
        return status;
      }
    }
    return {};
  };
  Status status =
    MapTriangles(folder, triangles, count, ranks, memory - memory / 4, execution, add);
  if (status)
  {
    status = cells->Finish();
  }
  if (!status)
  {
    return status.GetError();
  }
  return std::move(*cells);
}

}
