// SPDX-License-Identifier: BSD-3-Clause
// Phase "faces": sorts triangles and arrays into blocks of the tree.
#include "filters/build/BuildPhases.h"

#include "filters/build/HubCheck.h"
#include "filters/build/ModelFacts.h"
#include "filters/build/SharedSteps.h"
#include "filters/core/TakeResult.h"
#include "filters/outofcore/mesh/CellTriangles.h"
#include "filters/outofcore/mesh/PlaceCount.h"
#include "filters/outofcore/mesh/RankTuples.h"

#include <algorithm>

namespace kdstream
{
namespace
{

Result<std::uint64_t> CountMerged(ExternalBuildState& build, const MeshBlocks& mesh)
{
  const auto count = [&](const PlaceOfPoint& placeOf)
  {
    const double begin = placeOf ? 0.9 : 0.8; // as fractions of the phase
    return (mesh.floats ? CountPlacesExternally<float>
                        : CountPlacesExternally<double>)(build.Files(), mesh.records,
      mesh.vertexCount, placeOf, build.Memory, build.Part("faces", begin, begin + 0.1));
  };
  return CountMergedByGrid(
    GridOf(build.Options, mesh.box, mesh.scalarType), mesh.vertexCount, mesh.mayCoincide, count);
}

std::uint64_t LargestOf(const MeshBlocks& blocks)
{
  std::uint64_t most = 0;
  for (std::size_t block = 0; block < blocks.BlockCount(); ++block)
  {
    most = std::max(most, blocks.RangeOf(block).size);
  }
  return most;
}

// Takes over the blocks that the phase "faces" has made, maybe with another memory limit.
Status TakeBlocks(
  const ExternalBuildState& build, std::vector<VertexId> begin, std::size_t count, MeshBlocks& mesh)
{
  const std::uint64_t allowed = std::max(LargestOf(mesh), build.MostInBlock);
  mesh.begin = std::move(begin);
  mesh.blockDepth = 0;
  while (std::size_t{ 1 } << mesh.blockDepth < count)
  {
    ++mesh.blockDepth;
  }
  return LargestOf(mesh) <= allowed
           ? Status{}
           : Error{ ErrorCode::LimitExceeded,
               "the interrupted build had more memory than this one: raise --memory, or build "
               "without --resume" };
}

}

Status MakeFaces(ExternalBuildState& build)
{
  MeshFacts facts;
  MeshBlocks mesh;
  KDSTREAM_TRY(LoadMesh(build, facts, mesh));
  VertexMap ranks;
  KDSTREAM_TRY(Take((facts.floats ? RankVertices<float> : RankVertices<double>)(build.Files(),
                      mesh.records, facts.vertices, build.Memory, build.Part("faces", 0, 0.2)),
    ranks));
  SpillFile triangles, tuples;
  KDSTREAM_TRY(Take(build.Folder->TakeFile("mesh", "triangles"), triangles));
  KDSTREAM_TRY(Take(build.Folder->TakeFile("mesh", "tuples"), tuples));
  Result<RecordBuckets<NumberedTriangle>> buckets =
    SortTrianglesIntoCells(build.Files(), triangles, facts.triangles, ranks,
      mesh.begin.empty() ? CellOfRank(facts.vertices, mesh.blockDepth) : CellOfRank(mesh.begin),
      build.Memory, build.Part("faces", 0.2, 0.6));
  KDSTREAM_TRY(buckets);
  KDSTREAM_TRY(CheckHubs(mesh, *buckets, build.Options.memory));
  if (facts.pointTupleBytes > 0)
  {
    KDSTREAM_TRY(Take(SortTuplesByRank(build.Files(), tuples, facts.pointTupleBytes, ranks,
                        build.Memory, build.Part("faces", 0.6, 0.8)),
      mesh.pointTuples));
  }
  std::uint64_t merged = 0;
  KDSTREAM_TRY(Take(CountMerged(build, mesh), merged));
  BlobWriter blob;
  blob.Add(merged);
  blob.AddList(mesh.begin);
  SpillFile bucketFile = buckets->Save(blob);
  build.Clock.Finish("faces");
  PhaseFile files[] = { { "triangles", std::move(bucketFile) },
    { "tuples", std::move(mesh.pointTuples) } };
  return build.Folder->Finish(
    "faces", blob, files, { { "mesh", "triangles" }, { "mesh", "tuples" } });
}

Status LoadBlocks(ExternalBuildState& build, MeshFacts& facts, MeshBlocks& mesh)
{
  KDSTREAM_TRY(LoadMesh(build, facts, mesh));
  BlobReader blob = build.Folder->BlobOf("faces");
  build.Report.mergedByGrid = blob.Read<std::uint64_t>();
  std::vector<VertexId> begin = blob.ReadList<VertexId>();
  SpillFile file;
  KDSTREAM_TRY(Take(build.Folder->TakeFile("faces", "triangles"), file));
  Result<RecordBuckets<NumberedTriangle>> buckets =
    RecordBuckets<NumberedTriangle>::Restore(std::move(file), blob);
  KDSTREAM_TRY(buckets);
  KDSTREAM_TRY(TakeBlocks(build, std::move(begin), buckets->BucketCount(), mesh));
  mesh.triangles.emplace(std::move(*buckets));
  KDSTREAM_TRY(Take(build.Folder->TakeFile("faces", "tuples"), mesh.pointTuples));
  return Take(build.Folder->TakeFile("mesh", "cells"), mesh.cellTuples);
}

}
