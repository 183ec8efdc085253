// SPDX-License-Identifier: BSD-3-Clause
// Stores made by the baselines: partitions without levels.
#include "Testing/Fixtures/Invariants.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/baselines/stores/Baselines.h"
#include "filters/build/Builder.h"
#include "filters/core/pieces/Glue.h"
#include "filters/core/tree/Region.h"
#include "filters/program/TbbExecution.h"
#include "filters/store/StoreMesh.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <set>

using namespace kdstream;
using namespace kdstream::fixtures;
namespace fs = std::filesystem;

namespace
{

class BaselineStore : public ::testing::TestWithParam<const PartitionMethod*>
{
protected:
  BaselineStore()
    : File(fs::temp_directory_path() / ("kdstream-baseline-" + std::to_string(::getpid()) + ".kds"))
  {
  }
  ~BaselineStore() override { fs::remove(this->File); }

  static BuildOptions Lossless()
  {
    BuildOptions options;
    options.partitioner = GetParam();
    options.tree.verticesPerPartition = 200;
    options.bits = 0;
    options.weld = false;
    return options;
  }

  fs::path File;
};

TEST_P(BaselineStore, HoldsPartitionsAndNoLevels)
{
  for (const NamedMesh& named : AllMeshes())
  {
    SCOPED_TRACE(named.name);
    const Result<BuildReport> report = BuildStore(named.mesh, "mesh", this->File, Lossless());
    ASSERT_TRUE(report) << report.GetError().message;
    const auto opened = Store::Open(this->File);
    ASSERT_TRUE(opened) << opened.GetError().message;
    const Store& store = **opened;
    const ModelDescription& info = store.Info();
    EXPECT_TRUE(store.Verify().empty());
    EXPECT_FALSE(info.HasLevels());
    EXPECT_TRUE(info.levels.empty());
    EXPECT_EQ(info.partitioner, GetParam()->Name());
    EXPECT_EQ(store.PieceIds().size(), info.partitions);
    EXPECT_EQ(info.original.pieces, info.partitions);

    std::vector<Piece> pieces;
    std::uint64_t smallest = info.vertices, largest = 0, sum = 0;
    for (const PieceId id : store.PieceIds())
    {
      Result<Piece> piece = store.ReadPiece(id);
      ASSERT_TRUE(piece) << piece.GetError().message;
      smallest = std::min<std::uint64_t>(smallest, piece->ownVertices);
      largest = std::max<std::uint64_t>(largest, piece->ownVertices);
      sum += piece->ownVertices;
      pieces.push_back(std::move(*piece));
    }
    EXPECT_GE(smallest, 1U);
    EXPECT_EQ(smallest, info.smallestPartition);
    EXPECT_EQ(largest, info.largestPartition);
    EXPECT_EQ(sum, info.vertices);
    Result<Mesh> all = GluePartitions(pieces, info.grid.scalarType);
    ASSERT_TRUE(all);
    EXPECT_TRUE(AddUnused(store, *all));
    EXPECT_EQ(PointMultiset(*all), PointMultiset(named.mesh));
    EXPECT_EQ(TriangleMultiset(*all), TriangleMultiset(named.mesh));

    for (const PieceId missing : { PieceId{ Resolution::Level(0), 1 },
           PieceId{ Resolution::Level(info.depths.finest), NodeId{ 1 } },
           PieceId{ Resolution::Original(),
             static_cast<NodeId>((1U << info.depths.partition) + info.partitions) } })
    {
      ASSERT_FALSE(store.Read(BlobOfPiece(missing, store.Info().depths)));
      EXPECT_EQ(
        store.Read(BlobOfPiece(missing, store.Info().depths)).GetError().code, ErrorCode::NotFound);
    }
  }
}

TEST_P(BaselineStore, AnswersRegionsByItsPartitionsBoxes)
{
  const Mesh mesh = Torus(120, 60);
  ASSERT_TRUE(BuildStore(mesh, "mesh", this->File, Lossless()));
  const auto store = *Store::Open(this->File);
  const ModelDescription& info = store->Info();
  const std::vector<Box> boxes = *store->ReadBoxes();
  const NodeId cell = NodeOfPartition(3, info.depths);
  double grow = 0;
  for (std::size_t k = 0; k < 3; ++k)
  {
    grow += (boxes[cell].hi[k] - boxes[cell].lo[k]) / 3;
  }
  std::set<std::uint32_t> expected;
  for (std::uint32_t p = 0; p < info.partitions; ++p)
  {
    // The boxes in the store must be those of the stored vertices.
    const Piece piece =
      *store->ReadPiece({ Resolution::Original(), NodeOfPartition(p, info.depths) });
    Box box;
    for (std::uint32_t v = 0; v < piece.ownVertices; ++v)
    {
      box.Add(piece.positions[v]);
    }
    bool touches = true;
    for (std::size_t k = 0; k < 3; ++k)
    {
      touches &= box.lo[k] <= boxes[cell].hi[k] + grow && box.hi[k] >= boxes[cell].lo[k] - grow;
    }
    if (touches)
    {
      expected.insert(p);
    }
  }
  const auto region = FindRegion(boxes, info.depths, cell, 1);
  ASSERT_TRUE(region);
  EXPECT_EQ(std::set<std::uint32_t>(region->begin(), region->end()), expected);
  EXPECT_GT(expected.size(), 3U);
  EXPECT_LT(expected.size(), info.partitions);
  EXPECT_EQ(region->front(), 3U);
}

TEST_P(BaselineStore, OneDigestForAnyNumberOfThreads)
{
  const Mesh mesh = DisplacedSphere(5);
  std::set<std::string> digests;
  for (const unsigned threads : { 1U, 2U, 8U })
  {
    digests.insert(
      BuildStore(mesh, "mesh", this->File, Lossless(), MakeTbbExecution(threads))->info.digest);
  }
  EXPECT_EQ(digests.size(), 1U);
}

TEST_P(BaselineStore, TakesAnyNumberOfPartitionsUpToTheVertices)
{
  const Mesh mesh = Torus(30, 20);
  for (const std::uint32_t wanted : { 1U, 7U, 100U, 600U })
  {
    BuildOptions options = Lossless();
    options.tree.partitions = wanted;
    const auto report = BuildStore(mesh, "mesh", this->File, options);
    ASSERT_TRUE(report) << report.GetError().message;
    if (GetParam() == &KMeansMethod())
    {
      EXPECT_EQ(report->info.partitions, wanted);
    }
    EXPECT_TRUE((*Store::Open(this->File))->Verify().empty());
  }
  BuildOptions options = Lossless();
  options.tree.partitions = 601;
  const auto report = BuildStore(mesh, "mesh", this->File, options);
  ASSERT_FALSE(report);
  EXPECT_NE(report.GetError().message.find("601"), std::string::npos) << report.GetError().message;
  EXPECT_NE(report.GetError().message.find("600"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(Partitioners, BaselineStore,
  ::testing::Values(&OctreeMethod(), &KMeansMethod()),
  [](const auto& parameter) { return std::string(parameter.param->Name()); });

}
