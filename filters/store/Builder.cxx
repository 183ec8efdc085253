// The build in memory: see Builder.h. Steps: read, weld, tree, levels, number, cut and encode,
// store.
#include "filters/store/Builder.h"

#include "filters/core/LeafOrder.h"
#include "filters/core/VertexTree.h"
#include "filters/core/Weld.h"
#include "filters/meshio/MeshReader.h"
#include "filters/store/BuildInput.h"
#include "filters/store/BuildMemory.h"
#include "filters/store/StoreWriter.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace kdstream
{
namespace
{

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
    if (Status status = PrepareMesh(this->Input); !status)
    {
      return status.GetError();
    }
    info.weld = this->Options.weld;
    info.welded = info.weld ? WeldVertices(this->Input, this->Exec) : 0;
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
    if (this->Options.partitioner == Partitioner::KdTree)
    {
      this->BucketByPartition(tree);
    }
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
    VertexTree numbered = NumberVertices(tree, std::move(*levels), this->Exec);
    OrderLeaves(numbered, this->Input.points, this->Exec);
    return numbered;
  }

  void BucketByPartition(const KdTree& tree)
  {
    const std::vector<std::uint32_t> partition = CellOfVertex(tree, tree.depths.partition);
    this->Buckets = BucketTriangles(
      this->Input.triangles, std::size_t{ 1 } << tree.depths.partition,
      [&](VertexId v) { return partition[v]; }, this->Exec);
    // Tuples of triangles would have to move too. Without them the order is not seen in the store.
    const bool bare = std::none_of(this->Input.attributes.begin(), this->Input.attributes.end(),
      [](const Attribute& array) { return array.association == AttributeAssociation::Cell; });
    if (bare && AreScattered(this->Input.triangles, partition))
    {
      GatherTriangles(this->Input.triangles, this->Buckets, partition, this->Exec);
    }
  }

  Result<ClusterLevels> MakeLevels(const KdTree& tree)
  {
    const TriangleBuckets buckets = std::move(this->Buckets);
    LevelOptions options = this->Options.levels;
    options.mayCoincide = !this->AllPlacesDiffer();
    options.mostClusters = MostClusters(
      SizeOf(this->Input), std::uint64_t{ 1 } << tree.depths.partition, this->Options.memory);
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
    return this->Information.weld &&
           std::none_of(this->Input.attributes.begin(), this->Input.attributes.end(),
             [](const Attribute& array)
             { return array.association == AttributeAssociation::Point; }) &&
           std::none_of(this->Input.points.begin(), this->Input.points.end(),
             [](const Vec3& p) {
               return std::any_of(
                 p.begin(), p.end(), [](double x) { return x == 0 && std::signbit(x); });
             });
  }

  void CountMergedByGrid()
  {
    if (this->Information.grid.Lossless())
    {
      return;
    }
    const std::vector<Vec3>& points = this->Input.points;
    const CoordinateGrid& grid = this->Information.grid;
    const std::size_t places =
      this->AllPlacesDiffer() ? points.size()
                              : CountPlaces(
                                  points.size(), [&](VertexId v) { return points[v]; }, this->Exec);
    this->MergedByGrid =
      places - CountPlaces(
                 points.size(), [&](VertexId v) { return grid.Snap(points[v]); }, this->Exec);
  }

  void Describe(const KdTree& tree)
  {
    StoreInfo& info = this->Information;
    info.depths = tree.depths;
    info.primitive =
      this->Input.triangles.empty() ? PrimitiveType::Points : PrimitiveType::Triangles;
    info.vertices = this->Input.points.size();
    info.triangles = this->Input.triangles.size();
    for (const Attribute& attribute : this->Input.attributes)
    {
      info.attributes.push_back(attribute.Info());
    }
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
    const PieceCutter cutter(numbered, this->Input, resolution, this->Exec);
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
  TriangleBuckets Buckets; // the triangles by partition, from faces to levels
  std::vector<Box> Boxes;
  std::uint64_t MergedByGrid = 0;
};

}

Result<BuildReport> BuildStore(const std::filesystem::path& input,
  const std::filesystem::path& store, const BuildOptions& options, const Execution& execution)
{
  StepClock clock;
  // What a reader must spill goes beside the store.
  Result<std::unique_ptr<MeshReader>> reader =
    MeshReader::Open(input, execution, store.has_parent_path() ? store.parent_path() : ".");
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
  BuildOptions used = options;
  used.weld = options.weld || (*reader)->Info().soup;
  Result<BuildReport> report =
    StoreBuilder(std::move(*mesh), used, execution, std::move(clock))
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
