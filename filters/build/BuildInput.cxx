// SPDX-License-Identifier: BSD-3-Clause
#include "filters/build/BuildInput.h"

#include "filters/build/BuildMemory.h"
#include "filters/build/ExternalMethod.h"
#include "filters/build/SharedSteps.h"
#include "filters/core/levels/CellComponents.h"

#include <algorithm>
#include <string>

namespace kdstream
{
namespace
{

constexpr std::size_t readChunk = std::size_t{ 1 } << 18; // vertices or faces

constexpr std::uint64_t leastBytes = 3; // minimum for a vertex or a face in a file

// Upper bounds of the mesh's size, from the header and the file's size.
MeshSize MostSize(const MeshReader& reader)
{
  const MeshFileInfo& info = reader.Info();
  MeshSize size{ std::min(info.vertices, reader.FileSize() / leastBytes), info.mostTriangles };
  for (const AttributeInfo& attribute : info.attributes)
  {
    const bool points = attribute.association == AttributeAssociation::Point;
    size.attributeBytes += attribute.TupleSize() * (points ? size.vertices : size.triangles);
  }
  size.sumBytes = SumBytesOf(info.attributes);
  return size;
}

}

Status CheckInputMemory(const MeshReader& reader, const BuildOptions& options)
{
  const bool isByComponents = options.partitioner->HasLevels() && options.levels.byComponents;
  return CheckBuildMemory(
    MostSize(reader), options.tree, isByComponents ? mostCellComponents : 1, options.memory);
}

Result<Mesh> ReadMesh(MeshReader& reader, const BuildOptions& options, const Execution& execution)
{
  Mesh mesh;
  if (options.memory > 0)
  {
    const MeshSize most = MostSize(reader);
    mesh.points.reserve(most.vertices);
    mesh.triangles.reserve(std::min(most.triangles, reader.Info().faces));
  }
  for (const bool triangles : { false, true })
  {
    for (std::size_t count = 1; count > 0;)
    {
      const Result<std::size_t> read =
        triangles ? reader.ReadFaces(mesh, readChunk) : reader.ReadVertices(mesh, readChunk);
      KDSTREAM_TRY(read);
      count = *read;
      KDSTREAM_TRY(reader.Info().tolerance.Check(options.strict));
      const double size = std::max(1.0, double(reader.FileSize()));
      KDSTREAM_TRY(execution.Report("read", double(reader.Position()) / size));
    }
  }
  if (mesh.triangles.size() >= noVertex)
  {
    return Error{ ErrorCode::LimitExceeded,
      std::to_string(mesh.triangles.size()) +
        " triangles; at most 4294967294 fit a build in memory" };
  }
  return mesh;
}

BlockedSize ClaimedBlocks(const MeshReader& reader)
{
  const MeshFileInfo& info = reader.Info();
  if (std::max(info.vertices, info.faces) > reader.FileSize() / leastBytes)
  {
    return {}; // nothing is refused only because of a claim
  }
  BlockedSize size{ info.vertices, info.faces };
  for (const AttributeInfo& attribute : info.attributes)
  {
    const bool points = attribute.association == AttributeAssociation::Point;
    (points ? size.pointTupleBytes : size.cellTupleBytes) += attribute.TupleSize();
  }
  return size;
}

Status CheckClaimedPartitions(const MeshReader& reader, const BuildOptions& options)
{
  const BlockedSize claimed = ClaimedBlocks(reader);
  // Unshared vertices of triangles become far fewer by welding, and vertices may be unused. So
  // vertices count only if the number that remains is known.
  const bool indexed = claimed.triangles == 0 || claimed.vertices <= claimed.triangles;
  if (reader.Info().soup || !indexed || claimed.vertices == 0)
  {
    return {};
  }
  const Result<const ExternalMethod*> method = options.partitioner->External();
  KDSTREAM_TRY(method);
  return (*method)->CheckPartitions(claimed, options);
}

Status PrepareMesh(Mesh& mesh)
{
  if (mesh.points.empty())
  {
    return BadInput("the mesh has no vertices", Remedy::Repair);
  }
  KDSTREAM_TRY(CheckAttributes(mesh.attributes, mesh.points.size(), mesh.triangles.size()));
  std::vector<AttributeInfo> infos;
  for (const Attribute& attribute : mesh.attributes)
  {
    infos.push_back(attribute.Info());
  }
  KDSTREAM_TRY(CheckAttributeNames(infos));
  std::stable_partition(mesh.attributes.begin(), mesh.attributes.end(),
    [](const Attribute& attribute)
    { return attribute.association == AttributeAssociation::Point; });
  return {};
}

}
