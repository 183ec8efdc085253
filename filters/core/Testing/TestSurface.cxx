// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/Invariants.h"
#include "Testing/Fixtures/Meshes.h"
#include "Testing/Fixtures/Model.h"
#include "filters/core/tree/Region.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

using DrawnTriangle = std::array<Surface::Source, 3>;

DrawnTriangle Rotated(const DrawnTriangle& t)
{
  return std::min({ t, DrawnTriangle{ t[1], t[2], t[0] }, DrawnTriangle{ t[2], t[0], t[1] } });
}

// What must be drawn: the image of the original mesh under the map vertex -> node of the cut, from
// the whole tree.
std::set<DrawnTriangle> ExpectedTriangles(
  const Model& model, const std::vector<Surface::Source>& nodes)
{
  std::vector<VertexId> number(nodes.size());
  for (VertexId v = 0; v < number.size(); ++v)
  {
    number[model.vertexTree.original[v]] = v;
  }
  std::set<DrawnTriangle> expected;
  for (const Triangle& t : model.mesh.triangles)
  {
    const DrawnTriangle d{ nodes[number[t[0]]], nodes[number[t[1]]], nodes[number[t[2]]] };
    if (d[0] != d[1] && d[1] != d[2] && d[2] != d[0])
    {
      expected.insert(Rotated(d));
    }
  }
  return expected;
}

void ExpectDrawn(const Model& model, const Cut& cut, const Surface& surface)
{
  const std::vector<Surface::Source> nodes = CutOfVertices(model, cut);
  std::set<DrawnTriangle> drawn;
  for (const Triangle& t : surface.triangles)
  {
    drawn.insert(Rotated({ surface.sources[t[0]], surface.sources[t[1]], surface.sources[t[2]] }));
  }
  ASSERT_EQ(drawn.size(), surface.triangles.size()) << "a triangle is drawn twice";
  ASSERT_EQ(drawn, ExpectedTriangles(model, nodes));
  const std::set<Surface::Source> shown(surface.sources.begin(), surface.sources.end());
  ASSERT_EQ(shown, std::set<Surface::Source>(nodes.begin(), nodes.end()));
  ASSERT_EQ(shown.size(), surface.points.size());
}

// Only the pieces that MissingPieces asked for, one after the other: nothing else may be needed.
Surface DrawWithOnlyWhatIsAskedFor(const Model& model, const Cut& cut)
{
  std::map<PieceId, const Piece*> loaded;
  const PieceLookup lookup = [&](PieceId id) -> const Piece*
  {
    const auto found = loaded.find(id);
    return found == loaded.end() ? nullptr : found->second;
  };
  for (auto missing = MissingPieces(cut, lookup); !missing.empty();
       missing = MissingPieces(cut, lookup))
  {
    for (const PieceId id : missing)
    {
      loaded[id] = &model.pieces.at(id);
    }
  }
  auto surface = DrawSurface(cut, lookup);
  EXPECT_TRUE(surface);
  return std::move(*surface);
}

Resolution RandomFine(std::mt19937& random, const TreeDepths& depths)
{
  const unsigned choices = depths.finest - depths.stitch + 2;
  const auto choice = static_cast<unsigned>(depths.stitch + random() % choices);
  return choice > depths.finest ? Resolution::Original() : Resolution::Level(choice);
}

// Every partition at a resolution from S on or the original, at random.
Cut RandomMix(std::mt19937& random, const TreeDepths& depths)
{
  Cut cut{ depths, RandomFine(random, depths), {} };
  for (std::size_t p = 0; p < std::size_t{ 1 } << depths.partition; ++p)
  {
    cut.refined.emplace_back(
      random() % 5 == 0 ? std::nullopt : std::optional(RandomFine(random, depths)));
  }
  return cut;
}

// A level coarser than S with a region of the original in it, sometimes held by a ring of the
// finest level.
Cut RandomRegion(std::mt19937& random, const Model& model)
{
  const TreeDepths& depths = model.tree.depths;
  const std::size_t partitions = std::size_t{ 1 } << depths.partition;
  Cut cut{ depths, Resolution::Level(static_cast<unsigned>(random() % std::max(1U, depths.stitch))),
    {} };
  cut.refined.resize(partitions);
  const NodeId cell = NodeOfPartition(static_cast<std::uint32_t>(random() % partitions), depths);
  const auto rings = static_cast<unsigned>(random() % 3);
  if (random() % 2 == 0)
  {
    const auto ring = *FindRegion(model.tree.boxes, depths, cell, rings + 1);
    for (const std::uint32_t p : ring)
    {
      cut.refined[p] = Resolution::Level(depths.finest);
    }
  }
  const auto region = *FindRegion(model.tree.boxes, depths, cell, rings);
  for (const std::uint32_t p : region)
  {
    cut.refined[p] = Resolution::Original();
  }
  return cut;
}

}

TEST(DrawSurface, ClosedMeshesStayClosedInRandomCuts)
{
  // 200 seeded draws on each closed mesh: half mixes from S on, half regions in a coarser level.
  for (const NamedMesh& named : ClosedMeshes())
  {
    for (const LevelOptions& options : { LevelOptions{}, LevelOptions{ {}, LevelMaker::Cluster },
           LevelOptions{ { Representative::Mean, false, 0 }, LevelMaker::Cluster } })
    {
      const auto model = MakeModel(named.mesh, { 100, {}, 8 }, options);
      std::mt19937 random(42);
      for (unsigned draw = 0; draw < 200; ++draw)
      {
        SCOPED_TRACE(named.name + ", draw " + std::to_string(draw));
        const Cut cut =
          draw % 2 == 0 ? RandomMix(random, model->tree.depths) : RandomRegion(random, *model);
        const Surface surface = DrawWithOnlyWhatIsAskedFor(*model, cut);
        ASSERT_TRUE(BoundaryEdges(surface.triangles).empty());
      }
    }
  }
}

TEST(DrawSurface, IsTheImageOfTheMeshUnderTheCut)
{
  // The last options make trees so deep that level S itself is cut into several pieces.
  for (const NamedMesh& named : AllMeshes())
  {
    for (const KdTreeOptions& options :
      { KdTreeOptions{ 60, {}, 8 }, { 500, {}, 8 }, { 8, {}, 1 } })
    {
      const auto model = MakeModel(named.mesh, options);
      std::mt19937 random(7);
      for (unsigned draw = 0; draw < 12; ++draw)
      {
        SCOPED_TRACE(named.name + ", draw " + std::to_string(draw));
        const Cut cut =
          draw % 2 == 0 ? RandomMix(random, model->tree.depths) : RandomRegion(random, *model);
        ExpectDrawn(*model, cut, DrawWithOnlyWhatIsAskedFor(*model, cut));
        if (HasFatalFailure())
        {
          return;
        }
      }
    }
  }
}

TEST(DrawSurface, ASplitClusterMayReachSeveralPiecesOfLevelS)
{
  const auto model = MakeModel(Torus(96, 48), { 8, {}, 1 });
  const TreeDepths& depths = model->tree.depths;
  ASSERT_GT(PieceDepth(Resolution::Level(depths.stitch), depths), 0U);
  Cut cut{ depths, Resolution::Level(0), {} };
  cut.refined.resize(std::size_t{ 1 } << depths.partition);
  cut.refined[5] = Resolution::Original();
  const Surface surface = DrawWithOnlyWhatIsAskedFor(*model, cut);
  ExpectDrawn(*model, cut, surface);
  EXPECT_TRUE(BoundaryEdges(surface.triangles).empty());
}

TEST(DrawSurface, AllAtOneLevelIsThatLevel)
{
  for (const NamedMesh& named : AllMeshes())
  {
    SCOPED_TRACE(named.name);
    const auto model = MakeModel(named.mesh, { 100, {}, 8 });
    for (unsigned d = 0; d <= model->tree.depths.finest; ++d)
    {
      const Cut cut{ model->tree.depths, Resolution::Level(d), {} };
      const Surface surface = DrawWithOnlyWhatIsAskedFor(*model, cut);
      EXPECT_EQ(surface.points, model->vertexTree.levels[d].positions);
      EXPECT_EQ(surface.triangles, model->vertexTree.levels[d].triangles);
    }
  }
}

TEST(DrawSurface, AllAtTheOriginalIsTheInput)
{
  for (const NamedMesh& named : ClosedMeshes())
  {
    SCOPED_TRACE(named.name);
    const auto model = MakeModel(named.mesh, { 100, {}, 8 });
    const Cut cut{ model->tree.depths, Resolution::Original(), {} };
    const Surface surface = DrawWithOnlyWhatIsAskedFor(*model, cut);
    const Mesh drawn{ surface.points, surface.triangles };
    EXPECT_EQ(PointMultiset(drawn), PointMultiset(named.mesh));
    EXPECT_EQ(TriangleMultiset(drawn), TriangleMultiset(named.mesh));
  }
}

TEST(DrawSurface, BoundaryEdgesOfOpenMeshesAreImagesOfTheirs)
{
  for (const NamedMesh& named : HardMeshes())
  {
    SCOPED_TRACE(named.name);
    const auto model = MakeModel(named.mesh, { 100, {}, 8 });
    // Edges that do not cancel: boundary and inconsistent ones.
    std::map<Edge, int> sums;
    for (const Triangle& t : named.mesh.triangles)
    {
      for (std::size_t k = 0; k < 3; ++k)
      {
        const VertexId a = t[k], b = t[(k + 1) % 3];
        sums[std::minmax(a, b)] +=
          t[0] == t[1] || t[1] == t[2] || t[2] == t[0] ? 0 : (a < b ? 1 : -1);
      }
    }
    std::vector<VertexId> number(named.mesh.points.size());
    for (VertexId v = 0; v < number.size(); ++v)
    {
      number[model->vertexTree.original[v]] = v;
    }
    std::mt19937 random(3);
    for (unsigned draw = 0; draw < 20; ++draw)
    {
      const Cut cut =
        draw % 2 == 0 ? RandomMix(random, model->tree.depths) : RandomRegion(random, *model);
      const Surface surface = DrawWithOnlyWhatIsAskedFor(*model, cut);
      const std::vector<Surface::Source> nodes = CutOfVertices(*model, cut);
      std::set<std::pair<Surface::Source, Surface::Source>> images;
      for (const auto& [edge, sum] : sums)
      {
        if (sum != 0)
        {
          images.insert(std::minmax(nodes[number[edge.first]], nodes[number[edge.second]]));
        }
      }
      for (const Edge& edge : BoundaryEdges(surface.triangles))
      {
        ASSERT_TRUE(
          images.contains(std::minmax(surface.sources[edge.first], surface.sources[edge.second])));
      }
    }
  }
}

TEST(DrawSurface, SaysWhatIsMissingOrWrong)
{
  const auto model = MakeModel(Torus(60, 30), { 100, {}, 8 });
  const TreeDepths& depths = model->tree.depths;
  const auto nothing = [](PieceId) -> const Piece* { return nullptr; };
  EXPECT_EQ(DrawSurface({ depths, Resolution::Level(3), {} }, nothing).GetError().message,
    "1 pieces are not loaded");
  const auto message = [&](const Cut& cut) { return CheckCut(cut).GetError().message; };
  EXPECT_EQ(message({ depths, Resolution::Level(20), {} }),
    "level 20 is finer than the finest, " + std::to_string(depths.finest));
  EXPECT_EQ(message({ depths, Resolution::Level(3), { Resolution::Original() } }),
    "1 resolutions for 32 partitions");
  Cut coarse{ depths, Resolution::Level(3), {} };
  coarse.refined.resize(32);
  coarse.refined[4] = Resolution::Level(depths.stitch - 1);
  EXPECT_EQ(message(coarse), "partition 4: level " + std::to_string(depths.stitch - 1) +
                               " is not between the stitch depth " + std::to_string(depths.stitch) +
                               " and the finest level " + std::to_string(depths.finest));
}

TEST(FindRegion, AgreesWithTestingEveryBox)
{
  for (const NamedMesh& named : AllMeshes())
  {
    SCOPED_TRACE(named.name);
    const auto tree = *BuildKdTree(named.mesh.points, { 20, {}, 8 });
    std::mt19937 random(1);
    const NodeId first = NodeId{ 1 } << tree.depths.partition;
    for (unsigned draw = 0; draw < 50; ++draw)
    {
      const auto cell = static_cast<NodeId>(1 + random() % (2 * first - 1));
      const auto rings = static_cast<unsigned>(random() % 4);
      Box reach = tree.boxes[cell];
      double average = 0;
      for (std::size_t k = 0; k < 3; ++k)
      {
        average += (reach.hi[k] - reach.lo[k]) / 3;
      }
      std::set<std::uint32_t> expected;
      for (NodeId node = first; node < 2 * first; ++node)
      {
        bool touches = !tree.boxes[node].Empty() && !reach.Empty();
        for (std::size_t k = 0; k < 3; ++k)
        {
          touches = touches && tree.boxes[node].lo[k] <= reach.hi[k] + rings * average &&
                    tree.boxes[node].hi[k] >= reach.lo[k] - rings * average;
        }
        if (touches)
        {
          expected.insert(node - first);
        }
      }
      const auto region = FindRegion(tree.boxes, tree.depths, cell, rings);
      ASSERT_TRUE(region);
      EXPECT_EQ(std::set<std::uint32_t>(region->begin(), region->end()), expected);
      EXPECT_EQ(region->size(), expected.size());
      if (DepthOfNode(cell) == tree.depths.partition && !reach.Empty())
      {
        EXPECT_EQ(region->front(), cell - first) << "the cell itself comes first";
      }
    }
    EXPECT_FALSE(FindRegion(tree.boxes, tree.depths, 0, 1));
    EXPECT_EQ(FindRegion(tree.boxes, tree.depths, 2 * first, 1).GetError().message,
      "cell " + std::to_string(2 * first) + " is not a node of the tree (1 to " +
        std::to_string(2 * first - 1) + ")");
  }
}

TEST(NearestPartition, IsTheLowestOfTheNearest)
{
  const auto tree = *BuildKdTree(GridPlate(40).points, { 20, {}, 8 });
  const NodeId first = NodeId{ 1 } << tree.depths.partition;
  std::mt19937 random(1);
  for (unsigned draw = 0; draw < 300; ++draw)
  {
    const Vec3 point{ double(random() % 50) - 5, double(random() % 50) - 5, double(random() % 3) };
    double best = INFINITY;
    std::uint32_t expected = 0;
    for (NodeId node = first; node < 2 * first; ++node)
    {
      double distance = 0;
      for (std::size_t k = 0; k < 3; ++k)
      {
        const double d =
          std::max({ tree.boxes[node].lo[k] - point[k], point[k] - tree.boxes[node].hi[k], 0.0 });
        distance += d * d;
      }
      if (distance < best)
      {
        best = distance;
        expected = node - first;
      }
    }
    EXPECT_EQ(NearestPartition(tree.boxes, tree.depths, point), expected);
  }
}
