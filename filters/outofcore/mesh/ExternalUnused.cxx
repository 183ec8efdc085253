// SPDX-License-Identifier: BSD-3-Clause
#include "filters/outofcore/mesh/ExternalUnused.h"

#include "filters/core/TakeResult.h"
#include "filters/outofcore/files/RecordFile.h"

#include <algorithm>
#include <span>
#include <vector>

namespace kdstream
{
namespace
{

// Writes vertices one after the other, in blocks.
class VertexWriter
{
public:
  VertexWriter(VertexFiles& files, std::size_t tupleBytes)
    : Files(files)
  {
    files.tupleBytes = tupleBytes;
  }

  Status Open(SpillFolder& folder)
  {
    KDSTREAM_TRY(Take(folder.CreateFile("vertices", 0), this->Files.points));
    return this->Files.tupleBytes > 0
             ? Take(folder.CreateFile("attributes of vertices", 0), this->Files.tuples)
             : Status{};
  }

  void Add(const Vec3& point, std::span<const std::byte> tuple)
  {
    this->Points.push_back(point);
    this->Tuples.insert(this->Tuples.end(), tuple.begin(), tuple.end());
  }

  Status Flush()
  {
    KDSTREAM_TRY(WriteRecords<Vec3>(
      this->Files.points, this->Files.count, std::span<const Vec3>(this->Points)));
    if (!this->Tuples.empty())
    {
      KDSTREAM_TRY(this->Files.tuples.Write(
        this->Files.count * std::uint64_t{ this->Files.tupleBytes }, this->Tuples));
    }
    this->Files.count += static_cast<std::uint32_t>(this->Points.size());
    this->Points.clear();
    this->Tuples.clear();
    return {};
  }

private:
  VertexFiles& Files;
  std::vector<Vec3> Points;
  std::vector<std::byte> Tuples;
};

}

MapSections SectionsOfMarks(std::uint32_t count, std::uint64_t memory)
{
  return MapSections::Over(count, 8 * memory, 1);
}

Result<VertexMarks> MarkVertices(SpillFolder& folder, const MapSections& sections,
  const std::function<Status(std::size_t section, SectionMarks& mark)>& nameAll)
{
  VertexMarks marks;
  marks.count = sections.count;
  KDSTREAM_TRY(Take(folder.CreateFile("which vertices are used", 0), marks.file));
  RecordWriter<std::uint8_t> writer(marks.file);
  for (std::size_t section = 0; section < sections.Number(); ++section)
  {
    SectionMarks ofSection(sections, section);
    KDSTREAM_TRY(nameAll(section, ofSection));
    for (const bool marked : ofSection.All())
    {
      writer.Append(marked ? 1 : 0);
      marks.marked += marked ? 1 : 0;
    }
  }
  KDSTREAM_TRY(writer.Finish());
  return marks;
}

Result<PartedVertices> PartVertices(
  SpillFolder& folder, VertexFiles vertices, const VertexMarks& marks)
{
  PartedVertices parted;
  if (marks.marked == vertices.count)
  {
    parted.used = std::move(vertices);
    return parted;
  }
  const std::size_t bytes = vertices.tupleBytes;
  VertexWriter used(parted.used, bytes), unused(parted.unused, bytes);
  KDSTREAM_TRY(used.Open(folder));
  KDSTREAM_TRY(unused.Open(folder));
  VertexMap& map = parted.map.emplace();
  map.count = vertices.count;
  KDSTREAM_TRY(Take(folder.CreateFile("numbers of used vertices", 0), map.file));
  RecordWriter<VertexId> numbers(map.file);
  VertexId next = 0;
  const std::size_t atOnce = std::max<std::size_t>(1, spillBlockBytes / (sizeof(Vec3) + bytes));
  for (VertexId first = 0; first < vertices.count;)
  {
    const std::size_t count = std::min<std::size_t>(atOnce, vertices.count - first);
    std::vector<Vec3> points(count);
    std::vector<std::byte> tuples(count * bytes);
    std::vector<std::uint8_t> marked(count);
    KDSTREAM_TRY(ReadRecords<Vec3>(vertices.points, first, std::span<Vec3>(points)));
    KDSTREAM_TRY(ReadRecords<std::uint8_t>(marks.file, first, std::span<std::uint8_t>(marked)));
    if (bytes > 0)
    {
      KDSTREAM_TRY(vertices.tuples.Read(std::uint64_t{ first } * bytes, tuples));
    }
    for (std::size_t i = 0; i < count; ++i)
    {
      numbers.Append(next);
      next += marked[i];
      (marked[i] != 0 ? used : unused).Add(points[i], std::span(tuples).subspan(i * bytes, bytes));
    }
    KDSTREAM_TRY(used.Flush());
    KDSTREAM_TRY(unused.Flush());
    first += static_cast<VertexId>(count);
  }
  KDSTREAM_TRY(numbers.Finish());
  return parted;
}

Result<PartedVertices> PartUnusedExternally(SpillFolder& folder, VertexFiles vertices,
  const SpillFile& triangles, std::uint64_t triangleCount, std::uint64_t memory,
  const Execution& execution)
{
  const MapSections sections = SectionsOfMarks(vertices.count, memory / 2);
  const double passes = double(std::max<std::size_t>(1, sections.Number()));
  const Result<VertexMarks> marks = MarkVertices(folder, sections,
    [&](std::size_t section, SectionMarks& mark) -> Status
    {
      RecordReader<NumberedTriangle> reader(triangles, 0, triangleCount);
      for (std::uint64_t done = 0; done < triangleCount;)
      {
        const Result<std::span<const NumberedTriangle>> block = reader.Next();
        KDSTREAM_TRY(block);
        for (const NumberedTriangle& t : *block)
        {
          for (const VertexId corner : t.corners)
          {
            mark(corner);
          }
        }
        done += block->size();
        KDSTREAM_TRY(execution.Report(
          "weld", (double(section) + double(done) / double(triangleCount)) / passes));
      }
      return {};
    });
  KDSTREAM_TRY(marks);
  return PartVertices(folder, std::move(vertices), *marks);
}

}
