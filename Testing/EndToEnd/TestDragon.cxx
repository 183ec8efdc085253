// SPDX-License-Identifier: BSD-3-Clause
// The Stanford dragon through all of core: a real scan, on which the promises of
// doc/design.md#promises are tested.
#include "Testing/Fixtures/Invariants.h"
#include "Testing/Fixtures/Model.h"
#include "Testing/Fixtures/ReadMeshFile.h"
#include "filters/build/Builder.h"
#include "filters/core/VectorMath.h"
#include "filters/core/Weld.h"
#include "filters/core/pieces/Glue.h"
#include "filters/core/tree/Region.h"
#include "filters/meshio/MeshReader.h"
#include "filters/program/TbbExecution.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <random>
#include <set>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

const Mesh& Dragon()
{
  static const Mesh dragon = ReadMeshFile(KDSTREAM_DRAGON); // Data/fetch-dragon fetches it
  return dragon;
}

class DragonStore : public ::testing::Test
{
protected:
  std::filesystem::path File = std::filesystem::temp_directory_path() /
                               ("kdstream-dragon-" + std::to_string(::getpid()) + ".kds");
  ~DragonStore() override { std::filesystem::remove(this->File); }

  ModelDescription Build(const BuildOptions& options, unsigned threads)
  {
    const auto report =
      BuildStore(Dragon(), "dragon.ply", this->File, options, MakeTbbExecution(threads));
    EXPECT_TRUE(report) << report.GetError().message;
    return report->info;
  }
};

}

TEST_F(DragonStore, IsUniformAndTheSameOnAnyNumberOfThreads)
{
  ASSERT_EQ(Dragon().points.size(), 437645U);
  ASSERT_EQ(Dragon().triangles.size(), 871414U);
  std::set<std::string> digests;
  for (const unsigned threads : { 1U, 2U, 8U, 1U })
  {
    const ModelDescription info = this->Build({}, threads);
    EXPECT_LE(info.largestPartition - info.smallestPartition, 1U);
    EXPECT_EQ(info.partitions, 256U);
    EXPECT_EQ(info.depths, (TreeDepths{ 8, 12, 16 }));
    digests.insert(info.digest);
  }
  EXPECT_EQ(digests.size(), 1U);
  EXPECT_TRUE((*Store::Open(this->File))->Verify().empty());
}

// The search for the farthest point stays within its budget, so bounds of fine levels are no looser
// than those of coarse ones. Small components that vanish are 6,400 to 7,100 ppm of the diagonal
// away.
TEST_F(DragonStore, BoundsOfFineLevelsAreClose)
{
  const ModelDescription info = this->Build({}, 2);
  ASSERT_EQ(info.levels.size(), 17U);
  const double diagonal = Length(Minus(info.box.hi, info.box.lo));
  for (unsigned depth = 13; depth < 17; ++depth)
  {
    EXPECT_LT(info.levels[depth].geometricError, 7500e-6 * diagonal) << depth;
    EXPECT_GT(info.levels[depth].geometricError, 6000e-6 * diagonal) << depth;
  }
}

TEST_F(DragonStore, NothingIsLost)
{
  for (const bool weld : { false, true })
  {
    BuildOptions options;
    options.bits = 0;
    options.weld = weld;
    this->Build(options, 2);
    const auto store = *Store::Open(this->File);
    std::vector<Piece> pieces;
    for (std::uint32_t p = 0; p < store->Info().partitions; ++p)
    {
      pieces.push_back(
        *store->ReadPiece({ Resolution::Original(), NodeOfPartition(p, store->Info().depths) }));
    }
    const auto glued = GluePartitions(pieces, ScalarType::Float32);
    ASSERT_TRUE(glued);
    Mesh expected = Dragon();
    const std::size_t welded = weld ? WeldVertices(expected) : 0;
    EXPECT_EQ(store->Info().welded, welded);
    EXPECT_TRUE(PointMultiset(*glued) == PointMultiset(expected));
    EXPECT_TRUE(TriangleMultiset(*glued) == TriangleMultiset(expected));
  }
}

// With --weld off the dragon is open along its slits. The drawn surface may be open only where the
// input is.
TEST(DragonSurface, IsOpenOnlyWhereTheInputIs)
{
  const auto model = MakeModel(Dragon(), {}, {}, MakeTbbExecution(2));
  const TreeDepths& depths = model->tree.depths;
  std::map<Edge, int> sums;
  for (const Triangle& t : Dragon().triangles)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      const VertexId a = t[k], b = t[(k + 1) % 3];
      sums[std::minmax(a, b)] += a < b ? 1 : -1;
    }
  }
  std::erase_if(sums, [](const auto& entry) { return entry.second == 0; });
  EXPECT_EQ(sums.size(), 4270U) << "boundary edges of the dragon as it comes";
  std::vector<VertexId> number(Dragon().points.size());
  for (VertexId v = 0; v < number.size(); ++v)
  {
    number[model->vertexTree.original[v]] = v;
  }
  std::mt19937 random(12);
  std::size_t edges = 0;
  for (unsigned draw = 0; draw < 6; ++draw)
  {
    std::vector<PieceId> wanted;
    const auto region = *FindRegion(model->tree.boxes, depths,
      NodeOfPartition(static_cast<std::uint32_t>(random() % 256), depths), 1 + draw % 3);
    for (const std::uint32_t p : region)
    {
      wanted.push_back({ Resolution::Original(), NodeOfPartition(p, depths) });
    }
    const Cut cut =
      CutShowing(*model, Resolution::Level(draw % 2 == 0 ? 8 : depths.stitch + 1), wanted);
    const auto surface = DrawSurface(cut, model->Lookup());
    ASSERT_TRUE(surface) << surface.GetError().message;
    const std::vector<Surface::Source> nodes = CutOfVertices(*model, cut);
    std::set<std::pair<Surface::Source, Surface::Source>> images;
    for (const auto& entry : sums)
    {
      images.insert(
        std::minmax(nodes[number[entry.first.first]], nodes[number[entry.first.second]]));
    }
    for (const Edge& edge : BoundaryEdges(surface->triangles))
    {
      ++edges;
      ASSERT_TRUE(
        images.contains(std::minmax(surface->sources[edge.first], surface->sources[edge.second])));
    }
  }
  EXPECT_GT(edges, 0U) << "no slit was drawn: the test saw nothing";
}

// The welded dragon is closed, whatever is shown.
TEST(DragonSurface, IsClosedOnceWelded)
{
  Mesh welded = Dragon();
  WeldVertices(welded);
  ASSERT_TRUE(BoundaryEdges(welded.triangles).empty());
  const auto model = MakeModel(welded, {}, {}, MakeTbbExecution(2));
  const TreeDepths& depths = model->tree.depths;
  std::mt19937 random(2);
  for (unsigned draw = 0; draw < 8; ++draw)
  {
    std::vector<PieceId> wanted;
    const auto region = *FindRegion(model->tree.boxes, depths,
      NodeOfPartition(static_cast<std::uint32_t>(random() % 256), depths), 1);
    for (const std::uint32_t p : region)
    {
      wanted.push_back({ Resolution::Original(), NodeOfPartition(p, depths) });
    }
    const Cut cut = CutShowing(*model, Resolution::Level(6 + draw), wanted);
    const auto surface = DrawSurface(cut, model->Lookup());
    ASSERT_TRUE(surface) << surface.GetError().message;
    EXPECT_TRUE(BoundaryEdges(surface->triangles).empty()) << "region in level " << 6 + draw;
  }
}
