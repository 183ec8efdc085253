// SPDX-License-Identifier: BSD-3-Clause
#include "filters/outofcore/levels/LevelSteps.h"

#include "filters/core/TakeResult.h"
#include "filters/core/VectorMath.h"
#include "filters/core/levels/CollapseRound.h"
#include "filters/core/levels/FinestClusters.h"
#include "filters/core/levels/FoldOverRepair.h"
#include "filters/core/levels/FreeCollapse.h"
#include "filters/core/levels/LevelAttributes.h"
#include "filters/core/levels/LevelProgress.h"
#include "filters/core/tree/PieceDepth.h"
#include "filters/outofcore/files/RecordFile.h"
#include "filters/outofcore/files/ReturnFreeMemory.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace kdstream
{
namespace
{

// The share of the step's progress that belongs to the finest level.
constexpr double finestShare = 0.4;
// When levels are made by clusters, one with at most this number of clusters is the finest to be
// held whole in memory.
constexpr VertexId mostInMemory = 1 << 14;

// Writes the sums to a file, and reads them back.
class SumsInFile : public SumsAside
{
public:
  explicit SumsInFile(SpillFolder& folder)
    : Folder(folder)
  {
  }

  Status Put(std::vector<ClusterSum>& sums) override
  {
    this->Count = sums.size();
    KDSTREAM_TRY(Take(
      this->Folder.CreateFile("sums of clusters", this->Count * sizeof(ClusterSum)), this->File));
    KDSTREAM_TRY(WriteRecords<ClusterSum>(this->File, 0, std::span<const ClusterSum>(sums)));
    sums = std::vector<ClusterSum>();
    ReturnFreeMemory(); // also what the previous level left
    return {};
  }

  Status Return(std::vector<ClusterSum>& sums) override
  {
    sums.resize(this->Count);
    KDSTREAM_TRY(ReadRecords<ClusterSum>(this->File, 0, std::span<ClusterSum>(sums)));
    this->File = {};
    return {};
  }

private:
  SpillFolder& Folder;
  SpillFile File;
  std::size_t Count = 0;
};

// Gives a cluster its new position and geometric error. moved: its cluster is a number in the
// level.
Status MoveTo(const MovedCluster& moved, LevelFile& level, LevelStates& states)
{
  ClusterRecord record;
  ClusterState state;
  KDSTREAM_TRY(ReadRecords<ClusterRecord>(
    level.clusters, moved.cluster, std::span<ClusterRecord>(&record, 1)));
  KDSTREAM_TRY(
    ReadRecords<ClusterState>(states.sums, moved.cluster, std::span<ClusterState>(&state, 1)));
  record.position = moved.position;
  record.geometricError = state.sum.geometricError = moved.geometricError;
  KDSTREAM_TRY(WriteRecords<ClusterRecord>(
    level.clusters, moved.cluster, std::span<const ClusterRecord>(&record, 1)));
  return WriteRecords<ClusterState>(
    states.sums, moved.cluster, std::span<const ClusterState>(&state, 1));
}

}

LevelSteps::LevelSteps(
  const MeshBlocks& mesh, const LevelOptions& options, const Execution& execution)
  : Mesh(mesh)
  , Options(options)
  , Exec(execution)
  , Space{ CentreOf(mesh.box), mesh.box }
  , Clusters(options.maker == LevelMaker::Cluster || mesh.triangleCount == 0)
  , Rules{ options, mesh.depths.finest, this->Space.origin }
  , JoinsCoincident(
      options.mayCoincide && (!this->Clusters || (options.byComponents && mesh.triangleCount > 0)))
  , MayCoincide(this->JoinsCoincident && mesh.mayCoincide)
{
  this->LevelsArrays.attributes = ArraysOfLevels(mesh.attributes);
  for (const AttributeInfo& attribute : this->LevelsArrays.attributes)
  {
    const bool normals = RoleOf(attribute) == AttributeRole::Normals;
    this->LevelsArrays.components += normals && !this->Clusters ? attribute.components : 0;
  }
  if (!this->Clusters)
  {
    this->LevelsArrays.vertexColors = PlaceOfVertexColors(this->LevelsArrays.attributes);
  }
}

unsigned LevelSteps::BlockDepthOf(unsigned level, unsigned most) const
{
  return level == 0 ? 0
                    : std::min(most, PieceDepth(Resolution::Level(level - 1), this->Mesh.depths));
}

bool LevelSteps::IsCoarserInFiles(const LevelFile& level, const LevelStates& states) const
{
  if (level.depth == 0 || !this->Clusters)
  {
    return level.depth > 0 && CollapsesInParts(this->Mesh.depths, level.depth - 1,
                                level.ClusterCount(), static_cast<std::size_t>(states.triangles));
  }
  return level.depth > this->Mesh.depths.stitch || level.ClusterCount() > mostInMemory;
}

Status LevelSteps::ReportFinest(double done) const
{
  return this->Exec.Report("levels", finestShare * done);
}

Status LevelSteps::ReportLevel(unsigned depth, double done) const
{
  const double made = CoarserPart(depth + 1 - done, this->Mesh.depths.finest);
  return this->Exec.Report("levels", finestShare + (1 - finestShare) * made);
}

Status LevelSteps::BuildFinestBlock(
  const TreeBlock& block, VertexId firstCluster, SpillFile& clusterOfRank, LevelWriter& writer)
{
  const KdTree tree = TreeOfBlock(this->Mesh, block);
  const std::vector<std::uint32_t> partition =
    CellOfVertex(tree, tree.depths.partition, block.mesh.points.size());
  const std::size_t partitions = std::size_t{ 1 } << tree.depths.partition;
  TriangleBuckets buckets = BucketTriangles(
    block.mesh.triangles, partitions + 1,
    [&](VertexId v) { return std::min<std::size_t>(partition[v], partitions); }, this->Exec);
  buckets.begin.pop_back(); // drops the triangles whose three corners are ghosts

  Execution quiet = this->Exec;
  quiet.progress = [](std::string_view, double) { return true; };
  Result<FinestClusters> finest = BuildFinestClusters(
    { block.mesh.points, block.mesh.triangles, tree, buckets, this->Space.origin, block.ids,
      this->Clusters ? nullptr : FindVertexColors(block.mesh.attributes) },
    this->OptionsFor(block), quiet);
  KDSTREAM_TRY(finest);
  CollapseState state;
  if (!this->Clusters)
  {
    state.attributes =
      MeanAttributes(block.mesh, finest->clusterOf, finest->clusters, DiagonalOf(this->Mesh.box));
  }
  AttributeSums sums(this->LevelsArrays.attributes, finest->clusters.size());
  sums.AddVertices(block.mesh.attributes, finest->clusterOf);
  state.level = std::move(finest->level);
  state.clusters = std::move(finest->clusters);
  state.cellOf = std::move(finest->cellOf);
  const auto firstCell = static_cast<std::uint32_t>(block.cell << tree.depths.finest);
  for (std::uint32_t& cell : state.cellOf)
  {
    cell += firstCell;
  }
  std::vector<VertexId> clusters(block.order.size());
  std::transform(block.order.begin(), block.order.end(), clusters.begin(),
    [&](VertexId v) { return firstCluster + finest->clusterOf[v]; });
  KDSTREAM_TRY(
    WriteRecords<VertexId>(clusterOfRank, block.firstRank, std::span<const VertexId>(clusters)));
  return writer.Append(state, sums);
}

// If welding left one vertex in each place, two vertices can still coincide as 0.0 and -0.0. Then
// the block has a negative zero.
LevelOptions LevelSteps::OptionsFor(const TreeBlock& block)
{
  const bool negative =
    std::any_of(block.mesh.points.begin(), block.mesh.points.end(), HasNegativeZero);
  LevelOptions options = this->Options;
  options.mayCoincide = this->JoinsCoincident && (this->Mesh.mayCoincide || negative);
  options.joinCoincident = !this->Clusters;
  this->MayCoincide |= options.mayCoincide;
  return options;
}

Status LevelSteps::RepairFoldOvers(
  SpillFolder& folder, LevelFile& level, LevelStates& states, const BlockRange& here) const
{
  SpillFile file;
  KDSTREAM_TRY(Take(folder.CreateFile("clusters that move", 0), file));
  RecordWriter<MovedCluster> writer(file);
  for (std::size_t block = here.begin; block < here.end; ++block)
  {
    Result<LevelBlock> loaded = LoadLevelBlock(level, block);
    KDSTREAM_TRY(loaded);
    const Result<CollapseState> state = LoadState(level, states, this->LevelsArrays, *loaded);
    KDSTREAM_TRY(state);
    const BlockParts parts = PartsOfLevel(this->Mesh.depths, level.depth, level.blockDepth, block);
    for (MovedCluster& moved :
      kdstream::RepairFoldOvers(*state, this->Space, level.depth, parts, this->Exec))
    {
      moved.cluster = loaded->clusters[moved.cluster];
      writer.Append(moved);
    }
  }
  KDSTREAM_TRY(writer.Finish());
  RecordReader<MovedCluster> reader(file, 0, writer.Position());
  std::span<const MovedCluster> some;
  do
  {
    const Result<std::span<const MovedCluster>> read = reader.Next();
    KDSTREAM_TRY(read);
    some = *read;
    for (const MovedCluster& moved : some)
    {
      KDSTREAM_TRY(MoveTo(moved, level, states));
    }
  } while (!some.empty());
  return {};
}

Status LevelSteps::Collapse(FileLevelBlocks& blocks, unsigned depth) const
{
  const std::function<Status(double)> report = [&](double done)
  {
    ReturnFreeMemory(this->Mesh.keptMemory);
    return this->ReportLevel(depth, done);
  };
  KDSTREAM_TRY(blocks.Begin());
  return CollapseRound(blocks, this->Mesh.depths, depth, this->Space, this->Options.representative,
    this->Options.byComponents, this->Exec, report)
    .Run();
}

Status LevelSteps::Join(
  SpillFolder& folder, const LinkedLevel& below, unsigned depth, LevelWriter& writer) const
{
  const std::function<Status(double)> report = [&](double done)
  {
    ReturnFreeMemory(this->Mesh.keptMemory);
    return this->ReportLevel(depth, done);
  };
  return MakeCoarserClustersInFiles(
    folder, below, depth, this->LevelsArrays, this->Rules, writer, this->Exec, report);
}

Result<std::vector<ClusterLevel>> LevelSteps::BuildCoarse(
  SpillFolder& folder, LevelFile& level, LevelStates states, const LevelLinks& links) const
{
  if (level.depth == 0)
  {
    return std::vector<ClusterLevel>{};
  }
  ReturnFreeMemory(); // of the rounds; a whole level and its collapse need memory next
  Result<LevelBlock> whole = LoadWholeLevel(level);
  KDSTREAM_TRY(whole);
  Result<CollapseState> state = LoadState(level, states, this->LevelsArrays, *whole);
  KDSTREAM_TRY(state);
  states.sums = {};
  states.components = {};
  Result<std::vector<ClusterLevel>> levels =
    this->MakeCoarse(folder, std::move(*state), level, links);
  KDSTREAM_TRY(levels);
  Result<AttributeSums> sums =
    LoadAttributeSums(states, this->LevelsArrays, 0, level.ClusterCount());
  KDSTREAM_TRY(sums);
  states = {};
  for (unsigned d = level.depth; d-- > 0;)
  {
    const ClusterLevel& below = (*levels)[d + 1];
    sums = sums->MakeCoarser(below.parents, below.lowest, (*levels)[d].lowest.size());
    (*levels)[d].attributes = sums->Means();
    PutVertexColors(std::exchange((*levels)[d].vertexColors, {}), (*levels)[d].attributes);
  }
  Result<SpillFile> parents = folder.CreateFile(
    "parents of clusters", level.ClusterCount() * std::uint64_t{ sizeof(VertexId) });
  KDSTREAM_TRY(parents);
  level.parents = std::move(*parents);
  const std::vector<VertexId>& parentOf = (*levels)[level.depth].parents;
  KDSTREAM_TRY(WriteRecords<VertexId>(level.parents, 0, std::span<const VertexId>(parentOf)));
  levels->pop_back();
  return levels;
}

// The level and all coarser ones, [depth], without attributes.
Result<std::vector<ClusterLevel>> LevelSteps::MakeCoarse(
  SpillFolder& folder, CollapseState&& state, const LevelFile& level, const LevelLinks& links) const
{
  if (!this->Clusters)
  {
    SumsInFile aside(folder);
    return BuildCoarserLevels(std::move(state), level.depth, this->Mesh.depths, this->Mesh.box,
      this->Options, aside, this->Exec);
  }
  std::vector<Triangle> triangles;
  KDSTREAM_TRY(links.Load(0, level.BlockCount(), triangles));
  std::vector<Link> pairs;
  std::for_each(
    triangles.begin(), triangles.end(), [&](const Triangle& link) { AppendLinkOf(link, pairs); });
  return BuildCoarserClusterLevels(
    std::move(state), std::move(pairs), level.depth, this->Rules, this->Exec);
}

}
