// Chooses a mesh reader by the file's name: step "read" of the README's picture.
#include "filters/meshio/MeshReader.h"

#include "filters/meshio/ByteSource.h"
#include "filters/meshio/FileEnding.h"
#include "filters/meshio/ObjReader.h"
#include "filters/meshio/PlyReader.h"
#include "filters/meshio/StlReader.h"

#include <algorithm>
#include <array>
#include <utility>

namespace kdstream
{

Result<std::unique_ptr<MeshReader>> MeshReader::Open(const std::filesystem::path& file,
  const Execution& execution, const std::filesystem::path& scratch)
{
  Result<ByteSource> source = ByteSource::Open(file);
  KDSTREAM_TRY(source);
  const std::string ending = FileEnding(file);
  if (ending == ".ply")
  {
    return PlyReader::Open(std::move(*source));
  }
  if (ending == ".stl")
  {
    return OpenStlReader(std::move(*source), execution);
  }
  if (ending == ".obj")
  {
    return OpenObjReader(std::move(*source), execution, scratch);
  }
  constexpr std::array<const char*, 7> convertedFormats{ ".vtp", ".vtk", ".wrl", ".glb", ".gltf",
    ".pcd", ".xyz" };
  if (std::find(convertedFormats.begin(), convertedFormats.end(), ending) != convertedFormats.end())
  {
    return Error{ ErrorCode::Unsupported,
      ending + " files are not read in chunks; kdstream-convert makes a .ply of them" };
  }
  return Error{ ErrorCode::Unsupported,
    "the ending '" + ending + "' names no known mesh format; convert it to .ply" };
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
