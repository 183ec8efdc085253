#include "filters/outofcore/MeshSpill.h"

#include <algorithm>
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

// The tuples of a chunk's arrays of one association, element by element.
std::vector<std::byte> Interleaved(const Mesh& chunk, std::span<const AttributeInfo> attributes,
  AttributeAssociation association, std::size_t count)
{
  const std::size_t stride = TupleBytes(attributes, association);
  std::vector<std::byte> tuples(count * stride);
  std::size_t offset = 0;
  for (const AttributeInfo& wanted : attributes)
  {
    if (wanted.association != association)
    {
      continue;
    }
    const std::size_t size = wanted.TupleSize();
    const auto values =
      std::as_bytes(std::span<const std::uint8_t>(FindAttribute(chunk.attributes, wanted)->values));
    for (std::size_t i = 0; i < count; ++i)
    {
      const auto tuple = values.subspan(i * size, size);
      std::copy(tuple.begin(), tuple.end(), tuples.begin() + std::ptrdiff_t(i * stride + offset));
    }
    offset += size;
  }
  return tuples;
}

bool FitsFloats(const Vec3& p)
{
  return std::all_of(
    p.begin(), p.end(), [](double x) { return static_cast<double>(static_cast<float>(x)) == x; });
}

// Point arrays, then cell arrays, each in their order: as a store has them.
std::vector<AttributeInfo> PointArraysFirst(std::vector<AttributeInfo> attributes)
{
  std::stable_partition(attributes.begin(), attributes.end(),
    [](const AttributeInfo& attribute)
    { return attribute.association == AttributeAssociation::Point; });
  return attributes;
}

class Spiller
{
public:
  Spiller(
    SpillFolder& folder, MeshReader& reader, std::size_t chunkBytes, const Execution& execution)
    : Folder(folder)
    , Reader(reader)
    , ChunkBytes(chunkBytes)
    , Exec(execution)
  {
  }

  Result<SpilledMesh> Run()
  {
    Status status = this->Prepare();
    if (status)
    {
      status = this->ReadVertices();
    }
    if (status && this->Output.vertices.count == 0)
    {
      status = Error{ ErrorCode::InvalidInput, "the mesh has no vertices" };
    }
    if (status)
    {
      status = this->ReadTriangles();
    }
    if (!status)
    {
      return status.GetError();
    }
    return std::move(this->Output);
  }

private:
  Status Prepare()
  {
    SpilledMesh& output = this->Output;
    output.attributes = PointArraysFirst(this->Reader.Info().attributes);
    std::vector<Attribute> none;
    for (const AttributeInfo& attribute : output.attributes)
    {
      none.push_back({ attribute, {} });
    }
    if (Status status = CheckAttributes(none, 0, 0); !status)
    {
      return status;
    }
    output.vertices.tupleBytes = TupleBytes(output.attributes, AttributeAssociation::Point);
    output.cellTupleBytes = TupleBytes(output.attributes, AttributeAssociation::Cell);
    // What the header claims is not taken from the disk: nobody knows yet whether it is true.
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
        if (!made)
        {
          return made.GetError();
        }
        *file = std::move(*made);
      }
    }
    return {};
  }

  std::size_t ElementsOfChunk(std::size_t elementBytes) const
  {
    return std::max<std::size_t>(1, this->ChunkBytes / elementBytes);
  }

  static Error TooMany(std::uint64_t count, const std::string& what)
  {
    return { ErrorCode::LimitExceeded,
      std::to_string(count) + " " + what + "; at most 4294967294 are possible" };
  }

  Status ReportRead() const
  {
    const double size = std::max(1.0, double(this->Reader.FileSize()));
    return this->Exec.Report("read", std::min(1.0, double(this->Reader.Position()) / size));
  }

  Status ReadVertices()
  {
    SpilledMesh& output = this->Output;
    std::uint32_t& done = output.vertices.count;
    const std::size_t limit = this->ElementsOfChunk(sizeof(Vec3) + output.vertices.tupleBytes);
    for (;;)
    {
      Mesh chunk;
      const Result<std::size_t> read = this->Reader.ReadVertices(chunk, limit);
      if (!read || *read == 0)
      {
        return read ? Status{} : Status(read.GetError());
      }
      if (done + chunk.points.size() >= noVertex)
      {
        return TooMany(done + chunk.points.size(), "vertices");
      }
      output.scalarType = chunk.scalarType;
      output.fitFloats =
        output.fitFloats && std::all_of(chunk.points.begin(), chunk.points.end(), FitsFloats);
      Status status =
        WriteRecords<Vec3>(output.vertices.points, done, std::span<const Vec3>(chunk.points));
      if (status && output.vertices.tupleBytes > 0)
      {
        status = output.vertices.tuples.Write(std::uint64_t{ done } * output.vertices.tupleBytes,
          Interleaved(chunk, output.attributes, AttributeAssociation::Point, chunk.points.size()));
      }
      done += static_cast<std::uint32_t>(chunk.points.size());
      if (status)
      {
        status = this->ReportRead();
      }
      if (!status)
      {
        return status;
      }
    }
  }

  Status ReadTriangles()
  {
    SpilledMesh& output = this->Output;
    std::uint32_t& done = output.triangleCount;
    const std::size_t limit =
      this->ElementsOfChunk(2 * sizeof(NumberedTriangle) + output.cellTupleBytes);
    std::vector<NumberedTriangle> numbered;
    for (;;)
    {
      Mesh chunk;
      const Result<std::size_t> read = this->Reader.ReadTriangles(chunk, limit);
      if (!read || *read == 0)
      {
        return read ? Status{} : Status(read.GetError());
      }
      if (done + chunk.triangles.size() >= noVertex)
      {
        return TooMany(done + chunk.triangles.size(), "triangles");
      }
      numbered.clear();
      for (const Triangle& corners : chunk.triangles)
      {
        numbered.push_back({ corners, done + static_cast<std::uint32_t>(numbered.size()) });
      }
      Status status = WriteRecords<NumberedTriangle>(
        output.triangles, done, std::span<const NumberedTriangle>(numbered));
      if (status && output.cellTupleBytes > 0)
      {
        status = output.cellTuples.Write(std::uint64_t{ done } * output.cellTupleBytes,
          Interleaved(
            chunk, output.attributes, AttributeAssociation::Cell, chunk.triangles.size()));
      }
      done += static_cast<std::uint32_t>(numbered.size());
      if (status)
      {
        status = this->ReportRead();
      }
      if (!status)
      {
        return status;
      }
    }
  }

  SpillFolder& Folder;
  MeshReader& Reader;
  std::size_t ChunkBytes;
  const Execution& Exec;
  SpilledMesh Output;
};

}

Result<SpilledMesh> SpillMesh(
  SpillFolder& folder, MeshReader& reader, std::size_t chunkBytes, const Execution& execution)
{
  return Spiller(folder, reader, chunkBytes, execution).Run();
}

}
