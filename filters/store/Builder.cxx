// The build in memory: see Builder.h. Steps: read, weld, tree, levels, number, cut and encode,
// store.
#include "filters/store/Builder.h"

#include "filters/core/VertexTree.h"
#include "filters/core/Weld.h"
#include "filters/meshio/MeshReader.h"
#include "filters/store/StoreWriter.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace kdstream
{
namespace
{

constexpr std::size_t readChunk = std::size_t{ 1 } << 18; // vertices or faces
constexpr std::uint64_t bytesPerCluster = 560;            // measured
constexpr std::size_t encodeBatch = 64;                   // pieces encoded before they are written

// Adds the time since the last call to a named step.
class StepClock
{
public:
  void Finish(const std::string& step)
  {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - this->Last).count();
    this->Last = now;
    const auto found = std::find_if(this->Steps.begin(), this->Steps.end(),
      [&](const auto& entry) { return entry.first == step; });
    if (found == this->Steps.end())
    {
      this->Steps.emplace_back(step, seconds);
    }
    else
    {
      found->second += seconds;
    }
  }
  std::vector<std::pair<std::string, double>> Take()
  {
    double total = 0;
    for (const auto& entry : this->Steps)
    {
      total += entry.second;
    }
    this->Steps.emplace_back("total", total);
    return std::move(this->Steps);
  }

private:
  std::chrono::steady_clock::time_point Last = std::chrono::steady_clock::now();
  std::vector<std::pair<std::string, double>> Steps;
};

std::string Mebibytes(std::uint64_t bytes)
{
  return bytes < 1 << 20 ? std::to_string(bytes >> 10) + " KiB"
                         : std::to_string(bytes >> 20) + " MiB";
}

// The least that the mesh needs: a cluster a cell. What more there are is checked once the sheets
// are known.
Status CheckMemory(std::uint64_t vertices, std::uint64_t triangles, const BuildOptions& options)
{
  const Result<TreeDepths> depths = ComputeDepths(vertices, options.tree);
  const std::uint64_t need =
    EstimateBuildMemory(vertices, triangles, depths ? std::uint64_t{ 1 } << depths->finest : 0);
  if (options.memory == 0 || need <= options.memory)
  {
    return {};
  }
  return Error{ ErrorCode::LimitExceeded,
    "needs about " + Mebibytes(need) + " of memory for " + std::to_string(vertices) +
      " vertices and " + std::to_string(triangles) + " triangles; the limit is " +
      Mebibytes(options.memory) + " (building out of core is not supported yet)" };
}

// The most clusters of the finest level that the limit leaves room for.
std::uint64_t MostClusters(const Mesh& mesh, std::uint64_t limit)
{
  const std::uint64_t rest = EstimateBuildMemory(mesh.points.size(), mesh.triangles.size(), 0);
  return limit == 0
           ? 0
           : std::max<std::uint64_t>(1, limit > rest ? (limit - rest) / bytesPerCluster : 0);
}

Result<Mesh> ReadMesh(MeshReader& reader, const BuildOptions& options, const Execution& execution)
{
  const MeshFileInfo& info = reader.Info();
  // What the header claims is a reason to refuse only if the file is large enough to hold it: 3
  // bytes a vertex and a face are the least.
  if (info.vertices <= reader.FileSize() / 3 && info.faces <= reader.FileSize() / 3)
  {
    if (Status status = CheckMemory(info.vertices, info.faces, options); !status)
    {
      return status.GetError();
    }
  }
  Mesh mesh;
  mesh.scalarType = info.scalarType;
  const auto report = [&]()
  {
    const double size = std::max(1.0, double(reader.FileSize()));
    return execution.Report("read", double(reader.Position()) / size);
  };
  for (bool triangles : { false, true })
  {
    for (;;)
    {
      const Result<std::size_t> read =
        triangles ? reader.ReadTriangles(mesh, readChunk) : reader.ReadVertices(mesh, readChunk);
      if (!read)
      {
        return read.GetError();
      }
      if (*read == 0)
      {
        break;
      }
      if (Status status = CheckMemory(mesh.points.size(), mesh.triangles.size(), options); !status)
      {
        return status.GetError();
      }
      if (Status status = report(); !status)
      {
        return status.GetError();
      }
    }
  }
  if (mesh.triangles.size() >= noVertex)
  {
    return Error{ ErrorCode::LimitExceeded,
      std::to_string(mesh.triangles.size()) +
        " triangles; at most 4294967294 fit a build in memory" };
  }
  return mesh;
}

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

  Result<BuildReport> Build(const std::string& name, const std::filesystem::path& store)
  {
    Result<VertexTree> numbered = this->BuildTree();
    if (!numbered)
    {
      return numbered.GetError();
    }
    this->Information.input = name;
    this->Clock.Finish("levels");
    Result<std::unique_ptr<StoreWriter>> writer = StoreWriter::Create(store, this->Information);
    if (!writer)
    {
      return writer.GetError();
    }
    if (Status status = this->WritePieces(*numbered, **writer); !status)
    {
      return status.GetError();
    }
    Result<StoreInfo> info = (*writer)->Finish();
    if (!info)
    {
      return info.GetError();
    }
    this->Clock.Finish("write");
    BuildReport report;
    report.info = std::move(*info);
    report.mergedByGrid = this->MergedByGrid;
    report.seconds = this->Clock.Take();
    return report;
  }

private:
  // Weld, tree, faces, levels, numbers; fills in what the store says of the model.
  Result<VertexTree> BuildTree()
  {
    StoreInfo& info = this->Information;
    if (this->Input.points.empty())
    {
      return Error{ ErrorCode::InvalidInput, "the mesh has no vertices" };
    }
    info.weld = this->Options.weld;
    info.welded = info.weld ? WeldVertices(this->Input) : 0;
    Result<PartitionTree> partitioned =
      PartitionMesh(this->Input, this->Options.partitioner, this->Options.tree, this->Exec);
    if (!partitioned)
    {
      return partitioned.GetError();
    }
    KdTree& tree = partitioned->tree;
    info.partitions = partitioned->partitions;
    info.box = tree.boxes[1];
    info.grid = this->Options.bits == 0
                  ? CoordinateGrid::Exact(this->Input.scalarType)
                  : CoordinateGrid::Over(info.box, this->Options.bits, this->Input.scalarType);
    this->CountMergedByGrid();
    this->Clock.Finish("tree");
    info.inconsistentEdges =
      CountInconsistentEdges(this->Input.triangles, this->Input.points.size(), this->Exec);
    this->Describe(tree);
    this->Clock.Finish("faces");
    Result<ClusterLevels> levels = this->Options.partitioner == Partitioner::KdTree
                                     ? this->MakeLevels(tree)
                                     : Result<ClusterLevels>(ClusterLevels{});
    if (!levels)
    {
      return levels.GetError();
    }
    this->Boxes = std::move(tree.boxes);
    return NumberVertices(tree, std::move(*levels));
  }

  Result<ClusterLevels> MakeLevels(const KdTree& tree)
  {
    const std::vector<std::uint32_t> partition = CellOfVertex(tree, tree.depths.partition);
    const TriangleBuckets buckets = BucketTriangles(this->Input.triangles,
      std::size_t{ 1 } << tree.depths.partition, [&](VertexId v) { return partition[v]; });
    LevelOptions options = this->Options.levels;
    options.mostClusters = MostClusters(this->Input, this->Options.memory);
    Result<ClusterLevels> levels = BuildLevels(this->Input, tree, buckets, options, this->Exec);
    if (!levels && levels.GetError().code == ErrorCode::LimitExceeded)
    {
      return Error{ ErrorCode::LimitExceeded,
        levels.GetError().message + " with " + Mebibytes(this->Options.memory) +
          " of memory (building out of core is not supported yet)" };
    }
    return levels;
  }

  void CountMergedByGrid()
  {
    if (this->Information.grid.Lossless())
    {
      return;
    }
    const auto places = [](const std::vector<Vec3>& points)
    {
      const std::vector<VertexId> first = FirstCoincident(points, Coincidence::ValueEqual);
      std::uint64_t count = 0;
      for (VertexId v = 0; v < first.size(); ++v)
      {
        count += first[v] == v;
      }
      return count;
    };
    std::vector<Vec3> snapped(this->Input.points.size());
    std::transform(this->Input.points.begin(), this->Input.points.end(), snapped.begin(),
      [&](const Vec3& p) { return this->Information.grid.Snap(p); });
    this->MergedByGrid = places(this->Input.points) - places(snapped);
  }

  void Describe(const KdTree& tree)
  {
    StoreInfo& info = this->Information;
    info.depths = tree.depths;
    info.primitive =
      this->Input.triangles.empty() ? PrimitiveType::Points : PrimitiveType::Triangles;
    info.vertices = this->Input.points.size();
    info.triangles = this->Input.triangles.size();
    info.partitioner = NameOf(this->Options.partitioner);
    info.smallestPartition = info.vertices;
    for (std::size_t p = 0; p < info.partitions; ++p)
    {
      const std::uint64_t size = tree.Cell(tree.depths.partition, p).size();
      info.smallestPartition = std::min(info.smallestPartition, size);
      info.largestPartition = std::max(info.largestPartition, size);
    }
    for (unsigned d = 0; info.HasLevels() && d <= tree.depths.finest; ++d)
    {
      info.levels.push_back({ Resolution::Level(d) });
    }
    info.original.resolution = Resolution::Original();
    info.title = this->Options.title;
    info.credit = this->Options.credit;
    info.license = this->Options.license;
    info.unit = this->Options.unit;
    if (!info.HasLevels())
    {
      return;
    }
    info.levelMaker = this->Options.levels.maker == LevelMaker::Collapse ? "collapse" : "cluster";
    info.representative =
      this->Options.levels.representative == Representative::Quadric ? "quadric" : "mean";
    info.sheets = this->Options.levels.sheets;
  }

  Status WritePieces(const VertexTree& numbered, StoreWriter& writer)
  {
    for (const NodeId page : TreePages(numbered.depths))
    {
      if (Status status =
            writer.AddTreePage(page, EncodeTreePage(this->Boxes, page, numbered.depths));
          !status)
      {
        return status;
      }
    }
    for (unsigned d = 0; d < numbered.levels.size(); ++d)
    {
      if (Status status = this->WriteResolution(numbered, Resolution::Level(d), writer); !status)
      {
        return status;
      }
    }
    return this->WriteResolution(numbered, Resolution::Original(), writer);
  }

  Status WriteResolution(const VertexTree& numbered, Resolution resolution, StoreWriter& writer)
  {
    const PieceCutter cutter(numbered, this->Input, resolution);
    const std::size_t pieceCount =
      resolution.IsOriginal() ? this->Information.partitions : cutter.PieceCount();
    const CodecContext context = this->Information.Codec();
    std::vector<Piece> pieces(encodeBatch);
    std::vector<std::vector<std::uint8_t>> blobs(encodeBatch);
    for (std::size_t first = 0; first < pieceCount; first += encodeBatch)
    {
      const std::size_t count = std::min(encodeBatch, pieceCount - first);
      this->Exec.parallelFor(count, 1,
        [&](std::size_t begin, std::size_t end)
        {
          for (std::size_t i = begin; i < end; ++i)
          {
            pieces[i] = cutter.Cut(first + i);
            blobs[i] = EncodePiece(pieces[i], context);
          }
        });
      this->Clock.Finish("encode");
      for (std::size_t i = 0; i < count; ++i)
      {
        if (Status status = writer.AddPiece(pieces[i], blobs[i]); !status)
        {
          return status;
        }
      }
      this->Clock.Finish("write");
      const double part = double(first + count) / double(pieceCount);
      const double done = resolution.IsOriginal()
                            ? 0.5 + 0.5 * part
                            : 0.5 * (resolution.Depth() + part) / (numbered.depths.finest + 1);
      if (Status status = this->Exec.Report("encode", done); !status)
      {
        return status;
      }
    }
    writer.FinishResolution(resolution, cutter.TriangleCount());
    return {};
  }

  Mesh Input;
  const BuildOptions& Options;
  const Execution& Exec;
  StepClock Clock;
  StoreInfo Information;
  std::vector<Box> Boxes;
  std::uint64_t MergedByGrid = 0;
};

}

std::uint64_t EstimateBuildMemory(
  std::uint64_t vertices, std::uint64_t triangles, std::uint64_t clusters)
{
  return (std::uint64_t{ 32 } << 20) + 44 * vertices + 40 * triangles + bytesPerCluster * clusters;
}

Result<BuildReport> BuildStore(const std::filesystem::path& input,
  const std::filesystem::path& store, const BuildOptions& options, const Execution& execution)
{
  StepClock clock;
  Result<std::unique_ptr<MeshReader>> reader = MeshReader::Open(input);
  if (!reader)
  {
    return reader.GetError();
  }
  Result<Mesh> mesh = ReadMesh(**reader, options, execution);
  if (!mesh)
  {
    return mesh.GetError();
  }
  clock.Finish("read");
  Result<BuildReport> report =
    StoreBuilder(std::move(*mesh), options, execution, std::move(clock))
      .Build(options.inputName.empty() ? input.filename().string() : options.inputName, store);
  if (report)
  {
    report->ignoredAttributes = (*reader)->Info().ignoredAttributes;
  }
  return report;
}

Result<BuildReport> BuildStore(Mesh mesh, const std::string& name,
  const std::filesystem::path& store, const BuildOptions& options, const Execution& execution)
{
  return StoreBuilder(std::move(mesh), options, execution, {}).Build(name, store);
}

}
