// SPDX-License-Identifier: BSD-3-Clause
// Phase "mesh": reads the file in chunks, collects facts for the build, welds, and sets aside
// vertices that no triangle uses.
#include "filters/build/BuildPhases.h"

#include "filters/build/BuildInput.h"
#include "filters/build/ExternalMethod.h"
#include "filters/build/SharedSteps.h"
#include "filters/core/TakeResult.h"
#include "filters/meshio/MeshReader.h"
#include "filters/outofcore/mesh/ExternalUnused.h"
#include "filters/outofcore/mesh/MeshSpill.h"

namespace kdstream
{
namespace
{

Status Renumber(
  ExternalBuildState& build, SpilledMesh& mesh, const VertexMap& map, const Execution& execution)
{
  SpillFile renumbered;
  KDSTREAM_TRY(Take(build.Files().CreateFile(
                      "triangles", std::uint64_t{ mesh.triangleCount } * sizeof(NumberedTriangle)),
    renumbered));
  std::uint64_t written = 0;
  KDSTREAM_TRY(
    MapTriangles(build.Files(), mesh.triangles, mesh.triangleCount, map, build.Memory, execution,
      [&](std::span<const NumberedTriangle> triangles)
      {
        const std::uint64_t at = written;
        written += triangles.size();
        return WriteRecords<NumberedTriangle>(renumbered, at, triangles);
      }));
  mesh.triangles = std::move(renumbered);
  return {};
}

Status Weld(ExternalBuildState& build, SpilledMesh& mesh, MeshFacts& facts)
{
  ExternalWeld welded;
  KDSTREAM_TRY(Take(WeldExternally(build.Files(), std::move(mesh.vertices), build.Memory,
                      build.Part("tree", 0, 0.4)),
    welded));
  mesh.vertices = std::move(welded.vertices);
  facts.welded = welded.welded;
  return welded.map ? Renumber(build, mesh, *welded.map, build.Part("tree", 0.4, 0.45)) : Status{};
}

// Moves vertices that no triangle uses to other files.
Status SetUnusedAside(
  ExternalBuildState& build, SpilledMesh& mesh, MeshFacts& facts, VertexFiles& unused)
{
  PartedVertices parted;
  KDSTREAM_TRY(Take(PartUnusedExternally(build.Files(), std::move(mesh.vertices), mesh.triangles,
                      mesh.triangleCount, build.Memory, build.Part("tree", 0.45, 0.47)),
    parted));
  mesh.vertices = std::move(parted.used);
  unused = std::move(parted.unused);
  facts.unused = unused.count;
  return parted.map ? Renumber(build, mesh, *parted.map, build.Part("tree", 0.47, 0.5)) : Status{};
}

}

Status MakeMesh(ExternalBuildState& build)
{
  std::unique_ptr<MeshReader> reader = std::move(build.Reader);
  if (!reader)
  {
    const Execution opening = build.Part("read", 0, 0.5); // some formats are read twice
    KDSTREAM_TRY(Take(MeshReader::Open(build.Input, opening, build.Files().Path()), reader));
  }
  KDSTREAM_TRY(CheckClaimedPartitions(*reader, build.Options));
  build.Files().Expect(
    EstimateTemporaryBytes(ClaimedBlocks(*reader), reader->Info().soup, reader->Info().scalarType));
  SpilledMesh mesh;
  KDSTREAM_TRY(Take(SpillMesh(build.Files(), *reader, ChunkOfRead(build.Memory),
                      build.Part("read", build.StepDone, 1)),
    mesh));
  build.Clock.Finish("read");
  KDSTREAM_TRY(reader->Info().tolerance.Check(build.Options.strict));
  MeshFacts facts;
  facts.triangles = mesh.triangleCount;
  facts.pointTupleBytes = mesh.vertices.tupleBytes;
  facts.cellTupleBytes = mesh.cellTupleBytes;
  facts.scalarType = mesh.scalarType;
  facts.floats = mesh.fitFloats;
  facts.attributes = mesh.attributes;
  facts.ignored = reader->Info().ignoredAttributes;
  facts.tolerance = reader->Info().tolerance;
  facts.weld = build.Options.weld || reader->Info().soup;
  KDSTREAM_TRY(CheckAttributeNames(facts.attributes));
  if (facts.weld)
  {
    KDSTREAM_TRY(Weld(build, mesh, facts));
  }
  VertexFiles unused;
  if (!reader->Info().soup && mesh.triangleCount > 0)
  {
    KDSTREAM_TRY(SetUnusedAside(build, mesh, facts, unused));
  }
  facts.vertices = mesh.vertices.count;
  build.Options.tellSize(facts.vertices, facts.triangles);
  build.Clock.Finish("tree");
  BlobWriter blob;
  Save(blob, facts);
  PhaseFile files[] = { { "points", std::move(mesh.vertices.points) },
    { "tuples", std::move(mesh.vertices.tuples) }, { "triangles", std::move(mesh.triangles) },
    { "cells", std::move(mesh.cellTuples) }, { "unused points", std::move(unused.points) },
    { "unused tuples", std::move(unused.tuples) } };
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
  KDSTREAM_TRY(blob.Finish());
  // A resumed build may be strict, even if the interrupted one was not.
  KDSTREAM_TRY(facts.tolerance.Check(build.Options.strict));
  const Result<const ExternalMethod*> method = build.Options.partitioner->External();
  KDSTREAM_TRY(method);
  KDSTREAM_TRY((*method)->CheckPartitions(BlockedSizeOf(facts), build.Options));
  return facts;
}

}
