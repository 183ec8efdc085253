// SPDX-License-Identifier: BSD-3-Clause
#include "filters/outofcore/mesh/MeshSpill.h"

#include "filters/outofcore/files/Tuples.h"

#include <algorithm>
#include <array>
#include <string>

namespace kdstream
{
namespace
{

std::size_t TupleBytes(std::span<const AttributeInfo> attributes, AttributeAssociation association)
{
  std::size_t bytes = 0;
  for (const AttributeInfo& attribute : attributes)
  {
    bytes += attribute.association == association ? attribute.TupleSize() : 0;
  }
  return bytes;
}

// The tuples of a chunk, element by element: those of all arrays of one association.
std::vector<std::byte> Interleaved(const Mesh& chunk, std::span<const AttributeInfo> attributes,
  AttributeAssociation association, std::size_t count)
{
  std::vector<const Attribute*> arrays;
  for (const AttributeInfo& wanted : attributes)
  {
    if (wanted.association == association)
    {
      arrays.push_back(FindAttribute(chunk.attributes, wanted));
    }
  }
  return InterleaveTuples(arrays, count);
}

bool FitsFloats(const Vec3& p)
{
  return std::all_of(
    p.begin(), p.end(), [](double x) { return static_cast<double>(static_cast<float>(x)) == x; });
}

// Point arrays, then cell arrays, each in the order of the input: as in a store.
std::vector<AttributeInfo> PointArraysFirst(std::vector<AttributeInfo> attributes)
{
  std::stable_partition(attributes.begin(), attributes.end(),
    [](const AttributeInfo& attribute)
    { return attribute.association == AttributeAssociation::Point; });
  return attributes;
}

// The files of a spilled mesh, and the functions that write them.
class MeshFiles
{
public:
  explicit MeshFiles(SpillFolder& folder)
    : Folder(folder)
  {
  }

  Status Create(const std::vector<AttributeInfo>& attributes)
  {
    SpilledMesh& output = this->Output;
    output.attributes = PointArraysFirst(attributes);
    std::vector<Attribute> none;
    for (const AttributeInfo& attribute : output.attributes)
    {
      none.push_back({ attribute, {} });
    }
    KDSTREAM_TRY(CheckAttributes(none, 0, 0));
    output.vertices.tupleBytes = TupleBytes(output.attributes, AttributeAssociation::Point);
    output.cellTupleBytes = TupleBytes(output.attributes, AttributeAssociation::Cell);
    // No disk space is allocated for the counts in the header, because they may be wrong.
    const std::pair<SpillFile*, std::string_view> files[] = {
      { &output.vertices.points, "vertices" }, { &output.triangles, "triangles" },
      { output.vertices.tupleBytes > 0 ? &output.vertices.tuples : nullptr,
        "attributes of vertices" },
      { output.cellTupleBytes > 0 ? &output.cellTuples : nullptr, "attributes of triangles" }
    };
    for (const auto& [file, purpose] : files)
    {
      if (file != nullptr)
      {
        Result<SpillFile> made = this->Folder.CreateFile(purpose, 0);
        KDSTREAM_TRY(made);
        *file = std::move(*made);
      }
    }
    return {};
  }

  Status AddVertices(const Mesh& chunk)
  {
    SpilledMesh& output = this->Output;
    std::uint32_t& done = output.vertices.count;
    if (done + chunk.points.size() >= noVertex)
    {
      return TooMany(done + chunk.points.size(), "vertices");
    }
    output.scalarType = chunk.scalarType;
    output.fitFloats =
      output.fitFloats && std::all_of(chunk.points.begin(), chunk.points.end(), FitsFloats);
    KDSTREAM_TRY(
      WriteRecords<Vec3>(output.vertices.points, done, std::span<const Vec3>(chunk.points)));
    if (output.vertices.tupleBytes > 0)
    {
      KDSTREAM_TRY(output.vertices.tuples.Write(std::uint64_t{ done } * output.vertices.tupleBytes,
        Interleaved(chunk, output.attributes, AttributeAssociation::Point, chunk.points.size())));
    }
    done += static_cast<std::uint32_t>(chunk.points.size());
    return {};
  }

  Status AddTriangles(const Mesh& chunk)
  {
    SpilledMesh& output = this->Output;
    std::uint32_t& done = output.triangleCount;
    if (done + chunk.triangles.size() >= noVertex)
    {
      return TooMany(done + chunk.triangles.size(), "triangles");
    }
    this->Numbered.clear();
    for (const Triangle& corners : chunk.triangles)
    {
      this->Numbered.push_back(
        { corners, done + static_cast<std::uint32_t>(this->Numbered.size()) });
    }
    KDSTREAM_TRY(WriteRecords<NumberedTriangle>(
      output.triangles, done, std::span<const NumberedTriangle>(this->Numbered)));
    if (output.cellTupleBytes > 0)
    {
      KDSTREAM_TRY(output.cellTuples.Write(std::uint64_t{ done } * output.cellTupleBytes,
        Interleaved(chunk, output.attributes, AttributeAssociation::Cell, chunk.triangles.size())));
    }
    done += static_cast<std::uint32_t>(this->Numbered.size());
    return {};
  }

  const SpilledMesh& Get() const { return this->Output; }
  SpilledMesh Take() { return std::move(this->Output); }

private:
  static Error TooMany(std::uint64_t count, const std::string& what)
  {
    return { ErrorCode::LimitExceeded,
      std::to_string(count) + " " + what + "; at most 4294967294 are possible" };
  }

  SpillFolder& Folder;
  SpilledMesh Output;
  std::vector<NumberedTriangle> Numbered; // of the current chunk
};

class Spiller
{
public:
  Spiller(SpillFolder& folder, MeshReader& reader, std::size_t chunkBytes,
    const Execution& execution, bool part)
    : Files(folder)
    , Reader(reader)
    , ChunkBytes(chunkBytes)
    , Exec(execution)
    , Part(part)
  {
  }

  Result<SpilledMesh> Run()
  {
    KDSTREAM_TRY(this->Files.Create(this->Reader.Info().attributes));
    KDSTREAM_TRY(this->ReadVertices());
    if (this->Files.Get().vertices.count == 0 && !this->Part)
    {
      return BadInput("the mesh has no vertices", Remedy::Repair);
    }
    KDSTREAM_TRY(this->ReadTriangles());
    return this->Files.Take();
  }

private:
  std::size_t ElementsOfChunk(std::size_t elementBytes) const
  {
    return std::max<std::size_t>(1, this->ChunkBytes / elementBytes);
  }

  Status ReportRead() const
  {
    const double size = std::max(1.0, double(this->Reader.FileSize()));
    return this->Exec.Report("read", std::min(1.0, double(this->Reader.Position()) / size));
  }

  // Calls read(chunk) -> Result<count> until nothing is left, and use(chunk) -> Status for each
  // chunk. While a chunk is used, the next one is read, if the execution has a thread for it.
  template <class Read, class Use>
  Status ForEachChunk(const Read& read, const Use& use)
  {
    std::array<Mesh, 2> chunks;
    Result<std::size_t> found = read(chunks[0]);
    for (std::size_t i = 0; found && *found > 0; ++i)
    {
      const Mesh& chunk = chunks[i % 2];
      Mesh& next = chunks[(i + 1) % 2];
      next.points.clear();
      next.triangles.clear();
      for (Attribute& array : next.attributes)
      {
        array.values.clear();
      }
      Status used;
      this->Exec.parallelFor(2, 1,
        [&](std::size_t begin, std::size_t end)
        {
          for (std::size_t which = begin; which < end; ++which)
          {
            if (which == 0)
            {
              used = use(chunk);
            }
            else
            {
              found = read(next);
            }
          }
        });
      if (used)
      {
        used = this->ReportRead();
      }
      KDSTREAM_TRY(used);
    }
    return found ? Status{} : Status(found.GetError());
  }

  Status ReadVertices()
  {
    const std::size_t limit =
      this->ElementsOfChunk(sizeof(Vec3) + this->Files.Get().vertices.tupleBytes);
    return this->ForEachChunk([&](Mesh& chunk) { return this->Reader.ReadVertices(chunk, limit); },
      [&](const Mesh& chunk) { return this->Files.AddVertices(chunk); });
  }

  Status ReadTriangles()
  {
    const std::size_t limit =
      this->ElementsOfChunk(2 * sizeof(NumberedTriangle) + this->Files.Get().cellTupleBytes);
    return this->ForEachChunk([&](Mesh& chunk) { return this->Reader.ReadFaces(chunk, limit); },
      [&](const Mesh& chunk) { return this->Files.AddTriangles(chunk); });
  }

  MeshFiles Files;
  MeshReader& Reader;
  std::size_t ChunkBytes;
  const Execution& Exec;
  bool Part;
};

}

Result<SpilledMesh> SpillMesh(SpillFolder& folder, MeshReader& reader, std::size_t chunkBytes,
  const Execution& execution, bool part)
{
  return Spiller(folder, reader, chunkBytes, execution, part).Run();
}

Result<SpilledMesh> SpillMesh(SpillFolder& folder, const Mesh& mesh)
{
  std::vector<AttributeInfo> attributes;
  for (const Attribute& attribute : mesh.attributes)
  {
    attributes.push_back(attribute.Info());
  }
  MeshFiles files(folder);
  KDSTREAM_TRY(files.Create(attributes));
  KDSTREAM_TRY(files.AddVertices(mesh));
  KDSTREAM_TRY(files.AddTriangles(mesh));
  return files.Take();
}

}
