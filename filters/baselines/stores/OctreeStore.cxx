// SPDX-License-Identifier: BSD-3-Clause
#include "filters/baselines/stores/OctreeStore.h"

#include "filters/baselines/stores/OctreePartitions.h"
#include "filters/build/BuildPhases.h"
#include "filters/build/SharedSteps.h"

#include <algorithm>
#include <string>

namespace kdstream
{
namespace
{

// Counts the edges that are not consistently oriented.
Status CountEdges(ExternalBuildState& build)
{
  MeshFacts facts;
  MeshBlocks mesh;
  KDSTREAM_TRY(LoadBlocks(build, facts, mesh));
  mesh.attributes.clear(); // not needed for this
  std::uint64_t inconsistent = 0;
  const Execution part = build.Part("faces", 0.8, 1);
  for (std::size_t b = 0; b < mesh.BlockCount(); ++b)
  {
    const Result<TreeBlock> block = mesh.Load(b);
    KDSTREAM_TRY(block);
    inconsistent += CountInconsistentEdges(*block, build.Exec);
    KDSTREAM_TRY(part.Report("faces", double(b + 1) / double(mesh.BlockCount())));
  }
  build.Clock.Finish("faces");
  BlobWriter blob;
  blob.Add(inconsistent);
  return build.Folder->Finish("edges", blob);
}

class OctreeOutOfCore : public ExternalMethod
{
public:
  Result<ExternalPartitions> Partition(
    ExternalBuildState& build, const MeshFacts& facts, SpillFile& records) const override
  {
    return (facts.floats ? PartitionByExternalOctree<float>
                         : PartitionByExternalOctree<double>)(build.Files(), records,
      build.Options.tree, build.Memory, build.Part("tree", 0.5, 1));
  }

  // Joins consecutive partitions into blocks, as many as fit in memory.
  Status PlanBlocks(
    ExternalBuildState& build, const MeshFacts& facts, MeshBlocks& mesh) const override
  {
    const std::vector<VertexId>& begin = build.PartitionBegin;
    if (begin.size() < 2 || begin.size() - 1 > build.Boxes.size() / 2 || begin.front() != 0 ||
        begin.back() != facts.vertices || !std::is_sorted(begin.begin(), begin.end()))
    {
      return Error{ ErrorCode::Damaged, "the octree of the interrupted build is incomplete" };
    }
    build.MostInBlock = MostBlockVertices(BlockedSizeOf(facts), build.Memory);
    mesh.begin = JoinIntoBlocks(begin, build.MostInBlock);
    for (std::size_t block = 0; block < mesh.BlockCount(); ++block)
    {
      if (const std::uint64_t size = mesh.RangeOf(block).size; size > build.MostInBlock)
      {
        return BeyondMemory("a partition of " + std::to_string(size) + " vertices; at most " +
                              std::to_string(build.MostInBlock) + " can be held",
          build.Options.memory);
      }
    }
    return {};
  }

  std::vector<BuildPhase> PhasesAfterFaces() const override
  {
    return { { "edges", "faces", CountEdges } };
  }

  Result<StoreParts> LoadParts(
    ExternalBuildState& build, MeshFacts& facts, MeshBlocks& mesh) const override
  {
    KDSTREAM_TRY(LoadBlocks(build, facts, mesh));
    StoreParts parts;
    BlobReader blob = build.Folder->BlobOf("edges");
    parts.inconsistentEdges = blob.Read<std::uint64_t>();
    KDSTREAM_TRY(blob.Finish());
    parts.forEach = [&build, &mesh](const PartVisit& visit,
                      const std::function<Status(Resolution)>& finished) -> Status
    {
      KDSTREAM_TRY(ForEachPartOfPartitions(mesh, build.PartitionBegin, visit, build.Exec));
      return finished(Resolution::Original());
    };
    return parts;
  }
};

}

const ExternalMethod& ExternalOctreeMethod()
{
  static const OctreeOutOfCore method;
  return method;
}

}
