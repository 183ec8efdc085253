// SPDX-License-Identifier: BSD-3-Clause
#include "filters/app/ReadAnyMesh.h"

#include "filters/app/ConvertedInput.h"
#include "filters/core/Weld.h"
#include "filters/meshio/MeshReader.h"

#include <algorithm>
#include <utility>

namespace kdstream
{
namespace
{

constexpr std::size_t readChunk = std::size_t{ 1 } << 18; // vertices or faces

Result<Mesh> ReadWhole(const std::filesystem::path& file, const Execution& execution)
{
  Result<std::unique_ptr<MeshReader>> opened = MeshReader::Open(file, execution);
  KDSTREAM_TRY(opened);
  MeshReader& reader = **opened;
  Mesh mesh;
  for (const bool triangles : { false, true })
  {
    for (;;)
    {
      const Result<std::size_t> read =
        triangles ? reader.ReadTriangles(mesh, readChunk) : reader.ReadVertices(mesh, readChunk);
      KDSTREAM_TRY(read);
      if (*read == 0)
      {
        break;
      }
      const double size = std::max(1.0, double(reader.FileSize()));
      KDSTREAM_TRY(execution.Report("read", double(reader.Position()) / size));
    }
  }
  if (reader.Info().soup)
  {
    WeldVertices(mesh);
  }
  return mesh;
}

}

Result<Mesh> ReadAnyMesh(const std::string& file, const Execution& execution)
{
  if (!NeedsConversion(file))
  {
    return ReadWhole(file, execution);
  }
  const Result<ConvertedInput> converted =
    ConvertedInput::Make(file, std::filesystem::temp_directory_path(), {}, false, execution);
  KDSTREAM_TRY(converted);
  Result<Mesh> mesh = ReadWhole(converted->File(), execution);
  return mesh ? std::move(mesh) : Result<Mesh>(converted->Blame(mesh.GetError()));
}

}
