// SPDX-License-Identifier: BSD-3-Clause
// The parallel build: see DistributedBuilder.h. Steps: read and weld, tree, faces, levels, numbers,
// pieces.
#include "filters/Parallel/DistributedBuilder.h"

#include "filters/Parallel/DistributedFaces.h"
#include "filters/Parallel/DistributedLevels.h"
#include "filters/Parallel/DistributedPieces.h"
#include "filters/Parallel/DistributedPlaceCount.h"
#include "filters/Parallel/DistributedTree.h"
#include "filters/Parallel/DistributedUnused.h"
#include "filters/Parallel/DistributedWeld.h"
#include "filters/Parallel/RankAgreement.h"
#include "filters/Parallel/ShareDigest.h"
#include "filters/Parallel/ShareReader.h"
#include "filters/build/BuildInput.h"
#include "filters/build/BuildMemory.h"
#include "filters/build/Conductor.h"
#include "filters/build/ExternalBuilder.h"
#include "filters/build/HubCheck.h"
#include "filters/build/InputDigest.h"
#include "filters/build/SharedSteps.h"
#include "filters/build/UnusedParts.h"
#include "filters/core/CaughtError.h"
#include "filters/core/TakeResult.h"
#include "filters/core/VectorMath.h"
#include "filters/outofcore/files/LockedFolder.h"
#include "filters/outofcore/files/RecordFile.h"
#include "filters/outofcore/files/ReturnFreeMemory.h"
#include "filters/outofcore/levels/LevelGeometricErrors.h"
#include "filters/outofcore/mesh/MeshSpill.h"
#include "filters/outofcore/pieces/ExternalNumbers.h"
#include "filters/outofcore/pieces/ExternalPieces.h"

#include <algorithm>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

namespace kdstream
{
namespace
{

Result<bool> AnyNegativeZero(const VertexFiles& vertices)
{
  bool any = false;
  KDSTREAM_TRY(ForEachBlockOf<Vec3>(vertices.points, 0, vertices.count,
    [&](std::span<const Vec3> points)
    { any = any || std::any_of(points.begin(), points.end(), HasNegativeZero); }));
  return any;
}

const std::string ignoredMark = "ignored ";

// The input: a file that all ranks can read, or this rank's share of a mesh in memory.
struct DistributedInput
{
  std::filesystem::path file;
  std::optional<Mesh> share;
};

class DistributedBuilder : public BuildBackEnd
{
public:
  DistributedBuilder(MpiGroup& group, SpillFolder folder, DistributedInput input,
    const BuildOptions& options, const Execution& execution, std::uint64_t stepMemory)
    : Group(group)
    , Files(std::move(folder))
    , Input(std::move(input))
    , Options(options)
    , Exec(execution)
    , Whole{ options, execution }
    , Memory(stepMemory)
  {
    // The libraries of MPI and VTK do not count as memory of the steps.
    this->Mesh.keptMemory = KeptMemory(this->Memory) + ResidentBytes();
  }

  BuildState& State() override { return this->Whole; }
  Status MakeMesh() override { return this->Input.share ? this->TakeShare() : this->Read(); }
  Status MakeTree() override
  {
    KDSTREAM_TRY(
      Take(ComputeDepths(this->Mesh.vertexCount, this->Options.tree), this->Mesh.depths));
    this->Group.Shares().Divide(DepthOfGroup(this->Group.Count(), this->Mesh.depths));
    KDSTREAM_TRY(
      Take(BuildTreeCollectively(this->Group, this->Files, this->Vertices.kept,
             this->Vertices.begin[this->Group.Rank()], this->Memory, this->Mesh, this->Exec),
        this->Whole.Boxes));
    KDSTREAM_TRY(this->CountMerged());
    this->Vertices.kept.points = {};
    ReturnFreeMemory(this->Mesh.keptMemory);
    return {};
  }

  Status MakeFaces() override
  {
    this->Mesh.blockDepth = DepthOfBlocks(this->SizeOfBlocks(), this->Memory,
      this->Group.Shares().DividedDepth(), this->Mesh.depths.partition);
    KDSTREAM_TRY(ScatterFaces(
      this->Group, this->Files, this->Share, this->Vertices, this->Memory, this->Mesh, this->Exec));
    KDSTREAM_TRY(CheckHubs(this->Mesh, *this->Mesh.triangles, this->Options.memory));
    this->Whole.Facts.welded = this->Vertices.welded;
    this->Vertices = {};
    this->Share = {};
    ReturnFreeMemory(this->Mesh.keptMemory);
    return {};
  }

  std::vector<BuildStep> StepsAfterFaces() override
  {
    return { { "levels", "levels", [this] { return this->MakeLevels(); } },
      { "numbers", "levels", [this] { return this->MakeNumbers(); } } };
  }

  Status Describe() override
  {
    ModelFacts& facts = this->Whole.Facts;
    KDSTREAM_TRY(Take(GeometricErrorsOfLevels(this->Levels, this->Mesh.depths, &this->Group),
      facts.geometricErrors));
    facts.weld = this->Weld;
    facts.vertices = this->Mesh.vertexCount;
    facts.triangles = this->Mesh.triangleCount;
    facts.unused = this->Unused.count;
    facts.depths = this->Mesh.depths;
    facts.partitions = std::uint64_t{ 1 } << facts.depths.partition;
    MeasurePartitions(facts,
      [&](std::size_t p) -> std::uint64_t
      { return RangeOfCell(this->Mesh.vertexCount, facts.depths.partition, p).size; });
    facts.box = this->Mesh.box;
    facts.scalarType = this->Mesh.scalarType;
    facts.attributes = this->Mesh.attributes;
    return {};
  }

  std::string InputName() const override { return InputNameOf(this->Input.file, this->Options); }
  Result<std::string> DigestOfInput() override
  {
    return this->Digest ? this->Digest->Take() : Result<std::string>(this->DigestOfShare);
  }

  Status ForEachPart(
    const PartVisit& visit, const std::function<Status(Resolution)>& finished) override
  {
    const PartVisit andReturn = [&](const VertexTree& tree, const kdstream::Mesh& part,
                                  Resolution resolution, const ModelPart& cut) -> Status
    {
      KDSTREAM_TRY(visit(tree, part, resolution, cut));
      ReturnFreeMemory(this->Mesh.keptMemory);
      return {};
    };
    return kdstream::ForEachPart(
      this->Mesh, this->Levels, this->Numbers, andReturn, this->Exec, &this->Group, finished);
  }

  bool WritesStore() const override { return this->Group.IsFirst(); }
  Status TakePieces(const PieceCutter& cutter, std::size_t count, const PieceEncoding& encoding,
    StoreWriter* writer, const std::function<Status(std::size_t)>& written) override
  {
    DistributedPieces& pieces = this->PiecesFor(writer);
    return EncodePieces(
      cutter, count, encoding, [&](const EncodedPiece& encoded) { return pieces.Add(encoded); },
      this->Whole.Clock, this->Exec, written);
  }
  Status FinishResolution(
    Resolution resolution, std::uint64_t triangles, StoreWriter* writer) override
  {
    return this->PiecesFor(writer).Finish(resolution, triangles, this->Exec);
  }
  Status WriteUnusedList(StoreWriter& writer) override
  {
    return WriteUnused(
      this->Unused.vertices, this->Mesh.attributes, this->Mesh.scalarType, writer, this->Exec);
  }
  Status Agree() override { return this->Group.Finish(); }
  SpillCounts Costs() override { return this->Files.Counts(); }

private:
  // Takes this rank's share of a mesh in memory, and welds vertices.
  Status TakeShare()
  {
    KDSTREAM_TRY(Take(DigestOfShares(this->Group, *this->Input.share), this->DigestOfShare));
    KDSTREAM_TRY(Take(SpillMesh(this->Files, *this->Input.share), this->Share));
    MeshFileInfo info;
    info.scalarType = this->Input.share->scalarType;
    this->Input.share.reset();
    this->Whole.Clock.Finish("read");
    return this->WeldShares(info);
  }

  // Reads this rank's share of the file, and welds vertices.
  Status Read()
  {
    if (this->Group.IsFirst())
    {
      this->Digest.emplace(FilesOfInput(this->Input.file, this->Options));
    }
    MeshFileInfo info;
    Result<bool> read = this->ReadShare(true, info);
    if (read && !*read)
    {
      read = this->ReadShare(false, info);
    }
    KDSTREAM_TRY(read);
    KDSTREAM_TRY(this->TakeReported(info));
    this->Whole.Clock.Finish("read");
    return this->WeldShares(info);
  }

  // Returns false, on all ranks, if the file must be read again without seeking.
  Result<bool> ReadShare(bool seek, MeshFileInfo& info)
  {
    Result<std::unique_ptr<MeshReader>> reader =
      MeshReader::Open(this->Input.file, this->Exec, this->Files.Path());
    KDSTREAM_TRY(reader);
    KDSTREAM_TRY(AgreeOnHeader(this->Group, (*reader)->Info()));
    KDSTREAM_TRY(CheckClaimedPartitions(**reader, this->Options));
    const bool alone = this->Group.Count() == 1;
    ShareReader share(std::move(*reader), this->Group.Rank(), this->Group.Count(), seek);
    Result<SpilledMesh> spilled =
      SpillMesh(this->Files, share, ChunkOfRead(this->Memory), this->Exec, true);
    if (seek && !alone)
    {
      // If one rank drops a vertex, the corners of all ranks change. Also, a rank may assume
      // something wrong about bytes that it has not read.
      const bool wrong = !spilled && spilled.GetError().code == ErrorCode::InvalidInput;
      const bool dropped = share.Info().tolerance.Of(Lapse::PointNotFinite) > 0;
      if (!spilled && !wrong)
      {
        return spilled.GetError();
      }
      std::uint64_t again[] = { wrong || dropped ? 1U : 0U };
      KDSTREAM_TRY(this->Group.Sum(again));
      if (again[0] > 0)
      {
        return false;
      }
    }
    KDSTREAM_TRY(Take(std::move(spilled), this->Share));
    info = share.Info();
    return true;
  }

  // Collects the notes on the input: what no store keeps (the rank that reads the end of the file
  // has seen all of it), and what was dropped or repaired in each rank's share.
  Status TakeReported(const MeshFileInfo& info)
  {
    const std::size_t last = this->Group.Count() - 1;
    std::string text = info.tolerance.ToLines();
    for (const std::string& name :
      this->Group.Rank() == last ? info.ignoredAttributes : std::vector<std::string>{})
    {
      text += ignoredMark + name + "\n";
    }
    const RankLists<char> out(this->Group.Count(), std::vector<char>(text.begin(), text.end()));
    const Result<RankLists<char>> in = this->Group.Exchange(out);
    KDSTREAM_TRY(in);
    for (const std::vector<char>& reported : *in)
    {
      std::istringstream lines(std::string(reported.begin(), reported.end()));
      for (std::string line; std::getline(lines, line);)
      {
        if (line.starts_with(ignoredMark))
        {
          this->Whole.Report.ignoredAttributes.push_back(line.substr(ignoredMark.size()));
        }
        this->Whole.Report.tolerance.Add(Tolerance::FromLines(line));
      }
    }
    const Status strict = this->Whole.Report.tolerance.Check(this->Options.strict);
    return strict ? strict : Status(this->Group.FailCollectively(strict.GetError()));
  }

  Status WeldShares(const MeshFileInfo& info)
  {
    KDSTREAM_TRY(CheckAttributeNames(this->Share.attributes));
    this->Weld = this->Options.weld || info.soup;
    KDSTREAM_TRY(Take(WeldCollectively(this->Group, this->Files, std::move(this->Share.vertices),
                        this->Weld, this->Memory, this->Exec),
      this->Vertices));
    KDSTREAM_TRY(this->SetUnusedAside(info));
    const Result<bool> negative = AnyNegativeZero(this->Vertices.kept);
    KDSTREAM_TRY(negative);
    // Over all ranks: the number of triangles; of ranks with a coordinate that no float holds
    // exactly; of ranks with a -0.0.
    std::uint64_t sums[] = { this->Share.triangleCount, this->Share.fitFloats ? 0U : 1U,
      *negative ? 1U : 0U };
    KDSTREAM_TRY(this->Group.Sum(sums));
    if (sums[0] >= noVertex)
    {
      return Error{ ErrorCode::LimitExceeded,
        std::to_string(sums[0]) + " triangles; the maximum is 4294967294" };
    }
    this->Triangles = sums[0];
    this->Mesh.vertexCount = this->Vertices.Count();
    this->Mesh.floats = sums[1] == 0;
    this->Mesh.scalarType = info.scalarType;
    this->Options.tellSize(this->Mesh.vertexCount, this->Triangles);
    this->Mesh.attributes = this->Share.attributes;
    this->Mesh.mayCoincide = sums[2] > 0 || !WeldingSeparates(this->Weld, this->Mesh.attributes);
    ReturnFreeMemory(this->Mesh.keptMemory);
    return CheckPartitionMemory(this->SizeOfBlocks(), this->Options.tree, this->Options.memory);
  }

  Status SetUnusedAside(const MeshFileInfo& info)
  {
    std::uint64_t triangles = this->Share.triangleCount;
    KDSTREAM_TRY(this->Group.Sum(std::span(&triangles, 1)));
    return info.soup || triangles == 0
             ? Status{}
             : Take(kdstream::SetUnusedAside(this->Group, this->Files, this->Share, this->Vertices,
                      this->Memory, this->Exec),
                 this->Unused);
  }

  BlockedSize SizeOfBlocks() const
  {
    return { this->Mesh.vertexCount, this->Triangles, this->Vertices.kept.tupleBytes,
      this->Share.cellTupleBytes };
  }

  Status CountMerged()
  {
    const auto count = [&](const PlaceOfPoint& placeOf)
    {
      return CountPlacesCollectively(this->Group, this->Files, this->Vertices.kept,
        this->Mesh.vertexCount, placeOf, this->Memory);
    };
    return Take(CountMergedByGrid(GridOf(this->Options, this->Mesh.box, this->Mesh.scalarType),
                  this->Mesh.vertexCount, this->Mesh.mayCoincide, count),
      this->Whole.Report.mergedByGrid);
  }

  Status MakeLevels()
  {
    std::uint64_t inconsistent = 0;
    KDSTREAM_TRY(Take(
      BuildLevelsCollectively(this->Group, this->Files, this->Mesh, this->Options.levels,
        this->Memory, this->Exec,
        [&](const TreeBlock& block) { inconsistent += CountInconsistentEdges(block, this->Exec); }),
      this->Levels));
    KDSTREAM_TRY(this->Group.Sum(std::span(&inconsistent, 1)));
    this->Whole.Facts.inconsistentEdges = inconsistent;
    return {};
  }

  Status MakeNumbers()
  {
    return Take(NumberExternally(this->Files, this->Mesh, this->Levels, this->Exec, &this->Group),
      this->Numbers);
  }

  DistributedPieces& PiecesFor(StoreWriter* writer)
  {
    if (!this->Pieces)
    {
      this->Pieces.emplace(this->Group, this->Files, this->Mesh.attributes, writer);
    }
    return *this->Pieces;
  }

  MpiGroup& Group;
  SpillFolder Files;
  DistributedInput Input;
  const BuildOptions& Options;
  const Execution& Exec;
  BuildState Whole; // facts of all ranks
  std::uint64_t Memory;
  SpilledMesh Share;
  DistributedVertices Vertices;
  DistributedUnused Unused;
  MeshBlocks Mesh;
  ExternalLevels Levels;
  ExternalNumbers Numbers;
  std::optional<DistributedPieces> Pieces;
  std::uint64_t Triangles = 0; // on all ranks
  bool Weld = true;
  std::optional<InputDigest> Digest; // of an input file; only on the rank that writes the store
  std::string DigestOfShare;         // the same for a mesh in the ranks' memory
};

Status CheckOptions(const BuildOptions& options)
{
  if (!options.partitioner->HasLevels())
  {
    return Error{ ErrorCode::Unsupported,
      "octree and k-means partitions are only for comparison: use kdstream-build" };
  }
  if (options.resume)
  {
    return Error{ ErrorCode::Unsupported, "only kdstream-build can resume interrupted builds" };
  }
  if (options.memory < leastMemory)
  {
    return Error{ ErrorCode::LimitExceeded, "building on several ranks needs at least " +
                                              Mebibytes(leastMemory) + " on each; the limit is " +
                                              Mebibytes(options.memory) };
  }
  return {};
}

std::filesystem::path FolderOf(const std::filesystem::path& store)
{
  return store.has_parent_path() ? store.parent_path() : ".";
}

Result<BuildReport> BuildHere(MpiGroup& group, DistributedInput input,
  const std::filesystem::path& store, const BuildOptions& options, const Execution& execution,
  std::uint64_t stepMemory)
{
  KDSTREAM_TRY(CheckOptions(options));
  if (!input.share)
  {
    KDSTREAM_TRY(AgreeOnInput(group, input.file));
  }
  // All ranks must split nodes and end blocks at the same places. So the smallest limit is used.
  const Result<std::uint64_t> smallest = group.Most(~options.memory);
  KDSTREAM_TRY(smallest);
  const std::uint64_t memory = stepMemory > 0 ? stepMemory : StepMemory(~*smallest);
  const std::filesystem::path parent =
    options.temporaryFolder.empty() ? FolderOf(store) : options.temporaryFolder;
  RemoveDeadFolders(parent);
  Result<SpillFolder> folder = SpillFolder::Create(parent);
  KDSTREAM_TRY(folder);
  DistributedBuilder builder(
    group, std::move(*folder), std::move(input), options, execution, memory);
  return ConductBuild(builder, store);
}

// The same, but an error is reported to the other ranks, which are waiting.
Result<BuildReport> Build(MpiGroup& group, DistributedInput input,
  const std::filesystem::path& store, const BuildOptions& options, const Execution& execution,
  std::uint64_t stepMemory)
{
  const std::string file = input.file.string();
  Result<BuildReport> report = Error{};
  try
  {
    report = BuildHere(group, std::move(input), store, options, execution, stepMemory);
  }
  catch (const BrokenGroup&)
  {
    throw;
  }
  catch (...)
  {
    report = CaughtError();
  }
  if (!report && !file.empty()) // a rank may have the input under another path
  {
    report = OfFile(file, std::move(report)).GetError();
  }
  return report ? std::move(report) : group.Fail(report.GetError());
}

}

Result<BuildReport> BuildStoreCollectively(MpiGroup& group, const std::filesystem::path& input,
  const std::filesystem::path& store, const BuildOptions& options, const Execution& execution,
  std::uint64_t stepMemory)
{
  return Build(group, { input, {} }, store, options, execution, stepMemory);
}

Result<BuildReport> BuildStoreOfShares(MpiGroup& group, Mesh share,
  const std::filesystem::path& store, const BuildOptions& options, const Execution& execution)
{
  BuildOptions here = options;
  if (!group.IsFirst() && !SpillFolder::Create(FolderOf(store)))
  {
    std::error_code ignored; // a missing folder is reported by the build
    here.temporaryFolder = std::filesystem::temp_directory_path(ignored);
  }
  return Build(group, { {}, std::move(share) }, store, here, execution, 0);
}

}
