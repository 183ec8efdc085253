// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/Invariants.h"
#include "Testing/Fixtures/Meshes.h"
#include "Testing/Fixtures/Model.h"
#include "filters/core/tree/Region.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <utility>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

using DrawnTriangle = std::array<Surface::Source, 3>;

DrawnTriangle Rotated(const DrawnTriangle& t)
{
  return std::min({ t, DrawnTriangle{ t[1], t[2], t[0] }, DrawnTriangle{ t[2], t[0], t[1] } });
}

// The expected triangles: the image of the original mesh under the map vertex -> node of the cut,
// from the whole tree.
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

// The pieces that a viewer has loaded.
class Loaded
{
public:
  explicit Loaded(const Model& model)
    : All(model.pieces)
  {
  }

  PieceLookup Lookup() const
  {
    return [this](PieceId id) -> const Piece*
    {
      const auto found = this->Pieces.find(id);
      return found == this->Pieces.end() ? nullptr : found->second;
    };
  }
  void Load(const std::vector<PieceId>& ids)
  {
    for (const PieceId id : ids)
    {
      this->Pieces[id] = &this->All.at(id);
    }
  }

private:
  const std::map<PieceId, Piece>& All;
  std::map<PieceId, const Piece*> Pieces;
};

// Draws with only the pieces that MissingPieces requests: no others may be needed.
Surface DrawWithOnlyWhatIsAskedFor(const Model& model, const Cut& cut)
{
  Loaded loaded(model);
  loaded.Load(MissingPieces(cut, loaded.Lookup()));
  auto surface = DrawSurface(cut, loaded.Lookup());
  EXPECT_TRUE(surface);
  return std::move(*surface);
}

// The pieces that must be active to show the wanted ones. Loads missing pieces until none is
// missing.
std::vector<PieceId> Close(const Model& model, Resolution base, const std::vector<PieceId>& wanted)
{
  const TreeDepths& depths = model.tree.depths;
  Loaded loaded(model);
  loaded.Load(MissingPieces({ depths, base }, loaded.Lookup()));
  for (unsigned round = 0;; ++round)
  {
    const Closure closure = MakeClosure(depths, base, wanted, loaded.Lookup());
    if (closure.missing.empty())
    {
      return closure.pieces;
    }
    EXPECT_LE(round, depths.finest + 1) << "a round a level is enough";
    loaded.Load(closure.missing);
  }
}

Resolution RandomFrom(std::mt19937& random, unsigned coarsest, const TreeDepths& depths)
{
  const unsigned choices = depths.finest - coarsest + 2;
  const auto choice = static_cast<unsigned>(coarsest + random() % choices);
  return choice > depths.finest ? Resolution::Original() : Resolution::Level(choice);
}

// Every partition at a random resolution: a level from S on, or the original.
Cut RandomMixedCut(std::mt19937& random, const TreeDepths& depths)
{
  Cut cut{ depths, RandomFrom(random, depths.stitch, depths) };
  std::set<PieceId> active;
  for (std::uint32_t p = 0; p < 1U << depths.partition; ++p)
  {
    const Resolution resolution = RandomFrom(random, depths.stitch, depths);
    if (random() % 5 != 0)
    {
      active.insert(PieceOfPartition(resolution, p, depths));
    }
  }
  cut.active.assign(active.begin(), active.end());
  return cut;
}

// A coarse level with a region of the original in it, sometimes surrounded by a ring of the finest
// level.
Cut RandomRegion(std::mt19937& random, const Model& model)
{
  const TreeDepths& depths = model.tree.depths;
  const std::size_t partitions = std::size_t{ 1 } << depths.partition;
  const auto base =
    Resolution::Level(static_cast<unsigned>(random() % std::max(1U, depths.stitch)));
  const NodeId cell = NodeOfPartition(static_cast<std::uint32_t>(random() % partitions), depths);
  const auto rings = static_cast<unsigned>(random() % 3);
  std::vector<PieceId> wanted;
  if (random() % 2 == 0)
  {
    const auto ring = *FindRegion(model.tree.boxes, depths, cell, rings + 1);
    for (const std::uint32_t p : ring)
    {
      wanted.push_back(PieceOfPartition(Resolution::Level(depths.finest), p, depths));
    }
  }
  const auto region = *FindRegion(model.tree.boxes, depths, cell, rings);
  for (const std::uint32_t p : region)
  {
    wanted.push_back({ Resolution::Original(), NodeOfPartition(p, depths) });
  }
  return { depths, base, Close(model, base, wanted) };
}

// Any pieces: many or few of each resolution.
Cut RandomPieces(std::mt19937& random, const Model& model)
{
  const TreeDepths& depths = model.tree.depths;
  Cut cut{ depths, RandomFrom(random, 0, depths) };
  std::map<Resolution, unsigned> percent;
  for (const auto& [id, piece] : model.pieces)
  {
    const std::array<unsigned, 6> choices{ 0, 5, 60, 90, 97, 100 };
    const unsigned most = percent.try_emplace(id.resolution, choices[random() % 6]).first->second;
    if (random() % 100 < most)
    {
      cut.active.push_back(id);
    }
  }
  return cut;
}

// The closure of some pieces of any resolution, to which a few others are added, and from which a
// few are removed.
Cut RandomClosure(std::mt19937& random, const Model& model)
{
  const TreeDepths& depths = model.tree.depths;
  const auto any = [&]
  {
    const Resolution resolution = RandomFrom(random, 0, depths);
    return PieceOfPartition(
      resolution, static_cast<std::uint32_t>(random() % (1U << depths.partition)), depths);
  };
  const auto base = Resolution::Level(static_cast<unsigned>(random() % (depths.stitch + 1)));
  std::vector<PieceId> wanted;
  for (auto i = 1 + random() % 4; i > 0; --i)
  {
    wanted.push_back(any());
  }
  const std::vector<PieceId> closed = Close(model, base, wanted);
  std::set<PieceId> active(closed.begin(), closed.end());
  for (auto i = random() % 3; i > 0; --i)
  {
    active.insert(any());
  }
  for (auto i = random() % 3; i > 0 && !active.empty(); --i)
  {
    active.erase(std::next(active.begin(), static_cast<std::ptrdiff_t>(random() % active.size())));
  }
  return { depths, base, { active.begin(), active.end() } };
}

Cut RandomCut(std::mt19937& random, const Model& model)
{
  switch (random() % 5)
  {
    case 0:
      return RandomMixedCut(random, model.tree.depths);
    case 1:
      return RandomRegion(random, model);
    case 2:
      return RandomPieces(random, model);
    default:
      return RandomClosure(random, model);
  }
}

// Whether any edge is used by only one triangle; faster than BoundaryEdges.
bool HasBoundary(const std::vector<Triangle>& triangles)
{
  std::vector<std::uint64_t> edges;
  for (const Triangle& t : triangles)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      const auto [a, b] = std::minmax(t[k], t[(k + 1) % 3]);
      edges.push_back(std::uint64_t{ a } << 32 | b);
    }
  }
  std::sort(edges.begin(), edges.end());
  for (std::size_t i = 0; i < edges.size(); ++i)
  {
    if ((i == 0 || edges[i] != edges[i - 1]) && (i + 1 == edges.size() || edges[i] != edges[i + 1]))
    {
      return true;
    }
  }
  return false;
}

}

TEST(DrawSurface, ClosedMeshesStayClosedInRandomCuts)
{
  // Random cuts from fixed seeds, over all levels of each closed mesh. Levels coarser than S have
  // many pieces.
  const std::pair<LevelOptions, unsigned> makers[] = { { LevelOptions{}, 3 },
    { LevelOptions{ {}, LevelMaker::Cluster }, 2 },
    { LevelOptions{ { Representative::Mean, false, 0 }, LevelMaker::Cluster },
      TreeDepths{}.onePiece } };
  for (const NamedMesh& named : ClosedMeshes())
  {
    for (const auto& [options, onePiece] : makers)
    {
      const auto model = MakeModel(named.mesh, { 40, {}, 8 }, options, {}, onePiece);
      std::mt19937 random(42);
      std::set<unsigned> mixed; // levels coarser than S that are shown with a finer one
      for (unsigned draw = 0; draw < 1000; ++draw)
      {
        SCOPED_TRACE(named.name + ", draw " + std::to_string(draw));
        const Cut cut = RandomCut(random, *model);
        const Surface surface = DrawWithOnlyWhatIsAskedFor(*model, cut);
        ASSERT_FALSE(HasBoundary(surface.triangles));
        const auto [least, most] =
          std::minmax_element(surface.sources.begin(), surface.sources.end(),
            [](const auto& a, const auto& b) { return a.resolution < b.resolution; });
        if (least->resolution < most->resolution)
        {
          mixed.insert(least->resolution.Depth());
        }
      }
      for (unsigned d = PreviewLevel(model->tree.depths); d < model->tree.depths.stitch; ++d)
      {
        EXPECT_TRUE(mixed.contains(d)) << named.name << ": no cut mixes level " << d;
      }
    }
  }
}

TEST(DrawSurface, IsClosedAfterEveryPieceThatComes)
{
  for (const NamedMesh& named : ClosedMeshes())
  {
    SCOPED_TRACE(named.name);
    const auto model = MakeModel(named.mesh, { 40, {}, 8 }, {}, {}, 2);
    std::mt19937 random(5);
    for (unsigned walk = 0; walk < 4; ++walk)
    {
      Cut cut = RandomRegion(random, *model);
      std::vector<PieceId> coming = std::exchange(cut.active, {});
      std::shuffle(coming.begin(), coming.end(), random);
      for (const PieceId id : coming)
      {
        cut.active.insert(std::upper_bound(cut.active.begin(), cut.active.end(), id), id);
        ASSERT_FALSE(HasBoundary(DrawWithOnlyWhatIsAskedFor(*model, cut).triangles));
      }
    }
  }
}

TEST(DrawSurface, IsTheImageOfTheMeshUnderTheCut)
{
  // Closed, open and difficult meshes, and clouds. The last options make trees so deep that level S
  // itself is cut into several pieces.
  const std::pair<KdTreeOptions, unsigned> trees[] = { { { 60, {}, 8 }, 3 }, { { 500, {}, 8 }, 1 },
    { { 60, {}, 8 }, TreeDepths{}.onePiece }, { { 8, {}, 1 }, TreeDepths{}.onePiece } };
  for (const NamedMesh& named : AllMeshes())
  {
    for (const auto& [options, onePiece] : trees)
    {
      const auto model = MakeModel(named.mesh, options, {}, {}, onePiece);
      std::mt19937 random(7);
      for (unsigned draw = 0; draw < 20; ++draw)
      {
        SCOPED_TRACE(named.name + ", draw " + std::to_string(draw));
        const Cut cut = RandomCut(random, *model);
        ExpectDrawn(*model, cut, DrawWithOnlyWhatIsAskedFor(*model, cut));
        if (HasFatalFailure())
        {
          return;
        }
      }
    }
  }
}

TEST(MakeClosure, ShowsWhatIsWantedAndNothingLessWould)
{
  const auto model = MakeModel(Torus(60, 30), { 40, {}, 8 }, {}, {}, 2);
  const TreeDepths& depths = model->tree.depths;
  ASSERT_GT(depths.stitch, PreviewLevel(depths) + 3);
  std::mt19937 random(11);
  const auto shows = [&](const Cut& cut, PieceId id)
  {
    const Surface surface = DrawWithOnlyWhatIsAskedFor(*model, cut);
    const std::set<Surface::Source> shown(surface.sources.begin(), surface.sources.end());
    const Piece& piece = model->pieces.at(id);
    return std::all_of(piece.keys.begin(), piece.keys.begin() + piece.ownVertices,
      [&](VertexKey key) {
        return shown.contains({ id.resolution, key });
      });
  };
  for (unsigned draw = 0; draw < 60; ++draw)
  {
    const auto base = Resolution::Level(static_cast<unsigned>(random() % (depths.finest + 1)));
    const PieceId id = PieceOfPartition(RandomFrom(random, base.Depth() + 1, depths),
      static_cast<std::uint32_t>(random() % (1U << depths.partition)), depths);
    const Cut cut{ depths, base, Close(*model, base, { id }) };
    ASSERT_TRUE(shows(cut, id)) << "base " << base.Depth() << ", draw " << draw;
    unsigned unneeded = 0; // pieces in nodes above, added on suspicion
    for (std::size_t i = 0; i < cut.active.size(); ++i)
    {
      Cut less = cut;
      less.active.erase(less.active.begin() + static_cast<std::ptrdiff_t>(i));
      unneeded += shows(less, id);
    }
    EXPECT_LE(unneeded, depths.stitch) << "at most one a level";
  }
}

TEST(DrawSurface, OfPiecesThatLieIsSomethingOrAnError)
{
  // A builder could have written each piece, but together they contradict each other.
  const auto model = MakeModel(Torus(60, 30), { 40, {}, 8 }, {}, {}, 2);
  const TreeDepths& depths = model->tree.depths;
  std::mt19937 random(13);
  std::size_t lies = 0;
  for (unsigned draw = 0; draw < 300; ++draw)
  {
    const Cut cut = RandomClosure(random, *model);
    std::map<PieceId, Piece> pieces;
    for (const PieceId id : PiecesOf(cut))
    {
      pieces[id] = model->pieces.at(id);
    }
    for (auto& [id, piece] : pieces)
    {
      Piece lying = piece;
      for (std::uint32_t& rank : lying.ancestors)
      {
        rank = random() % 50 == 0 ? static_cast<std::uint32_t>(random() % 300) : rank;
      }
      for (NodeId& node : lying.childNodes)
      {
        node = random() % 10 == 0 ? node ^ 1U : node;
      }
      if (id.resolution < Resolution::Level(depths.stitch) && lying.GhostCount() == 0)
      {
        for (VertexKey& key : lying.keys)
        {
          key += draw % 2 * 1000;
        }
      }
      if (CheckPiece(lying, depths))
      {
        ++lies;
        piece = std::move(lying);
      }
    }
    const PieceLookup lookup = [&](PieceId id) -> const Piece*
    {
      const auto found = pieces.find(id);
      return found == pieces.end() ? nullptr : &found->second;
    };
    const auto surface = DrawSurface(cut, lookup);
    ASSERT_TRUE(surface) << surface.GetError().message;
    for (const Triangle& t : surface->triangles)
    {
      ASSERT_LT(std::max({ t[0], t[1], t[2] }), surface->points.size());
    }
    MakeClosure(depths, cut.base, cut.active, lookup);
  }
  EXPECT_GT(lies, 500U);
}

TEST(DrawSurface, AllAtOneLevelIsThatLevel)
{
  for (const NamedMesh& named : AllMeshes())
  {
    SCOPED_TRACE(named.name);
    const auto model = MakeModel(named.mesh, { 100, {}, 8 });
    for (unsigned d = 0; d <= model->tree.depths.finest; ++d)
    {
      const Cut cut{ model->tree.depths, Resolution::Level(d) };
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
    const Cut cut{ model->tree.depths, Resolution::Original() };
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
    const auto model = MakeModel(named.mesh, { 100, {}, 8 }, {}, {}, 2);
    // Edges whose directions do not cancel: boundary edges and inconsistent ones.
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
      const Cut cut = RandomCut(random, *model);
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
  EXPECT_TRUE(FailsAt(DrawSurface({ depths, Resolution::Level(3) }, nothing), ErrorCode::NotFound));
  const auto failsAt = [](const Cut& cut, std::string_view place)
  { return FailsAt(CheckCut(cut), ErrorCode::InvalidArgument, place); };
  const PieceId partition{ Resolution::Original(), 33 }, level{ Resolution::Level(3), 1 };
  EXPECT_TRUE(CheckCut({ depths, Resolution::Level(3), { level, partition } }));
  EXPECT_TRUE(failsAt({ depths, Resolution::Level(20) }, "level 20"));
  EXPECT_TRUE(
    failsAt({ depths, Resolution::Level(3), { { Resolution::Original(), 31 } } }, "node 31"));
  EXPECT_TRUE(failsAt({ depths, Resolution::Level(3), { { Resolution::Level(4), 2 } } }, "node 2"));
  EXPECT_TRUE(
    failsAt({ depths, Resolution::Level(3), { { Resolution::Level(20), 1 } } }, "node 1"));
  for (const PieceId second : { level, partition })
  {
    EXPECT_TRUE(failsAt({ depths, Resolution::Level(2), { partition, second } }, "at 1"));
  }
}
