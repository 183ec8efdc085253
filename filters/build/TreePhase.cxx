// SPDX-License-Identifier: BSD-3-Clause
// Phase "tree": puts the vertices into the order of the partitions, and computes the boxes of the
// nodes.
#include "filters/build/BuildPhases.h"

#include "filters/build/ExternalMethod.h"
#include "filters/build/ModelFacts.h"
#include "filters/core/TakeResult.h"
#include "filters/core/VectorMath.h"
#include "filters/core/tree/PointRecord.h"
#include "filters/outofcore/files/BatchPass.h"
#include "filters/outofcore/files/MemoryPlan.h"

#include <algorithm>

namespace kdstream
{
namespace
{

template <class Scalar>
Result<SpillFile> RecordsOf(
  ExternalBuildState& build, const SpillFile& points, std::uint32_t count, bool& negativeZeros)
{
  Result<SpillFile> records =
    build.Files().CreateFile("vertices", count * std::uint64_t{ sizeof(PointRecord<Scalar>) });
  KDSTREAM_TRY(records);
  struct Slot
  {
    std::vector<PointRecord<Scalar>> records;
    bool negativeZeros = false;
  };
  const BatchShape shape = ShapeOfPass(build.Memory / 8, sizeof(Vec3));
  std::vector<Slot> slots(shape.slots);
  BatchPass<Vec3> batches(shape, build.Exec);
  KDSTREAM_TRY(batches.Over(
    points, 0, count,
    [&](std::size_t i, std::span<Vec3> block, std::uint64_t first)
    {
      Slot& slot = slots[i];
      slot.records.clear();
      auto id = static_cast<VertexId>(first);
      for (const Vec3& p : block)
      {
        slot.negativeZeros |= HasNegativeZero(p);
        slot.records.push_back({ { Scalar(p[0]), Scalar(p[1]), Scalar(p[2]) }, id++ });
      }
      return WriteRecords<PointRecord<Scalar>>(
        *records, first, std::span<const PointRecord<Scalar>>(slot.records));
    },
    [](std::size_t, std::uint64_t) { return Status{}; }));
  negativeZeros =
    std::any_of(slots.begin(), slots.end(), [](const Slot& slot) { return slot.negativeZeros; });
  return std::move(*records);
}

template <class Scalar>
Status MakeTreeOf(ExternalBuildState& build, const MeshFacts& facts)
{
  SpillFile points, records;
  bool negativeZeros = false;
  if (facts.vertices == 0)
  {
    return Error{ ErrorCode::InvalidInput, "the mesh has no vertices" };
  }
  KDSTREAM_TRY(Take(build.Folder->TakeFile("mesh", "points"), points));
  KDSTREAM_TRY(Take(RecordsOf<Scalar>(build, points, facts.vertices, negativeZeros), records));
  ExternalPartitions tree;
  const Result<const ExternalMethod*> method = build.Options.partitioner->External();
  KDSTREAM_TRY(method);
  KDSTREAM_TRY(Take((*method)->Partition(build, facts, records), tree));
  build.Clock.Finish("tree");
  BlobWriter blob;
  blob.Add(tree.depths);
  blob.AddList(tree.boxes);
  blob.Add((tree.recordsRead + facts.vertices - 1) / facts.vertices);
  blob.Add(negativeZeros);
  blob.AddList(tree.begin);
  PhaseFile files[] = { { "records", std::move(tree.records) } };
  return build.Folder->Finish("tree", blob, files, { { "mesh", "points" } });
}

}

Status MakeTree(ExternalBuildState& build)
{
  MeshFacts facts;
  KDSTREAM_TRY(Take(LoadFacts(build), facts));
  return facts.floats ? MakeTreeOf<float>(build, facts) : MakeTreeOf<double>(build, facts);
}

Status LoadMesh(ExternalBuildState& build, MeshFacts& facts, MeshBlocks& mesh)
{
  KDSTREAM_TRY(Take(LoadFacts(build), facts));
  BlobReader blob = build.Folder->BlobOf("tree");
  mesh.depths = blob.Read<TreeDepths>();
  build.Boxes = blob.ReadList<Box>();
  build.Report.passes = 1 + blob.Read<std::uint64_t>();
  const auto negativeZeros = blob.Read<bool>();
  build.PartitionBegin = blob.ReadList<VertexId>();
  KDSTREAM_TRY(blob.Finish());
  if (build.Boxes.size() < 2)
  {
    return Error{ ErrorCode::Damaged, "the tree of the interrupted build has no boxes" };
  }
  KDSTREAM_TRY(Take(build.Folder->TakeFile("tree", "records"), mesh.records));
  mesh.vertexCount = facts.vertices;
  mesh.triangleCount = facts.triangles;
  mesh.box = build.Boxes[1];
  mesh.floats = facts.floats;
  mesh.scalarType = facts.scalarType;
  mesh.attributes = facts.attributes;
  mesh.mayCoincide = negativeZeros || !WeldingSeparates(facts.weld, facts.attributes);
  mesh.keptMemory = KeptMemory(build.Memory);
  const Result<const ExternalMethod*> method = build.Options.partitioner->External();
  KDSTREAM_TRY(method);
  return (*method)->PlanBlocks(build, facts, mesh);
}

}
