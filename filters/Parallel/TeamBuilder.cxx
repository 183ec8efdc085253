// The parallel build: see TeamBuilder.h. Steps: read and weld, tree, faces, levels, numbers,
// pieces.
#include "filters/Parallel/TeamBuilder.h"

#include "filters/Parallel/ShareReader.h"
#include "filters/Parallel/TeamFaces.h"
#include "filters/Parallel/TeamLevels.h"
#include "filters/Parallel/TeamPieces.h"
#include "filters/Parallel/TeamTree.h"
#include "filters/Parallel/TeamWeld.h"
#include "filters/build/BuildInput.h"
#include "filters/build/BuildMemory.h"
#include "filters/build/ExternalBuilder.h"
#include "filters/build/HubCheck.h"
#include "filters/build/ModelDescription.h"
#include "filters/build/PieceWriting.h"
#include "filters/core/CaughtError.h"
#include "filters/core/EdgeCount.h"
#include "filters/core/TakeResult.h"
#include "filters/outofcore/files/FreeMemory.h"
#include "filters/outofcore/files/RecordFile.h"
#include "filters/outofcore/mesh/MeshSpill.h"
#include "filters/outofcore/pieces/ExternalNumbers.h"
#include "filters/outofcore/pieces/ExternalPieces.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

namespace kdstream
{
namespace
{

bool HasNegativeZero(const Vec3& p)
{
  return std::any_of(p.begin(), p.end(), [](double x) { return x == 0 && std::signbit(x); });
}

Result<bool> AnyNegativeZero(const VertexFiles& vertices)
{
  RecordReader<Vec3> reader(vertices.points, 0, vertices.count);
  for (std::uint32_t done = 0; done < vertices.count;)
  {
    const Result<std::span<const Vec3>> read = reader.Next();
    KDSTREAM_TRY(read);
    if (std::any_of(read->begin(), read->end(), HasNegativeZero))
    {
      return true;
    }
    done += static_cast<std::uint32_t>(read->size());
  }
  return false;
}

class TeamBuilder
{
public:
  TeamBuilder(MpiTeam& team, SpillFolder folder, const std::filesystem::path& input,
    const std::filesystem::path& store, const BuildOptions& options, const Execution& execution,
    std::uint64_t stepMemory)
    : Team(team)
    , Files(std::move(folder))
    , Input(input)
    , Store(store)
    , Options(options)
    , Exec(execution)
    , Memory(stepMemory > 0 ? stepMemory : StepMemory(options.memory))
  {
    // The libraries of MPI and VTK are no part of the steps' memory.
    this->Mesh.keptMemory = KeptMemory(this->Memory) + ResidentBytes();
  }

  Result<BuildReport> Build()
  {
    Status status = this->Read();
    if (status)
    {
      status = this->MakeTree();
    }
    if (status)
    {
      status = this->MakeFaces();
    }
    if (status)
    {
      status = this->MakeLevels();
    }
    if (status)
    {
      status =
        Take(NumberExternally(this->Files, this->Mesh, this->Levels, this->Exec, &this->Team),
          this->Numbers);
      this->Clock.Finish("levels");
    }
    if (status)
    {
      status = this->WriteStore();
    }
    status = status ? this->Team.Finish() : status;
    KDSTREAM_TRY(status);
    const SpillCounts counts = this->Files.Counts();
    this->Report.temporaryBytes = counts.peakBytesOnDisk;
    this->Report.bytesRead = counts.bytesRead;
    this->Report.bytesWritten = counts.bytesWritten;
    this->Report.seconds = this->Clock.Take();
    return std::move(this->Report);
  }

private:
  // This rank's share of the file; vertices welded.
  Status Read()
  {
    Result<std::unique_ptr<MeshReader>> reader =
      MeshReader::Open(this->Input, this->Exec, this->Files.Path());
    KDSTREAM_TRY(reader);
    KDSTREAM_TRY(CheckClaimedPartitions(**reader, this->Options, false));
    ShareReader share(std::move(*reader), this->Team.Rank(), this->Team.Count());
    const std::size_t chunk = static_cast<std::size_t>(
      std::min<std::uint64_t>(this->Memory / 16, std::uint64_t{ 8 } << 20));
    Status status = Take(SpillMesh(this->Files, share, chunk, this->Exec, true), this->Share);
    status = status ? this->TakeIgnored(share.Info().ignoredAttributes) : status;
    KDSTREAM_TRY(status);
    this->Clock.Finish("read");
    return this->WeldShares(share.Info());
  }

  // What the file has and no store keeps: the rank that reads its end has seen all of it.
  Status TakeIgnored(const std::vector<std::string>& seen)
  {
    const std::size_t last = this->Team.Count() - 1;
    RankLists<char> out(this->Team.Count());
    for (const std::string& name : this->Team.Rank() == last ? seen : std::vector<std::string>{})
    {
      out[0].insert(out[0].end(), name.begin(), name.end());
      out[0].push_back('\n');
    }
    const Result<RankLists<char>> in = this->Team.Exchange(out);
    KDSTREAM_TRY(in);
    std::istringstream lines(std::string((*in)[last].begin(), (*in)[last].end()));
    for (std::string name; std::getline(lines, name);)
    {
      this->Report.ignoredAttributes.push_back(name);
    }
    return {};
  }

  Status WeldShares(const MeshFileInfo& info)
  {
    for (const AttributeInfo& attribute : this->Share.attributes)
    {
      if (!IsAttributeName(attribute.name))
      {
        return Error{ ErrorCode::InvalidInput, "an attribute has a name that is no text" };
      }
    }
    this->Weld = this->Options.weld || info.soup;
    Status status = Take(WeldTogether(this->Team, this->Files, std::move(this->Share.vertices),
                           this->Weld, this->Memory, this->Exec),
      this->Vertices);
    const Result<bool> negative =
      status ? AnyNegativeZero(this->Vertices.kept) : Result<bool>(status.GetError());
    // Of all ranks: triangles, ranks with a coordinate that no float holds, and with a -0.0.
    std::uint64_t sums[] = { this->Share.triangleCount, this->Share.fitFloats ? 0U : 1U,
      negative && *negative ? 1U : 0U };
    status = negative ? this->Team.Sum(sums) : Status(negative.GetError());
    KDSTREAM_TRY(status);
    if (sums[0] >= noVertex)
    {
      return Error{ ErrorCode::LimitExceeded,
        std::to_string(sums[0]) + " triangles; at most 4294967294 are possible" };
    }
    this->Triangles = sums[0];
    this->Mesh.vertexCount = this->Vertices.Count();
    this->Mesh.floats = sums[1] == 0;
    this->Mesh.scalarType = info.scalarType;
    this->Mesh.attributes = this->Share.attributes;
    this->Mesh.mayCoincide = sums[2] > 0 || !WeldingSeparates(this->Weld, this->Mesh.attributes);
    ReturnFreeMemory(this->Mesh.keptMemory);
    this->Clock.Finish("tree");
    return CheckPartitionMemory(
      this->SizeOfBlocks(), this->Options.tree, this->Options.memory, false);
  }

  BlockedSize SizeOfBlocks() const
  {
    return { this->Mesh.vertexCount, this->Triangles, this->Vertices.kept.tupleBytes,
      this->Share.cellTupleBytes };
  }

  Status MakeTree()
  {
    Status status =
      Take(ComputeDepths(this->Mesh.vertexCount, this->Options.tree), this->Mesh.depths);
    KDSTREAM_TRY(status);
    this->Team.Divide(DepthOfTeam(this->Team.Count(), this->Mesh.depths));
    status = Take(BuildTreeTogether(this->Team, this->Files, this->Vertices.kept,
                    this->Vertices.begin[this->Team.Rank()], this->Memory, this->Mesh, this->Exec),
      this->Boxes);
    if (status)
    {
      status = this->CountMergedByGrid();
    }
    this->Vertices.kept.points = {};
    ReturnFreeMemory(this->Mesh.keptMemory);
    this->Clock.Finish("tree");
    return status;
  }

  Status CountMergedByGrid()
  {
    const CoordinateGrid grid = GridOf(this->Options, this->Mesh.box, this->Mesh.scalarType);
    if (grid.Lossless())
    {
      return {};
    }
    const auto count = [&](const std::function<Vec3(const Vec3&)>& placeOf)
    {
      return CountPlacesTogether(this->Team, this->Files, this->Vertices.kept,
        this->Mesh.vertexCount, placeOf, this->Memory);
    };
    const Result<std::uint64_t> exact = this->Mesh.mayCoincide
                                          ? count([](const Vec3& p) { return p; })
                                          : Result<std::uint64_t>(this->Mesh.vertexCount);
    const Result<std::uint64_t> snapped =
      exact ? count([&](const Vec3& p) { return grid.Snap(p); }) : exact;
    KDSTREAM_TRY(snapped);
    this->Report.mergedByGrid = *exact - std::min(*exact, *snapped);
    return {};
  }

  Status MakeFaces()
  {
    this->Mesh.blockDepth = DepthOfBlocks(
      this->SizeOfBlocks(), this->Memory, this->Team.DividedDepth(), this->Mesh.depths.partition);
    Status status = DealFaces(
      this->Team, this->Files, this->Share, this->Vertices, this->Memory, this->Mesh, this->Exec);
    status = status ? CheckHubs(this->Mesh, *this->Mesh.triangles, this->Options.memory) : status;
    this->Facts.welded = this->Vertices.welded;
    this->Vertices = {};
    this->Share = {};
    ReturnFreeMemory(this->Mesh.keptMemory);
    this->Clock.Finish("faces");
    return status;
  }

  Status MakeLevels()
  {
    std::uint64_t inconsistent = 0;
    Status status =
      Take(BuildLevelsTogether(this->Team, this->Files, this->Mesh, this->Options.levels,
             this->Memory, this->Exec,
             [&](const TreeBlock& block)
             {
               inconsistent += CountInconsistentEdges(block.mesh.triangles,
                 block.mesh.points.size(), this->Exec, [&](VertexId v) { return block.IsOwn(v); });
             }),
        this->Levels);
    status = status ? this->Team.Sum(std::span(&inconsistent, 1)) : status;
    this->Facts.inconsistentEdges = inconsistent;
    return status;
  }

  StoreInfo Describe()
  {
    ModelFacts& facts = this->Facts;
    facts.vertices = this->Mesh.vertexCount;
    facts.triangles = this->Mesh.triangleCount;
    facts.depths = this->Mesh.depths;
    facts.partitions = std::uint64_t{ 1 } << facts.depths.partition;
    facts.smallestPartition = facts.vertices >> facts.depths.partition;
    facts.largestPartition = (facts.vertices + facts.partitions - 1) >> facts.depths.partition;
    facts.box = this->Mesh.box;
    facts.scalarType = this->Mesh.scalarType;
    facts.attributes = this->Mesh.attributes;
    BuildOptions used = this->Options;
    used.weld = this->Weld;
    return DescribeModel(used, facts,
      this->Options.inputName.empty() ? this->Input.filename().string() : this->Options.inputName);
  }

  Status WriteStore()
  {
    const StoreInfo description = this->Describe();
    std::unique_ptr<StoreWriter> writer;
    Status status;
    if (this->Team.IsFirst())
    {
      status = Take(StoreWriter::Create(this->Store, description), writer);
      status = status ? WriteTreePages(this->Boxes, this->Mesh.depths, *writer) : status;
    }
    if (status)
    {
      status = this->WritePieces(description.Codec(), writer.get());
    }
    this->Report.info = description;
    // Before the store is put in place all agree that nobody has failed.
    status = status ? this->Team.Finish() : status;
    if (status && this->Team.IsFirst())
    {
      status = Take(writer->Finish(), this->Report.info);
    }
    this->Clock.Finish("write");
    return status;
  }

  Status WritePieces(const CodecContext& codec, StoreWriter* writer)
  {
    TeamPieces pieces(this->Team, this->Files, writer);
    std::uint64_t triangles = 0; // of this rank's pieces of the resolution
    const PieceSink add = [&](const Piece& piece, std::span<const std::uint8_t> blob)
    { return pieces.Add(piece, blob); };
    const PartVisit visit = [&](const VertexTree& tree, const kdstream::Mesh& part,
                              Resolution resolution, const ModelPart& cut)
    {
      const PieceCutter cutter(tree, part, resolution, this->Exec, cut);
      const auto all = double(std::size_t{ 1 } << PieceDepth(resolution, this->Mesh.depths));
      const Status status =
        EncodePieces(cutter, cutter.PieceCount(), codec, add, this->Clock, this->Exec,
          [&](std::size_t written)
          {
            const double done = double(cut.firstPiece + written) / all;
            return this->Exec.Report("encode", EncodedPart(resolution, this->Mesh.depths, done));
          });
      triangles += cutter.TriangleCount();
      ReturnFreeMemory(this->Mesh.keptMemory);
      return status;
    };
    return ForEachPart(this->Mesh, this->Levels, this->Numbers, visit, this->Exec, &this->Team,
      [&](Resolution resolution)
      {
        const Status status = pieces.Finish(resolution, triangles);
        triangles = 0;
        return status;
      });
  }

  MpiTeam& Team;
  SpillFolder Files;
  const std::filesystem::path Input, Store;
  const BuildOptions& Options;
  const Execution& Exec;
  std::uint64_t Memory;
  StepClock Clock;
  SpilledMesh Share;
  TeamVertices Vertices;
  MeshBlocks Mesh;
  std::vector<Box> Boxes;
  ExternalLevels Levels;
  ExternalNumbers Numbers;
  ModelFacts Facts;
  std::uint64_t Triangles = 0; // of all ranks
  bool Weld = true;
  BuildReport Report;
};

Status CheckOptions(const BuildOptions& options)
{
  if (options.partitioner != Partitioner::KdTree)
  {
    return Error{ ErrorCode::Unsupported,
      "stores by octree and k-means are for comparison alone: kdstream-build makes them" };
  }
  if (options.resume)
  {
    return Error{ ErrorCode::Unsupported,
      "interrupted builds are resumed by kdstream-build alone" };
  }
  if (options.memory < leastMemory)
  {
    return Error{ ErrorCode::LimitExceeded, "building on several ranks takes at least " +
                                              Mebibytes(leastMemory) + " on each; the limit is " +
                                              Mebibytes(options.memory) };
  }
  return {};
}

Result<BuildReport> BuildHere(MpiTeam& team, const std::filesystem::path& input,
  const std::filesystem::path& store, const BuildOptions& options, const Execution& execution,
  std::uint64_t stepMemory)
{
  KDSTREAM_TRY(CheckOptions(options));
  const std::filesystem::path beside = store.has_parent_path() ? store.parent_path() : ".";
  Result<SpillFolder> folder =
    SpillFolder::Create(options.temporaryFolder.empty() ? beside : options.temporaryFolder);
  KDSTREAM_TRY(folder);
  return TeamBuilder(team, std::move(*folder), input, store, options, execution, stepMemory)
    .Build();
}

}

Result<BuildReport> BuildStoreTogether(MpiTeam& team, const std::filesystem::path& input,
  const std::filesystem::path& store, const BuildOptions& options, const Execution& execution,
  std::uint64_t stepMemory)
{
  Result<BuildReport> report = Error{};
  try
  {
    report = BuildHere(team, input, store, options, execution, stepMemory);
  }
  catch (...) // the others wait: they must be told
  {
    report = CaughtError();
  }
  return report ? std::move(report) : team.Fail(report.GetError());
}

}
