// SPDX-License-Identifier: BSD-3-Clause
#include "filters/build/BuildInput.h"

#include "filters/build/BuildMemory.h"
#include "filters/build/ExternalMethod.h"
#include "filters/build/SharedSteps.h"

#include <algorithm>
#include <string>

namespace kdstream
{
namespace
{

constexpr std::size_t readChunk = std::size_t{ 1 } << 18; // vertices or faces

// What the header claims, if the file is large enough for it: a vertex and a face have at least 3
// bytes. Claims by themselves are not a reason to refuse anything.
MeshSize ClaimedSize(const MeshReader& reader)
{
  const MeshFileInfo& info = reader.Info();
  const std::uint64_t most = reader.FileSize() / 3;
  if (info.vertices > most || info.faces > most)
  {
    return {};
  }
  MeshSize size{ info.vertices, info.faces };
  for (const AttributeInfo& attribute : info.attributes)
  {
    const bool points = attribute.association == AttributeAssociation::Point;
    size.attributeBytes += attribute.TupleSize() * (points ? info.vertices : info.faces);
  }
  size.sumBytes = SumBytesOf(info.attributes);
  return size;
}

}

Result<Mesh> ReadMesh(MeshReader& reader, const BuildOptions& options, const Execution& execution)
{
  Mesh mesh;
  const MeshSize claimed = ClaimedSize(reader);
  const bool weld = options.weld || reader.Info().soup;
  const auto check = [&](MeshSize size)
  {
    size.triangles = std::max(size.triangles, claimed.triangles); // they are read last
    return weld ? CheckUnweldedMemory(size, options.tree, options.memory)
                : CheckBuildMemory(size, options.tree, options.memory);
  };
  KDSTREAM_TRY(check(claimed));
  if (options.memory > 0)
  {
    mesh.points.reserve(claimed.vertices);
    mesh.triangles.reserve(claimed.triangles);
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
      KDSTREAM_TRY(check(SizeOf(mesh)));
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
  const MeshSize claimed = ClaimedSize(reader);
  BlockedSize size{ claimed.vertices, claimed.triangles };
  for (const AttributeInfo& attribute : reader.Info().attributes)
  {
    const bool points = attribute.association == AttributeAssociation::Point;
    (points ? size.pointTupleBytes : size.cellTupleBytes) += attribute.TupleSize();
  }
  return size;
}

Status CheckClaimedPartitions(
  const MeshReader& reader, const BuildOptions& options, bool mayBeWhole)
{
  const BlockedSize claimed = ClaimedBlocks(reader);
  // Unshared vertices of triangles become far fewer by welding, and vertices may be unused: they
  // count only when their number is known.
  const bool indexed = claimed.triangles == 0 || claimed.vertices <= claimed.triangles;
  if (reader.Info().soup || !indexed || claimed.vertices == 0)
  {
    return {};
  }
  const Result<const ExternalMethod*> method = options.partitioner->External();
  KDSTREAM_TRY(method);
  return (*method)->CheckPartitions(claimed, options, mayBeWhole);
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
