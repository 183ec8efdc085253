// SPDX-License-Identifier: BSD-3-Clause
// Chooses a mesh reader by the file's name: step "read" of the README's picture.
#include "filters/meshio/MeshReader.h"

#include "filters/meshio/ByteSource.h"
#include "filters/meshio/ContentFormat.h"
#include "filters/meshio/FileEnding.h"
#include "filters/meshio/ObjReader.h"
#include "filters/meshio/PlyReader.h"
#include "filters/meshio/StlReader.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

namespace kdstream
{

namespace
{

// A reader whose errors name the file.
class NamedReader : public MeshReader
{
public:
  NamedReader(std::unique_ptr<MeshReader> reader, std::string file)
    : Reader(std::move(reader))
    , File(std::move(file))
  {
  }

  const MeshFileInfo& Info() const override { return this->Reader->Info(); }
  Result<std::size_t> ReadVertices(Mesh& mesh, std::size_t limit) override
  {
    return OfFile(this->File, this->Reader->ReadVertices(mesh, limit));
  }
  Result<std::size_t> ReadTriangles(Mesh& mesh, std::size_t limit) override
  {
    return OfFile(this->File, this->Reader->ReadTriangles(mesh, limit));
  }
  Result<std::uint64_t> SkipVertices(std::uint64_t count) override
  {
    return OfFile(this->File, this->Reader->SkipVertices(count));
  }
  Result<std::uint64_t> SkipFaces(std::uint64_t count) override
  {
    return OfFile(this->File, this->Reader->SkipFaces(count));
  }
  std::uint64_t FileSize() const override { return this->Reader->FileSize(); }
  std::uint64_t Position() const override { return this->Reader->Position(); }

private:
  std::unique_ptr<MeshReader> Reader;
  std::string File;
};

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
  constexpr std::array<const char*, 9> convertedFormats{ ".vtp", ".vtk", ".wrl", ".glb", ".gltf",
    ".pcd", ".xyz", ".las", ".laz" };
  if (std::find(convertedFormats.begin(), convertedFormats.end(), ending) != convertedFormats.end())
  {
    return Error{ ErrorCode::Unsupported,
      ending + " files are not read in chunks; kdstream-convert makes a .ply of them" };
  }
  return Error{ ErrorCode::Unsupported,
    "the ending '" + ending + "' names no known mesh format; convert it to .ply" };
}

}

Result<std::unique_ptr<MeshReader>> MeshReader::Open(const std::filesystem::path& file,
  const Execution& execution, const std::filesystem::path& scratch)
{
  Result<ByteSource> source = OfFile(file.string(), ByteSource::Open(file));
  KDSTREAM_TRY(source);
  const std::string ending = FileEnding(file);
  const Result<std::string_view> begin = source->Peek(contentFormatBytes);
  const std::string hint = begin ? OtherFormatHint(*begin, ending) : std::string();
  auto reader = OfFile(file.string(), OpenByEnding(ending, std::move(*source), execution, scratch));
  const bool unreadable =
    reader ? (*reader)->Info().vertices == 0 : reader.GetError().code == ErrorCode::InvalidInput;
  if (!hint.empty() && unreadable)
  {
    return Error{ ErrorCode::InvalidInput, hint, file.string() };
  }
  KDSTREAM_TRY(reader);
  return std::unique_ptr<MeshReader>(
    std::make_unique<NamedReader>(std::move(*reader), file.string()));
}

namespace
{

constexpr std::uint64_t droppedAtOnce = std::uint64_t{ 1 } << 15; // elements

// read(mesh, limit): as ReadVertices.
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

Result<std::uint64_t> MeshReader::SkipVertices(std::uint64_t count)
{
  return ReadAndDrop(
    count, [this](Mesh& mesh, std::size_t limit) { return this->ReadVertices(mesh, limit); });
}

Result<std::uint64_t> MeshReader::SkipFaces(std::uint64_t count)
{
  return ReadAndDrop(
    count, [this](Mesh& mesh, std::size_t limit) { return this->ReadTriangles(mesh, limit); });
}

}
