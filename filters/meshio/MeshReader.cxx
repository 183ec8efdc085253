// Chooses a mesh reader by the file's name: step "read" of the README's picture.
#include "filters/meshio/MeshReader.h"

#include "filters/meshio/ByteSource.h"
#include "filters/meshio/FileEnding.h"
#include "filters/meshio/PlyReader.h"

#include <algorithm>
#include <array>
#include <utility>

namespace kdstream
{

Result<std::unique_ptr<MeshReader>> MeshReader::Open(const std::filesystem::path& file)
{
  Result<ByteSource> source = ByteSource::Open(file);
  if (!source)
  {
    return source.GetError();
  }
  const std::string ending = FileEnding(file);
  if (ending == ".ply")
  {
    return PlyReader::Open(std::move(*source));
  }
  constexpr std::array<const char*, 9> laterFormats{ ".stl", ".obj", ".vtp", ".vtk", ".wrl", ".glb",
    ".gltf", ".pcd", ".xyz" };
  if (std::find(laterFormats.begin(), laterFormats.end(), ending) != laterFormats.end())
  {
    return Error{ ErrorCode::Unsupported,
      "reading " + ending + " files is not supported yet; convert it to .ply" };
  }
  return Error{ ErrorCode::Unsupported,
    "the ending '" + ending + "' names no known mesh format; convert it to .ply" };
}

}
