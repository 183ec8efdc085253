// SPDX-License-Identifier: BSD-3-Clause
// The build in memory: see Builder.h, a back end of the conductor (Conductor.h).
#include "filters/build/Builder.h"

#include "filters/build/BuildInput.h"
#include "filters/build/BuildMemory.h"
#include "filters/build/Conductor.h"
#include "filters/build/ExternalBuilder.h"
#include "filters/build/InputDigest.h"
#include "filters/build/SharedSteps.h"
#include "filters/build/UnusedParts.h"
#include "filters/core/EdgeCount.h"
#include "filters/core/TakeResult.h"
#include "filters/core/UnusedVertices.h"
#include "filters/core/VectorMath.h"
#include "filters/core/Weld.h"
#include "filters/core/levels/GeometricErrorBins.h"
#include "filters/core/pieces/LeafOrder.h"
#include "filters/core/pieces/VertexTree.h"
#include "filters/core/tree/GatherMesh.h"
#include "filters/meshio/MeshReader.h"
#include "filters/outofcore/journal/BuildFolder.h"

#include <algorithm>

namespace kdstream
{
namespace
{

// The share of step "tree" that making the tree takes; measured on 28 million triangles.
constexpr double treeMadePart = 0.7;

class MemoryBuilder : public BuildBackEnd
{
public:
  // digest: returns the digest of the input; waits until it is ready.
  MemoryBuilder(Mesh mesh, bool weld, std::string name, std::function<Result<std::string>()> digest,
    const BuildOptions& options, const Execution& execution, StepClock clock)
    : Input(std::move(mesh))
    , Name(std::move(name))
    , Digest(std::move(digest))
    , Options(options)
    , Exec(execution)
    , Build{ options, execution, std::move(clock) }
  {
    this->Build.Facts.weld = weld;
  }

  BuildState& State() override { return this->Build; }

  Status MakeMesh() override
  {
    KDSTREAM_TRY(PrepareMesh(this->Input));
    KDSTREAM_TRY(this->Exec.Report("tree", 0));
    ModelFacts& facts = this->Build.Facts;
    facts.welded = facts.weld ? WeldVertices(this->Input, this->Exec) : 0;
    this->SetUnusedAside();
    this->Options.tellSize(this->Input.points.size(), this->Input.triangles.size());
    return {};
  }

  Status MakeTree() override
  {
    // The rest of the step counts vertices that the grid merges.
    Execution upToGrid = this->Exec;
    upToGrid.progress = [this](std::string_view step, double done)
    { return this->Exec.progress(step, treeMadePart * done); };
    Result<PartitionTree> partitioned =
      this->Options.partitioner->Partition(this->Input, this->Options.tree, upToGrid);
    KDSTREAM_TRY(partitioned);
    this->Tree = std::move(partitioned->tree);
    ModelFacts& facts = this->Build.Facts;
    facts.partitions = partitioned->partitions;
    facts.box = this->Tree.boxes[1];
    facts.depths = this->Tree.depths;
    facts.scalarType = this->Input.scalarType;
    this->PlacesDiffer = this->AllPlacesDiffer();
    return this->CountMerged();
  }

  Status MakeFaces() override
  {
    KDSTREAM_TRY(this->Exec.Report("faces", 0));
    if (this->Options.partitioner->HasLevels())
    {
      this->BucketByPartition();
    }
    KDSTREAM_TRY(this->Exec.Report("faces", 0.5));
    this->Build.Facts.inconsistentEdges =
      CountInconsistentEdges(this->Input.triangles, this->Input.points.size(), this->Exec);
    this->Measure();
    return {};
  }

  std::vector<BuildStep> StepsAfterFaces() override
  {
    std::vector<BuildStep> steps;
    if (this->Options.partitioner->HasLevels())
    {
      steps.push_back({ "levels", "levels", [this] { return this->MakeLevels(); } });
    }
    steps.push_back({ "numbers", "levels", [this] { return this->MakeNumbers(); } });
    return steps;
  }

  Status Describe() override { return {}; } // the steps have done it
  std::string InputName() const override { return this->Name; }
  Result<std::string> DigestOfInput() override { return this->Digest(); }

  Status ForEachPart(
    const PartVisit& visit, const std::function<Status(Resolution)>& finished) override
  {
    const auto primitive =
      this->Input.triangles.empty() ? PrimitiveType::Points : PrimitiveType::Triangles;
    const auto whole = [&](Resolution resolution) -> Status
    {
      KDSTREAM_TRY(visit(this->Numbered, this->Input, resolution,
        PartOfCell(resolution, this->Numbered.depths, 0, 0, primitive)));
      return finished(resolution);
    };
    for (unsigned d = 0; d < this->Numbered.levels.size(); ++d)
    {
      KDSTREAM_TRY(whole(Resolution::Level(d)));
    }
    return whole(Resolution::Original());
  }

  Status WriteUnusedList(StoreWriter& writer) override
  {
    return WriteUnused(this->Unused, writer, this->Exec);
  }

private:
  void SetUnusedAside()
  {
    const std::vector<bool> isUsed = FindUsedVertices(this->Input);
    const auto unused = static_cast<std::uint64_t>(std::count(isUsed.begin(), isUsed.end(), false));
    if (unused > 0)
    {
      this->Unused = TakeUnusedVertices(this->Input, isUsed);
      this->Build.Facts.unused = unused;
    }
  }

  void BucketByPartition()
  {
    const KdTree& tree = this->Tree;
    std::vector<std::uint32_t> partition = CellOfVertex(tree, tree.depths.partition, this->Exec);
    if (IsScattered(this->Input.triangles, partition))
    {
      partition = {};
      GatheredMesh gathered = GatherMesh(this->Input, this->Tree, this->Exec);
      this->Ids = std::move(gathered.ids);
      this->Buckets = std::move(gathered.buckets);
      return;
    }
    this->Buckets = BucketTriangles(
      this->Input.triangles, std::size_t{ 1 } << tree.depths.partition,
      [&](VertexId v) { return partition[v]; }, this->Exec);
  }

  Status MakeLevels()
  {
    const TriangleBuckets buckets = std::move(this->Buckets);
    const std::vector<VertexId> ids = std::move(this->Ids);
    LevelOptions options = this->Options.levels;
    options.mayCoincide = !this->PlacesDiffer;
    options.ids = ids;
    return Take(BuildLevels(this->Input, this->Tree, buckets, options, this->Exec), this->Levels);
  }

  Status MakeNumbers()
  {
    KDSTREAM_TRY(this->Exec.Report("encode", 0));
    KdTree tree = std::move(this->Tree); // afterwards it is not needed
    this->Build.Boxes = std::move(tree.boxes);
    this->Numbered = NumberVertices(tree, std::move(this->Levels), this->Exec);
    OrderLeaves(this->Numbered, this->Input.points, this->Exec);
    for (const VertexTreeLevel& level : this->Numbered.levels)
    {
      GeometricErrorBins bins;
      std::for_each(level.geometricErrors.begin(), level.geometricErrors.end(),
        [&](double geometricError) { bins.Add(geometricError); });
      this->Build.Facts.geometricErrors.push_back(bins.Most99());
    }
    return {};
  }

  // Whether it is certain that no two vertices are in the same place. Even after welding, vertices
  // in one place can differ in their arrays, or in the sign of a zero.
  bool AllPlacesDiffer() const
  {
    std::vector<AttributeInfo> arrays;
    for (const Attribute& array : this->Input.attributes)
    {
      arrays.push_back(array.Info());
    }
    return WeldingSeparates(this->Build.Facts.weld, arrays) &&
           std::none_of(this->Input.points.begin(), this->Input.points.end(), HasNegativeZero);
  }

  Status CountMerged()
  {
    const std::vector<Vec3>& points = this->Input.points;
    const auto count = [&](const PlaceOfPoint& placeOf) -> Result<std::uint64_t>
    {
      return CountPlaces(
        points.size(), [&](VertexId v) { return placeOf ? placeOf(points[v]) : points[v]; },
        this->Exec);
    };
    const ModelFacts& facts = this->Build.Facts;
    return Take(CountMergedByGrid(GridOf(this->Options, facts.box, facts.scalarType), points.size(),
                  !this->PlacesDiffer, count),
      this->Build.Report.mergedByGrid);
  }

  void Measure()
  {
    ModelFacts& facts = this->Build.Facts;
    facts.vertices = this->Input.points.size();
    facts.triangles = this->Input.triangles.size();
    for (const Attribute& attribute : this->Input.attributes)
    {
      facts.attributes.push_back(attribute.Info());
    }
    MeasurePartitions(facts,
      [&](std::size_t p) -> std::uint64_t
      { return this->Tree.Cell(facts.depths.partition, p).size(); });
  }

  Mesh Input;
  Mesh Unused; // vertices of the input that no triangle uses
  const std::string Name;
  const std::function<Result<std::string>()> Digest;
  const BuildOptions& Options;
  const Execution& Exec;
  BuildState Build;
  bool PlacesDiffer = false; // AllPlacesDiffer
  KdTree Tree;               // until vertices are numbered; the same for Levels
  TriangleBuckets Buckets;   // the triangles by partition, from step "faces" to "levels"
  std::vector<VertexId> Ids; // the new number of each vertex, if vertices were renumbered
  ClusterLevels Levels;
  VertexTree Numbered;
};

Result<BuildReport> BuildInMemory(const std::filesystem::path& input,
  const std::filesystem::path& store, const BuildOptions& options, const Execution& execution,
  OpenedInput opened)
{
  InputDigest digest(FilesOfInput(input, options));
  MeshReader& reader = *opened.reader;
  Result<Mesh> mesh = ReadMesh(reader, options, execution);
  KDSTREAM_TRY(mesh);
  opened.clock.Finish("read");
  MemoryBuilder builder(
    std::move(*mesh), options.weld || reader.Info().soup, InputNameOf(input, options),
    [&digest] { return digest.Take(); }, options, execution, std::move(opened.clock));
  Result<BuildReport> report = ConductBuild(builder, store);
  if (report)
  {
    report->ignoredAttributes = reader.Info().ignoredAttributes;
    report->tolerance = reader.Info().tolerance;
  }
  return report;
}

// Removes the files that an interrupted build out of core left, unless another build is running
// there.
void RemoveBuildFolder(const std::filesystem::path& folder)
{
  std::error_code ignored;
  if (std::filesystem::exists(folder, ignored))
  {
    // Without a fingerprint no file in the folder is kept.
    (void)BuildFolder::Open(folder, {}, false);
  }
}

}

Result<BuildReport> BuildStore(const std::filesystem::path& input,
  const std::filesystem::path& store, const BuildOptions& wanted, const Execution& execution)
{
  const Status external = CheckExternalBuild(wanted);
  const std::filesystem::path folder = BuildFolder::PathFor(store, wanted.temporaryFolder);
  std::error_code ignored;
  const bool left = std::filesystem::exists(folder, ignored);
  BuildOptions options = wanted;
  if (options.resume && left)
  {
    // A build in memory would discard the files to be resumed, which the user does not want.
    return external ? BuildStoreExternally(input, store, options, execution)
                    : Error{ external.GetError().code, "--resume: " + external.GetError().message +
                                                         "; build without --resume to start over" };
  }
  if (options.resume)
  {
    options.resume = false; // the message below says so once
    options.tellEarlierBuild("nothing to resume: no earlier build in " +
                             folder.parent_path().string() +
                             " (did that build have another --temp-dir?)");
  }
  else if (const std::string resumable = left ? DescribeResumable(input, store, options) : "";
           !resumable.empty())
  {
    options.tellEarlierBuild(resumable);
  }
  // Temporary files of a reader go to the same folder as those of a build out of core.
  OpenedInput opened;
  KDSTREAM_TRY(Take(MeshReader::Open(input, execution, folder.parent_path()), opened.reader));
  if (const Status fits = CheckInputMemory(*opened.reader, options); !fits)
  {
    return external ? BuildStoreExternally(input, store, options, execution, {}, std::move(opened))
                    : Error{ fits.GetError().code,
                        fits.GetError().message + " (" + external.GetError().message + ")" };
  }
  Result<BuildReport> report = BuildInMemory(input, store, options, execution, std::move(opened));
  if (report)
  {
    RemoveBuildFolder(folder);
  }
  return report;
}

Result<BuildReport> BuildStore(Mesh mesh, const std::string& name,
  const std::filesystem::path& store, const BuildOptions& options, const Execution& execution)
{
  const std::string digest = InputDigestOf(mesh);
  MemoryBuilder builder(std::move(mesh), options.weld, name,
    [&digest] { return Result<std::string>(digest); }, options, execution, {});
  return ConductBuild(builder, store);
}

}
