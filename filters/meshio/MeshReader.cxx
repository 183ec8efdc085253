// SPDX-License-Identifier: BSD-3-Clause
// Chooses a mesh reader by the file's name: step "read" of the pipeline picture.
#include "filters/meshio/MeshReader.h"

#include "filters/core/Weld.h"
#include "filters/meshio/ByteSource.h"
#include "filters/meshio/ContentFormat.h"
#include "filters/meshio/FileEnding.h"
#include "filters/meshio/FiniteReader.h"
#include "filters/meshio/ObjReader.h"
#include "filters/meshio/ShownColors.h"
#include "filters/meshio/StlReader.h"
#include "filters/meshio/ply/OffHeader.h"
#include "filters/meshio/ply/PlyReader.h"

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>

namespace kdstream
{

namespace
{

Result<std::unique_ptr<MeshReader>> OpenByEnding(const std::string& ending, ByteSource source,
  const Execution& execution, const std::filesystem::path& scratch)
{
  if (ending == ".ply")
  {
    return PlyReader::Open(std::move(source), scratch);
  }
  if (ending == ".stl")
  {
    return OpenStlReader(std::move(source), execution);
  }
  if (ending == ".obj")
  {
    return OpenObjReader(std::move(source), execution, scratch);
  }
  if (ending == ".off")
  {
    return OpenOffReader(std::move(source), execution, scratch);
  }
  if (IsConvertedFormat(ending))
  {
    return Error{ ErrorCode::Unsupported,
      ending + " files are not read in chunks; kdstream-convert makes a .ply of them", {}, {},
      Remedy::InMessage };
  }
  return Error{ ErrorCode::Unsupported, UnknownEndingHint(source, ending), {}, {},
    Remedy::InMessage };
}

}

namespace
{

Result<std::unique_ptr<MeshReader>> OpenFinite(const std::filesystem::path& file,
  const Execution& execution, const std::filesystem::path& scratch)
{
  Result<ByteSource> source = OfFile(file.string(), ByteSource::Open(file));
  KDSTREAM_TRY(source);
  const std::string ending = FileEnding(file);
  const std::string hint = OtherFormatHint(*source, ending);
  auto reader =
    OfInput(OfFile(file.string(), OpenByEnding(ending, std::move(*source), execution, scratch)));
  const bool unreadable =
    reader ? (*reader)->Info().vertices == 0 : reader.GetError().code == ErrorCode::InvalidInput;
  // An archive may hold an uncompressed mesh, and could then be read as if it were that mesh.
  const bool isPacked = hint.starts_with("is compressed (.zip)");
  if (!hint.empty() && (unreadable || isPacked))
  {
    return OfFile(file.string(), Status(BadInput(hint, Remedy::InMessage))).GetError();
  }
  KDSTREAM_TRY(reader);
  return WithFinitePoints(std::move(*reader), file.string(), scratch);
}

}

Result<std::unique_ptr<MeshReader>> MeshReader::Open(const std::filesystem::path& file,
  const Execution& execution, const std::filesystem::path& scratch)
{
  Result<std::unique_ptr<MeshReader>> reader = OpenFinite(file, execution, scratch);
  KDSTREAM_TRY(reader);
  std::optional<HiddenColors> colors = FindHiddenColors((*reader)->Info().attributes);
  if (!colors || (colors->bytes && FileEnding(file) != ".ply")) // others convert numbers to bytes
  {
    return reader;
  }
  // Which value is white is known only after all vertices have been read; for bytes, mostly after
  // the first chunk.
  ColorScale scale(std::move(*colors));
  for (std::size_t count = 1; count > 0 && !scale.AreUsual();)
  {
    constexpr std::size_t verticesAtOnce = std::size_t{ 1 } << 16;
    Mesh some;
    const Result<std::size_t> read = (*reader)->ReadVertices(some, verticesAtOnce);
    KDSTREAM_TRY(read);
    count = *read;
    scale.LookAt(some.attributes, 0);
    const double size = std::max(1.0, double((*reader)->FileSize()));
    KDSTREAM_TRY(execution.Report("read", double((*reader)->Position()) / size));
  }
  reader = OpenFinite(file, execution, scratch);
  KDSTREAM_TRY(reader);
  return scale.AreUsual() ? std::move(reader)
                          : WithShownColors(std::move(*reader), std::move(scale));
}

namespace
{

constexpr std::uint64_t droppedAtOnce = std::uint64_t{ 1 } << 15; // elements

// read(mesh, limit) has the contract of ReadVertices.
template <class Read>
Result<std::uint64_t> ReadAndDrop(std::uint64_t count, const Read& read)
{
  std::uint64_t done = 0;
  while (done < count)
  {
    Mesh dropped;
    const Result<std::size_t> some =
      read(dropped, static_cast<std::size_t>(std::min(droppedAtOnce, count - done)));
    KDSTREAM_TRY(some);
    if (*some == 0)
    {
      break;
    }
    done += *some;
  }
  return done;
}

}

Status MeshReader::ReadRest(Mesh& mesh, const Execution& execution)
{
  constexpr std::size_t chunk = std::size_t{ 1 } << 18; // vertices or faces
  for (const bool triangles : { false, true })
  {
    for (;;)
    {
      const Result<std::size_t> read =
        triangles ? this->ReadTriangles(mesh, chunk) : this->ReadVertices(mesh, chunk);
      KDSTREAM_TRY(read);
      if (*read == 0)
      {
        break;
      }
      const double size = std::max(1.0, double(this->FileSize()));
      KDSTREAM_TRY(execution.Report("read", double(this->Position()) / size));
    }
  }
  if (this->Info().soup)
  {
    WeldVertices(mesh);
  }
  return {};
}

Result<std::size_t> MeshReader::ReadFaces(Mesh& mesh, std::size_t mostTriangles)
{
  const std::size_t begin = mesh.triangles.size();
  std::size_t faces = 0, atOnce = 256, ofFace = 1; // ofFace: most triangles of one face
  for (std::size_t made = 0; faces < mostTriangles && made < mostTriangles;
       made = mesh.triangles.size() - begin)
  {
    const std::size_t room =
      std::min((mostTriangles - made) / ofFace, std::min(atOnce, mostTriangles - faces));
    const Result<std::size_t> read = this->ReadTriangles(mesh, std::max<std::size_t>(1, room));
    KDSTREAM_TRY(read);
    if (*read == 0)
    {
      break;
    }
    faces += *read;
    ofFace = std::max(ofFace, (mesh.triangles.size() - begin - made) / *read);
    atOnce *= 2;
  }
  return faces;
}

Result<std::uint64_t> MeshReader::PassVertices(std::uint64_t count)
{
  return ReadAndDrop(
    count, [this](Mesh& mesh, std::size_t limit) { return this->ReadVertices(mesh, limit); });
}

Result<std::uint64_t> MeshReader::PassFaces(std::uint64_t count)
{
  return ReadAndDrop(
    count, [this](Mesh& mesh, std::size_t limit) { return this->ReadTriangles(mesh, limit); });
}

Result<std::uint64_t> MeshReader::SkipVertices(std::uint64_t count)
{
  return this->PassVertices(count);
}

Result<std::uint64_t> MeshReader::SkipFaces(std::uint64_t count)
{
  return this->PassFaces(count);
}

}
