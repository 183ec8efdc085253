// Phase "mesh": the file in chunks, what the build must know of it, and welding.
#include "filters/build/MeshPhase.h"

#include "filters/build/BuildInput.h"
#include "filters/build/BuildMemory.h"
#include "filters/core/TakeResult.h"
#include "filters/meshio/MeshReader.h"
#include "filters/outofcore/mesh/MeshSpill.h"

#include <algorithm>

namespace kdstream
{
namespace
{

Status Weld(ExternalBuildState& build, SpilledMesh& mesh, MeshFacts& facts)
{
  ExternalWeld welded;
  Status status = Take(WeldExternally(build.Files(), std::move(mesh.vertices), build.Memory,
                         build.Part("tree", 0, 0.4)),
    welded);
  KDSTREAM_TRY(status);
  mesh.vertices = std::move(welded.vertices);
  facts.welded = welded.welded;
  if (!welded.map)
  {
    return {};
  }
  SpillFile renumbered;
  status = Take(build.Files().CreateFile(
                  "triangles", std::uint64_t{ mesh.triangleCount } * sizeof(NumberedTriangle)),
    renumbered);
  KDSTREAM_TRY(status);
  std::uint64_t written = 0;
  status = MapTriangles(build.Files(), mesh.triangles, mesh.triangleCount, *welded.map,
    build.Memory, build.Part("tree", 0.4, 0.5),
    [&](std::span<const NumberedTriangle> triangles)
    {
      const Status done = WriteRecords<NumberedTriangle>(renumbered, written, triangles);
      written += triangles.size();
      return done;
    });
  mesh.triangles = std::move(renumbered);
  return status;
}

}

Status MakeMesh(ExternalBuildState& build)
{
  const Execution opening = build.Part("read", 0, 0.5); // some formats are read twice
  Result<std::unique_ptr<MeshReader>> reader =
    MeshReader::Open(build.Input, opening, build.Files().Path());
  KDSTREAM_TRY(reader);
  KDSTREAM_TRY(CheckClaimedPartitions(**reader, build.Options));
  build.Files().Expect(EstimateTemporaryBytes(
    ClaimedBlocks(**reader), (*reader)->Info().soup, (*reader)->Info().scalarType));
  const std::size_t chunk =
    static_cast<std::size_t>(std::min<std::uint64_t>(build.Memory / 16, std::uint64_t{ 8 } << 20));
  SpilledMesh mesh;
  Status status =
    Take(SpillMesh(build.Files(), **reader, chunk, build.Part("read", build.StepDone, 1)), mesh);
  KDSTREAM_TRY(status);
  build.Clock.Finish("read");
  MeshFacts facts;
  facts.triangles = mesh.triangleCount;
  facts.pointTupleBytes = mesh.vertices.tupleBytes;
  facts.cellTupleBytes = mesh.cellTupleBytes;
  facts.scalarType = mesh.scalarType;
  facts.floats = mesh.fitFloats;
  facts.attributes = mesh.attributes;
  facts.ignored = (*reader)->Info().ignoredAttributes;
  facts.weld = build.Options.weld || (*reader)->Info().soup;
  for (const AttributeInfo& attribute : facts.attributes)
  {
    if (!IsAttributeName(attribute.name))
    {
      return Error{ ErrorCode::InvalidInput, "an attribute has a name that is no text" };
    }
  }
  if (facts.weld)
  {
    status = Weld(build, mesh, facts);
  }
  facts.vertices = mesh.vertices.count;
  build.Clock.Finish("tree");
  KDSTREAM_TRY(status);
  BlobWriter blob;
  Save(blob, facts);
  PhaseFile files[] = { { "points", std::move(mesh.vertices.points) },
    { "tuples", std::move(mesh.vertices.tuples) }, { "triangles", std::move(mesh.triangles) },
    { "cells", std::move(mesh.cellTuples) } };
  return build.Folder->Finish("mesh", blob, files);
}

BlockedSize BlockedSizeOf(const MeshFacts& facts)
{
  return { facts.vertices, facts.triangles, facts.pointTupleBytes, facts.cellTupleBytes };
}

Result<MeshFacts> LoadFacts(const ExternalBuildState& build)
{
  BlobReader blob = build.Folder->BlobOf("mesh");
  MeshFacts facts = LoadMeshFacts(blob);
  Status status = blob.Finish();
  if (status && build.Options.partitioner == Partitioner::KdTree)
  {
    status = CheckPartitionMemory(BlockedSizeOf(facts), build.Options.tree, build.Options.memory);
  }
  KDSTREAM_TRY(status);
  return facts;
}

}
