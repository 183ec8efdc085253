// SPDX-License-Identifier: BSD-3-Clause
// The build in memory: see Builder.h. Steps: read, weld, tree, levels, number, cut and encode,
// store.
#include "filters/build/Builder.h"

#include "filters/build/BuildInput.h"
#include "filters/build/BuildMemory.h"
#include "filters/build/ExternalBuilder.h"
#include "filters/build/GuessPose.h"
#include "filters/build/InputDigest.h"
#include "filters/build/ModelFacts.h"
#include "filters/build/PieceWriting.h"
#include "filters/build/SharedSteps.h"
#include "filters/build/UnusedParts.h"
#include "filters/core/EdgeCount.h"
#include "filters/core/TakeResult.h"
#include "filters/core/UnusedVertices.h"
#include "filters/core/VectorMath.h"
#include "filters/core/Weld.h"
#include "filters/core/levels/DeviationBins.h"
#include "filters/core/pieces/LeafOrder.h"
#include "filters/core/pieces/VertexTree.h"
#include "filters/core/tree/GatherMesh.h"
#include "filters/meshio/MeshReader.h"
#include "filters/outofcore/files/ReturnFreeMemory.h"
#include "filters/outofcore/journal/BuildFolder.h"

#include <algorithm>

namespace kdstream
{
namespace
{

constexpr double treeMadePart = 0.7; // of step "tree", measured on 28 million triangles

class StoreBuilder
{
public:
  StoreBuilder(Mesh mesh, const BuildOptions& options, const Execution& execution, StepClock clock)
    : Input(std::move(mesh))
    , Options(options)
    , Exec(execution)
    , Clock(std::move(clock))
  {
  }

  // digest: waits for that of the input.
  Result<BuildReport> Build(const std::string& name, const std::filesystem::path& store,
    const std::function<Result<std::string>()>& digest)
  {
    Result<VertexTree> numbered = this->BuildTree();
    KDSTREAM_TRY(numbered);
    for (const VertexTreeLevel& level : numbered->levels)
    {
      DeviationBins bins;
      std::for_each(level.deviations.begin(), level.deviations.end(),
        [&](double deviation) { bins.Add(deviation); });
      this->Facts.deviations.push_back(bins.Most99());
    }
    this->Clock.Finish("levels");
    ModelDescription description = DescribeModel(this->Options, this->Facts, name);
    KDSTREAM_TRY(Take(digest(), description.inputDigest));
    Result<std::unique_ptr<StoreWriter>> writer = StoreWriter::Create(store, description);
    KDSTREAM_TRY(writer);
    KDSTREAM_TRY(this->WriteAll(*numbered, description.Codec(), **writer));
    KDSTREAM_TRY(WriteUnused(this->Unused, **writer, this->Exec));
    KDSTREAM_TRY(this->Exec.Report("write", 0));
    KDSTREAM_TRY(TellPose(this->Options, description, **writer));
    Result<ModelDescription> info = (*writer)->Finish();
    KDSTREAM_TRY(info);
    this->Clock.Finish("write");
    BuildReport report;
    report.info = std::move(*info);
    report.scalarType = this->Facts.scalarType;
    report.mergedByGrid = this->MergedByGrid;
    report.seconds = this->Clock.Take();
    return report;
  }

private:
  // Weld, tree, faces, levels, numbers; fills in what the store says of the model.
  Result<VertexTree> BuildTree()
  {
    ModelFacts& facts = this->Facts;
    KDSTREAM_TRY(PrepareMesh(this->Input));
    KDSTREAM_TRY(this->Exec.Report("tree", 0));
    facts.welded = this->Options.weld ? WeldVertices(this->Input, this->Exec) : 0;
    KDSTREAM_TRY(this->SetUnusedAside());
    // Welding may have left more than was counted on.
    KDSTREAM_TRY(CheckBuildMemory(this->Size(), this->Options.tree, this->Options.memory));
    this->Options.tellSize(this->Input.points.size(), this->Input.triangles.size());
    Execution upToGrid = this->Exec; // what merges on the grid is counted in the rest of the step
    upToGrid.progress = [this](std::string_view step, double done)
    { return this->Exec.progress(step, treeMadePart * done); };
    Result<PartitionTree> partitioned =
      this->Options.partitioner->Partition(this->Input, this->Options.tree, upToGrid);
    KDSTREAM_TRY(partitioned);
    KdTree& tree = partitioned->tree;
    facts.partitions = partitioned->partitions;
    facts.box = tree.boxes[1];
    facts.depths = tree.depths;
    facts.scalarType = this->Input.scalarType;
    this->PlacesDiffer = this->AllPlacesDiffer();
    KDSTREAM_TRY(this->CountMerged());
    this->Clock.Finish("tree");
    KDSTREAM_TRY(this->Exec.Report("faces", 0));
    if (this->Options.partitioner->HasLevels())
    {
      this->BucketByPartition(tree);
    }
    KDSTREAM_TRY(this->Exec.Report("faces", 0.5));
    facts.inconsistentEdges =
      CountInconsistentEdges(this->Input.triangles, this->Input.points.size(), this->Exec);
    this->Measure(tree);
    this->Clock.Finish("faces");
    Result<ClusterLevels> levels = this->Options.partitioner->HasLevels()
                                     ? this->MakeLevels(tree)
                                     : Result<ClusterLevels>(ClusterLevels{});
    KDSTREAM_TRY(levels);
    KDSTREAM_TRY(this->Exec.Report("encode", 0));
    this->Boxes = std::move(tree.boxes);
    VertexTree numbered = NumberVertices(tree, std::move(*levels), this->Exec);
    OrderLeaves(numbered, this->Input.points, this->Exec);
    return numbered;
  }

  Status SetUnusedAside()
  {
    const std::vector<bool> isUsed = FindUsedVertices(this->Input);
    const auto unused = static_cast<std::uint64_t>(std::count(isUsed.begin(), isUsed.end(), false));
    if (unused > 0)
    {
      KDSTREAM_TRY(CheckPartingMemory(SizeOf(this->Input), unused, this->Options.memory));
      this->Unused = TakeUnusedVertices(this->Input, isUsed);
      this->Facts.unused = unused;
    }
    return {};
  }

  // Unused vertices are in memory up to the end, as an array would be.
  MeshSize Size() const
  {
    MeshSize size = SizeOf(this->Input);
    size.attributeBytes +=
      this->Unused.points.size() * sizeof(Vec3) + SizeOf(this->Unused).attributeBytes;
    return size;
  }

  void BucketByPartition(KdTree& tree)
  {
    std::vector<std::uint32_t> partition = CellOfVertex(tree, tree.depths.partition, this->Exec);
    if (IsScattered(this->Input.triangles, partition))
    {
      partition = {};
      GatheredMesh gathered = GatherMesh(this->Input, tree, this->Exec);
      this->Ids = std::move(gathered.ids);
      this->Buckets = std::move(gathered.buckets);
      return;
    }
    this->Buckets = BucketTriangles(
      this->Input.triangles, std::size_t{ 1 } << tree.depths.partition,
      [&](VertexId v) { return partition[v]; }, this->Exec);
  }

  Result<ClusterLevels> MakeLevels(const KdTree& tree)
  {
    const TriangleBuckets buckets = std::move(this->Buckets);
    const std::vector<VertexId> ids = std::move(this->Ids);
    LevelOptions options = this->Options.levels;
    options.mayCoincide = !this->PlacesDiffer;
    options.ids = ids;
    options.mostClusters =
      MostClusters(this->Size(), std::uint64_t{ 1 } << tree.depths.partition, this->Options.memory);
    Result<ClusterLevels> levels = BuildLevels(this->Input, tree, buckets, options, this->Exec);
    if (!levels && levels.GetError().code == ErrorCode::LimitExceeded)
    {
      return BeyondMemory(levels.GetError().message, this->Options.memory);
    }
    return levels;
  }

  // Whether it is known that no two vertices are in the same place: what welding leaves can differ
  // by its arrays, or by the sign of a zero.
  bool AllPlacesDiffer() const
  {
    std::vector<AttributeInfo> arrays;
    for (const Attribute& array : this->Input.attributes)
    {
      arrays.push_back(array.Info());
    }
    return WeldingSeparates(this->Options.weld, arrays) &&
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
    return Take(CountMergedByGrid(GridOf(this->Options, this->Facts.box, this->Facts.scalarType),
                  points.size(), !this->PlacesDiffer, count),
      this->MergedByGrid);
  }

  void Measure(const KdTree& tree)
  {
    ModelFacts& facts = this->Facts;
    facts.vertices = this->Input.points.size();
    facts.triangles = this->Input.triangles.size();
    for (const Attribute& attribute : this->Input.attributes)
    {
      facts.attributes.push_back(attribute.Info());
    }
    MeasurePartitions(facts,
      [&](std::size_t p) -> std::uint64_t { return tree.Cell(tree.depths.partition, p).size(); });
  }

  Status WriteAll(const VertexTree& numbered, const CodecContext& codec, StoreWriter& writer)
  {
    for (unsigned d = 0; d < numbered.levels.size(); ++d)
    {
      KDSTREAM_TRY(this->WriteResolution(numbered, Resolution::Level(d), codec, writer));
    }
    KDSTREAM_TRY(this->WriteResolution(numbered, Resolution::Original(), codec, writer));
    return WriteTreePages(this->Boxes, numbered.depths, writer);
  }

  Status WriteResolution(const VertexTree& numbered, Resolution resolution,
    const CodecContext& codec, StoreWriter& writer)
  {
    const PieceCutter cutter(numbered, this->Input, resolution, this->Exec);
    const std::size_t pieces =
      resolution.IsOriginal() ? this->Facts.partitions : cutter.PieceCount();
    KDSTREAM_TRY(WritePieces(cutter, pieces, { codec, this->Options.textures.get() }, writer,
      this->Clock, this->Exec,
      [&](std::size_t written)
      {
        const double part = double(written) / double(pieces);
        return this->Exec.Report("encode", EncodedPart(resolution, numbered.depths, part));
      }));
    return writer.FinishResolution(resolution, cutter.TriangleCount());
  }

  Mesh Input;
  Mesh Unused; // vertices of the input that no triangle uses
  const BuildOptions& Options;
  const Execution& Exec;
  StepClock Clock;
  ModelFacts Facts;
  bool PlacesDiffer = false; // AllPlacesDiffer
  TriangleBuckets Buckets;   // the triangles by partition, from faces to levels
  std::vector<VertexId> Ids; // of each vertex, where it has another number since
  std::vector<Box> Boxes;
  std::uint64_t MergedByGrid = 0;
};

}

namespace
{

Result<BuildReport> BuildInMemory(const std::filesystem::path& input,
  const std::filesystem::path& store, const BuildOptions& options, const Execution& execution)
{
  StepClock clock;
  InputDigest digest(FilesOfInput(input, options));
  // What a reader must spill goes beside the store.
  Result<std::unique_ptr<MeshReader>> reader =
    MeshReader::Open(input, execution, store.has_parent_path() ? store.parent_path() : ".");
  KDSTREAM_TRY(reader);
  Result<Mesh> mesh = ReadMesh(**reader, options, execution);
  KDSTREAM_TRY(mesh);
  clock.Finish("read");
  BuildOptions used = options;
  used.weld = options.weld || (*reader)->Info().soup;
  Result<BuildReport> report =
    StoreBuilder(std::move(*mesh), used, execution, std::move(clock))
      .Build(InputNameOf(input, options), store, [&digest] { return digest.Take(); });
  if (report)
  {
    report->ignoredAttributes = (*reader)->Info().ignoredAttributes;
    report->tolerance = (*reader)->Info().tolerance;
  }
  return report;
}

}

namespace
{

// Clears away what an interrupted build out of core has left, unless another one is at work there.
void RemoveBuildFolder(const std::filesystem::path& folder)
{
  std::error_code ignored;
  if (std::filesystem::exists(folder, ignored))
  {
    (void)BuildFolder::Open(folder, {}, false); // without a fingerprint nothing in it is kept
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
    // A build in memory, which would throw away what is there, is not what was asked for.
    return external ? BuildStoreExternally(input, store, options, execution)
                    : Error{ external.GetError().code, "--resume: " + external.GetError().message +
                                                         "; build without --resume to start over" };
  }
  if (options.resume)
  {
    options.resume = false; // that is told once
    options.tellEarlierBuild("nothing to resume: no earlier build in " +
                             folder.parent_path().string() + " (was another --temp-dir given?)");
  }
  else if (const std::string resumable = left ? DescribeResumable(input, store, options) : "";
           !resumable.empty())
  {
    options.tellEarlierBuild(resumable);
  }
  Result<BuildReport> report = BuildInMemory(input, store, options, execution);
  if (report)
  {
    RemoveBuildFolder(folder);
    return report;
  }
  const Error& error = report.GetError();
  if (error.code != ErrorCode::LimitExceeded || options.memory == 0)
  {
    return report;
  }
  if (!external)
  {
    return Error{ error.code, error.message + " (" + external.GetError().message + ")" };
  }
  ReturnFreeMemory(); // what the attempt in memory has read
  return BuildStoreExternally(input, store, options, execution);
}

Result<BuildReport> BuildStore(Mesh mesh, const std::string& name,
  const std::filesystem::path& store, const BuildOptions& options, const Execution& execution)
{
  const std::string digest = InputDigestOf(mesh);
  return StoreBuilder(std::move(mesh), options, execution, {})
    .Build(name, store, [&digest] { return Result<std::string>(digest); });
}

}
