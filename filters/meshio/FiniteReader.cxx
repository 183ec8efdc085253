// SPDX-License-Identifier: BSD-3-Clause
// Drops points that are not finite, and the faces that use them: see FiniteReader.h.
#include "filters/meshio/FiniteReader.h"

#include "filters/meshio/DroppedPoints.h"

#include <algorithm>
#include <utility>

namespace kdstream
{
namespace
{

// Wraps the reader of a format. Names the file in its errors, and drops points that are not finite;
// the readers of the formats do neither.
class FiniteReader : public MeshReader
{
public:
  FiniteReader(
    std::unique_ptr<MeshReader> reader, std::string file, const std::filesystem::path& scratch)
    : Reader(std::move(reader))
    , File(std::move(file))
    , FileInfo(this->Reader->Info())
    , Dropped(scratch)
  {
  }

  const MeshFileInfo& Info() const override { return this->FileInfo; }
  Result<std::size_t> ReadVertices(Mesh& mesh, std::size_t limit) override
  {
    return OfFile(this->File, this->Tell(this->ReadFinite(mesh, limit)));
  }
  Result<std::size_t> ReadTriangles(Mesh& mesh, std::size_t limit) override
  {
    return OfFile(
      this->File, this->Tell(this->Dropped.Any() ? this->ReadFinitePart(mesh, limit)
                                                 : this->Reader->ReadTriangles(mesh, limit)));
  }
  Result<std::uint64_t> SkipVertices(std::uint64_t count) override
  {
    const Result<std::uint64_t> skipped =
      OfFile(this->File, this->Tell(this->Reader->SkipVertices(count)));
    this->VerticesRead += skipped ? *skipped : 0;
    return skipped;
  }
  Result<std::uint64_t> SkipFaces(std::uint64_t count) override
  {
    const Result<std::uint64_t> skipped =
      OfFile(this->File, this->Tell(this->Reader->SkipFaces(count)));
    this->FacesRead += skipped ? *skipped : 0;
    return skipped;
  }
  std::uint64_t FileSize() const override { return this->Reader->FileSize(); }
  std::uint64_t Position() const override { return this->Reader->Position(); }

private:
  // Copies into Info() what the reader has found out while reading.
  template <class Number>
  Result<Number> Tell(Result<Number> result)
  {
    this->FileInfo.ignoredAttributes = this->Reader->Info().ignoredAttributes;
    this->FileInfo.tolerance = this->Reader->Info().tolerance;
    this->FileInfo.tolerance.Add(this->Own);
    return OfInput(std::move(result));
  }

  Result<std::size_t> ReadFinite(Mesh& mesh, std::size_t limit)
  {
    const std::size_t begin = mesh.points.size();
    const Result<std::size_t> read = this->Reader->ReadVertices(mesh, limit);
    KDSTREAM_TRY(read);
    // Some readers count dropped points themselves, because they know which points are one in the
    // file.
    if (!this->Reader->KnowsFinite())
    {
      KDSTREAM_TRY(DropPoints(mesh, begin, this->VerticesRead, this->Dropped,
        this->Reader->CountsNotFinite() ? nullptr : &this->Own));
    }
    this->VerticesRead += *read;
    return read;
  }

  // Goes face by face: a face that names a dropped point is dropped with all its triangles.
  Result<std::size_t> ReadFinitePart(Mesh& mesh, std::size_t limit)
  {
    for (std::size_t done = 0; done < limit; ++done)
    {
      const std::size_t begin = mesh.triangles.size();
      const Result<std::size_t> read = this->Reader->ReadTriangles(mesh, 1);
      KDSTREAM_TRY(read);
      if (*read == 0)
      {
        return done;
      }
      Result<std::vector<bool>> kept = RenumberTriangles(mesh, begin, this->Dropped);
      KDSTREAM_TRY(kept);
      const auto gone = static_cast<std::uint64_t>(std::count(kept->begin(), kept->end(), false));
      if (gone > 0)
      {
        const bool whole = !this->FileInfo.strips; // of strips, only triangles are dropped
        *kept = whole ? std::vector<bool>(kept->size(), false) : std::move(*kept);
        constexpr Lapse kind = Lapse::FaceOfDroppedPoint;
        this->Own.Count(kind, whole ? 1 : gone,
          this->Own.Of(kind) == 0
            ? "face " + std::to_string(this->FacesRead) + this->Reader->LineOfFace()
            : std::string());
        KeepTriangles(mesh, begin, *kept);
      }
      ++this->FacesRead;
    }
    return limit;
  }

  std::unique_ptr<MeshReader> Reader;
  std::string File;
  MeshFileInfo FileInfo; // the wrapped reader's, with our own counts
  Tolerance Own;
  DroppedPoints Dropped;
  std::uint64_t VerticesRead = 0, FacesRead = 0;
};

}

std::unique_ptr<MeshReader> WithFinitePoints(
  std::unique_ptr<MeshReader> reader, std::string file, const std::filesystem::path& scratch)
{
  return std::make_unique<FiniteReader>(std::move(reader), std::move(file), scratch);
}

}
