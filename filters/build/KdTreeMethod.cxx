// SPDX-License-Identifier: BSD-3-Clause
// The k-d tree as a partition method, in memory and out of core. Out of core it adds the phases
// "levels", block by block, and "numbers", of clusters and vertices.
#include "filters/build/BuildPhases.h"
#include "filters/build/ExternalMethod.h"
#include "filters/build/PartitionMethod.h"
#include "filters/build/SharedSteps.h"
#include "filters/core/TakeResult.h"
#include "filters/outofcore/levels/LevelGeometricErrors.h"
#include "filters/outofcore/tree/ExternalTree.h"

#include <memory>
#include <utility>

namespace kdstream
{
namespace
{

template <class Scalar>
Result<ExternalPartitions> MakeKdTree(
  ExternalBuildState& build, std::uint64_t vertices, SpillFile& records)
{
  ExternalPartitions result;
  KDSTREAM_TRY(Take(ComputeDepths(vertices, build.Options.tree), result.depths));
  ExternalTreeOptions options;
  options.memory = build.Memory;
  options.median = build.Options.median;
  Result<ExternalTree> tree = BuildExternalTree<Scalar>(
    build.Files(), records, result.depths, options, build.Part("tree", 0.5, 1));
  KDSTREAM_TRY(tree);
  result.boxes = std::move(tree->boxes);
  result.records = std::move(tree->records);
  result.recordsRead = vertices; // each is read into memory at least once
  for (const ExternalDepthStatistics& depth : tree->statistics.depths)
  {
    result.recordsRead += depth.records + depth.medianRecords;
  }
  return result;
}

Status MakeLevels(ExternalBuildState& build)
{
  MeshFacts facts;
  MeshBlocks mesh;
  KDSTREAM_TRY(LoadBlocks(build, facts, mesh));
  std::uint64_t inconsistent = 0;
  ExternalLevels levels;
  KDSTREAM_TRY(Take(
    BuildExternalLevels(build.Files(), mesh, build.Options.levels, build.Part("levels", 0, 0.8),
      [&](const TreeBlock& block) { inconsistent += CountInconsistentEdges(block, build.Exec); }),
    levels));
  build.Clock.Finish("levels");
  BlobWriter blob;
  blob.Add(inconsistent);
  std::vector<PhaseFile> files;
  Save(blob, files, std::move(levels));
  return build.Folder->Finish("levels", blob, files);
}

// Loads the mesh and its levels after the phase "levels".
Status LoadLevels(ExternalBuildState& build, MeshFacts& facts, MeshBlocks& mesh,
  ExternalLevels& levels, std::uint64_t& inconsistent)
{
  KDSTREAM_TRY(LoadBlocks(build, facts, mesh));
  BlobReader blob = build.Folder->BlobOf("levels");
  inconsistent = blob.Read<std::uint64_t>();
  return Take(LoadExternalLevels(blob, *build.Folder, "levels"), levels);
}

Status MakeNumbers(ExternalBuildState& build)
{
  MeshFacts facts;
  MeshBlocks mesh;
  ExternalLevels levels;
  ExternalNumbers numbers;
  std::uint64_t inconsistent = 0;
  KDSTREAM_TRY(LoadLevels(build, facts, mesh, levels, inconsistent));
  KDSTREAM_TRY(
    Take(NumberExternally(build.Files(), mesh, levels, build.Part("levels", 0.8, 1)), numbers));
  build.Clock.Finish("levels");
  BlobWriter blob;
  std::vector<PhaseFile> files;
  Save(blob, files, std::move(numbers));
  return build.Folder->Finish("numbers", blob, files);
}

class ExternalKdTree : public ExternalMethod
{
public:
  Status CheckPartitions(const BlockedSize& size, const BuildOptions& options) const override
  {
    return CheckPartitionMemory(size, options.tree, options.memory);
  }
  Result<ExternalPartitions> Partition(
    ExternalBuildState& build, const MeshFacts& facts, SpillFile& records) const override
  {
    return (facts.floats ? MakeKdTree<float> : MakeKdTree<double>)(build, facts.vertices, records);
  }
  Status PlanBlocks(
    ExternalBuildState& build, const MeshFacts& facts, MeshBlocks& mesh) const override
  {
    mesh.blockDepth = DepthOfBlocks(BlockedSizeOf(facts), build.Memory, 0, mesh.depths.partition);
    return {};
  }
  std::vector<BuildPhase> PhasesAfterFaces() const override
  {
    return { { "levels", "levels", MakeLevels }, { "numbers", "levels", MakeNumbers } };
  }
  Result<StoreParts> LoadParts(
    ExternalBuildState& build, MeshFacts& facts, MeshBlocks& mesh) const override
  {
    struct Made
    {
      ExternalLevels levels;
      ExternalNumbers numbers;
    };
    const auto made = std::make_shared<Made>();
    StoreParts parts;
    KDSTREAM_TRY(LoadLevels(build, facts, mesh, made->levels, parts.inconsistentEdges));
    BlobReader blob = build.Folder->BlobOf("numbers");
    KDSTREAM_TRY(Take(LoadExternalNumbers(blob, *build.Folder, "numbers"), made->numbers));
    KDSTREAM_TRY(Take(GeometricErrorsOfLevels(made->levels, mesh.depths), parts.geometricErrors));
    parts.forEach = [&build, &mesh, made](
                      const PartVisit& visit, const std::function<Status(Resolution)>& finished) {
      return ForEachPart(mesh, made->levels, made->numbers, visit, build.Exec, nullptr, finished);
    };
    return parts;
  }
};

class InKdTree : public PartitionMethod
{
public:
  std::string_view Name() const override { return "kdtree"; }
  bool HasLevels() const override { return true; }
  Result<PartitionTree> Partition(
    const Mesh& mesh, const KdTreeOptions& options, const Execution& execution) const override
  {
    Result<KdTree> tree = BuildKdTree(mesh.points, options, execution);
    KDSTREAM_TRY(tree);
    const std::uint64_t partitions = std::uint64_t{ 1 } << tree->depths.partition;
    return PartitionTree{ std::move(*tree), partitions };
  }
  Result<const ExternalMethod*> External() const override
  {
    static const ExternalKdTree external;
    return &external;
  }
};

}

const PartitionMethod& KdTreeMethod()
{
  static const InKdTree method;
  return method;
}

}
