// SPDX-License-Identifier: BSD-3-Clause
// Which pieces a view needs, compared with what follows from the pages of a torus.
#include "viewer/session/Testing/MemoryServer.h"
#include "viewer/session/model/PieceCache.h"
#include "viewer/session/model/ViewRefinement.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>

using namespace kdstream;
using namespace kdstream::testing;

namespace
{

const MemoryServer& Torus()
{
  static const MemoryServer server(MakeTorus(400, 160), 128, 2); // 64,000 vertices
  return server;
}

// The tree with all of its pages.
KnownTree WholeTree(MemoryServer& server)
{
  const ModelDescription& model = server.Description();
  KnownTree tree(model.depths, true, model.box, std::size_t{ 16 } << 20);
  for (const NodeId page : TreePages(model.depths))
  {
    const auto blob = protocol::BlobId::TreePage(page);
    EXPECT_TRUE(tree.Add(blob, server.Blob(blob)));
  }
  return tree;
}

Camera CameraAt(const ModelDescription& model, double zoom, double x = 400, double y = 300)
{
  Camera camera;
  camera.SetViewport({ 800, 600, 1 });
  camera.FitTo(model.box);
  camera.Zoom(zoom, x, y);
  return camera;
}

bool Holds(const std::vector<PieceId>& pieces, PieceId piece)
{
  return std::binary_search(pieces.begin(), pieces.end(), piece);
}

// The next finer pieces, which would replace a piece.
std::vector<PieceId> Below(PieceId piece, const TreeDepths& depths)
{
  const Resolution next = piece.resolution.Depth() == depths.finest
                            ? Resolution::Original()
                            : Resolution::Level(piece.resolution.Depth() + 1);
  const unsigned deeper = PieceDepth(next, depths) - PieceDepth(piece.resolution, depths);
  std::vector<PieceId> pieces;
  for (NodeId i = 0; i < NodeId{ 1 } << deeper; ++i)
  {
    pieces.push_back({ next, (piece.node << deeper) + i });
  }
  return pieces;
}

const PieceCache& Nothing()
{
  static const PieceCache empty(0);
  return empty;
}

void Follow(ViewRefinement& refinement, const Camera& camera, KnownTree& tree)
{
  refinement.Follow({ camera, tree, Nothing(), nullptr, true }, {}, {});
}

bool MaySeePartitionIn(
  NodeId node, const Camera& camera, const ModelDescription& model, KnownTree& tree)
{
  if (!camera.MaySee(*tree.Around(node)) || DepthOfNode(node) == model.depths.partition)
  {
    return camera.MaySee(*tree.Around(node));
  }
  return MaySeePartitionIn(2 * node, camera, model, tree) ||
         MaySeePartitionIn(2 * node + 1, camera, model, tree);
}

// The rule, implemented a second time: a piece is refined if it would show a visible error in the
// box of a piece below it. Of the refined pieces, those are wanted that finer ones do not replace
// completely; and, for each that is finer than S, one three steps above it.
std::vector<PieceId> WhatTheScreenNeeds(
  const Camera& camera, const ModelDescription& model, KnownTree& tree)
{
  const unsigned finest = model.depths.finest;
  const auto stepOf = [finest](Resolution resolution)
  { return resolution.IsOriginal() ? finest + 1 : resolution.Depth(); };
  std::set<PieceId> refined{ { Resolution::Level(PreviewLevel(model.depths)), 1 } }, wanted;
  for (unsigned d = PreviewLevel(model.depths); d <= finest + 1; ++d)
  {
    const Resolution resolution = d <= finest ? Resolution::Level(d) : Resolution::Original();
    const NodeId first = NodeId{ 1 } << PieceDepth(resolution, model.depths);
    for (NodeId node = first; node < 2 * first; ++node)
    {
      const PieceId piece{ resolution, node };
      if (refined.count(piece) == 0)
      {
        continue;
      }
      std::size_t seen = 0, below = 0;
      for (const PieceId next : d > finest ? std::vector<PieceId>() : Below(piece, model.depths))
      {
        const double geometricError = std::max<double>(tree.FactsOf(piece)->most99,
          VertexSpacing(*tree.Around(node), double(model.levels[d].vertices) / first) / 6);
        const Box& box = *tree.Around(next.node);
        const bool mayBeVisible = MaySeePartitionIn(next.node, camera, model, tree);
        const double error = geometricError * camera.PointsPerUnit(camera.DistanceTo(box));
        seen += mayBeVisible ? 1 : 0;
        const double vertices =
          d < finest ? double(model.levels[d + 1].vertices) : double(model.vertices);
        const double leap = std::max(1.0, vertices / double(model.levels[d].vertices) / 2);
        if (mayBeVisible && error > std::pow(leap, 0.375))
        {
          refined.insert(next);
          ++below;
        }
      }
      if (d > PreviewLevel(model.depths) && (below < seen || d > finest))
      {
        wanted.insert(piece);
        if (d > model.depths.stitch + 3)
        {
          const Resolution before = Resolution::Level(stepOf(resolution) - 3);
          wanted.insert({ before, node >> (DepthOfNode(node) - PieceDepth(before, model.depths)) });
        }
      }
    }
  }
  return { wanted.begin(), wanted.end() };
}

// A scan with few triangles is shown as the original where a scan with many triangles would be
// shown in a level.
TEST(TestViewRefinement, ASmallModelIsShownFourTimesAsFine)
{
  MemoryServer server = Torus();
  KnownTree tree = WholeTree(server);
  const std::uint64_t triangles = server.Description().triangles;
  RefinementOptions options;
  ViewRefinement usual(server.Description(), options);
  options.smallModel = triangles - 1;
  ViewRefinement large(server.Description(), options);
  options.smallModel = triangles;
  ViewRefinement small(server.Description(), options);
  options.smallModel = 0;
  options.tolerance = 0.25;
  ViewRefinement finer(server.Description(), options);
  for (const double zoom : { 0.3, 1.0, 3.0 })
  {
    const Camera camera = CameraAt(server.Description(), zoom);
    for (ViewRefinement* each : { &usual, &large, &small, &finer })
    {
      Follow(*each, camera, tree);
    }
    EXPECT_EQ(large.Pieces(), usual.Pieces());
    EXPECT_EQ(small.Pieces(), finer.Pieces());
    EXPECT_TRUE(zoom != 0.3 || small.Pieces() != usual.Pieces());
  }
}

// Vertex colours need finer levels than light, and textures that only the original has need still
// finer ones, because they have more detail than vertices. Levels with textures need coarser ones.
TEST(TestViewRefinement, ColorsAndTexturesAskForMoreVertices)
{
  MemoryServer server = Torus();
  ModelDescription colored = server.Description();
  colored.attributes.push_back({ "RGB", AttributeType::UInt8, AttributeAssociation::Point, 3 });
  ModelDescription textured = colored;
  textured.textures.emplace();
  EXPECT_DOUBLE_EQ(LightPartOf(server.Description()), 1.0 / 6);
  EXPECT_DOUBLE_EQ(LightPartOf(colored), 1.0 / 3);
  EXPECT_DOUBLE_EQ(LightPartOf(textured), 1.0 / 2);
  ModelDescription texturedLevels = textured;
  texturedLevels.textures->levels = true;
  EXPECT_DOUBLE_EQ(LightPartOf(texturedLevels), 1.0 / 7);
  KnownTree tree = WholeTree(server);
  std::vector<std::size_t> pieces;
  for (const ModelDescription& model : { texturedLevels, server.Description(), colored, textured })
  {
    ViewRefinement refinement(model, {});
    std::size_t& all = pieces.emplace_back(0);
    for (const double zoom : { 0.3, 0.4, 0.55, 0.75, 1.0 })
    {
      Follow(refinement, CameraAt(server.Description(), zoom), tree);
      all += refinement.Pieces().size();
    }
  }
  EXPECT_LT(pieces[0], pieces[1]);
  EXPECT_LT(pieces[1], pieces[2]);
}

TEST(TestViewRefinement, RefinesWhatWouldBeSeenToBeWrong)
{
  MemoryServer server = Torus();
  const ModelDescription& model = server.Description();
  KnownTree tree = WholeTree(server);
  std::size_t sizes[4] = {};
  for (int i = 0; i < 4; ++i)
  {
    ViewRefinement refinement(model, {});
    const Camera camera =
      CameraAt(model, std::array{ 0.1, 1.0, 4.0, 40.0 }[std::size_t(i)], 150, 300);
    refinement.Follow({ camera, tree, Nothing(), nullptr, true }, {}, {});
    EXPECT_EQ(refinement.Pieces(), WhatTheScreenNeeds(camera, model, tree));
    EXPECT_TRUE(tree.TakeMissing().empty());
    EXPECT_EQ(refinement.RemainingError(), 0);
    sizes[i] = refinement.Pieces().size();
  }
  EXPECT_EQ(sizes[0], 0u); // small on the screen: the preview is enough
  EXPECT_GT(sizes[1], 10u);
  EXPECT_GT(sizes[2], 10u);
  ViewRefinement near(model, {});
  Follow(near, CameraAt(model, 40, 150, 300), tree);
  EXPECT_EQ(near.Finest(), Resolution::Original());
}

// The model's description says which resolutions the server lets this client have.
TEST(TestViewRefinement, NothingIsWantedThatMayNotBeHad)
{
  MemoryServer server = Torus();
  ModelDescription model = server.Description();
  KnownTree tree = WholeTree(server);
  const Camera camera = CameraAt(model, 40, 150, 300);
  model.detail = ModelDetail::Levels;
  ViewRefinement levels(model, {});
  Follow(levels, camera, tree);
  EXPECT_EQ(levels.Finest(), Resolution::Level(model.depths.finest));
  model.detail = ModelDetail::Preview;
  ViewRefinement preview(model, {});
  Follow(preview, camera, tree);
  EXPECT_TRUE(preview.Pieces().empty());
}

TEST(TestViewRefinement, PiecesAboveComeFirstAndAreMoreUrgent)
{
  MemoryServer server = Torus();
  const ModelDescription& model = server.Description();
  KnownTree tree = WholeTree(server);
  ViewRefinement refinement(model, {});
  const Camera camera = CameraAt(model, 8, 150, 300);
  refinement.Follow({ camera, tree, Nothing(), nullptr, true }, {}, {});
  for (const PieceId piece : refinement.Pieces())
  {
    for (const PieceId below :
      piece.resolution.IsOriginal() ? std::vector<PieceId>() : Below(piece, model.depths))
    {
      if (Holds(refinement.Pieces(), below))
      {
        ASSERT_GE(
          refinement.UrgencyOf(piece, camera, tree), refinement.UrgencyOf(below, camera, tree));
      }
    }
  }
}

TEST(TestViewRefinement, BudgetsEndItAtTheLeastError)
{
  MemoryServer server = Torus();
  const ModelDescription& model = server.Description();
  KnownTree tree = WholeTree(server);
  const Camera camera = CameraAt(model, 4, 150, 300);
  ViewRefinement all(model, {});
  all.Follow({ camera, tree, Nothing(), nullptr, true }, {}, {});
  double left = 0;
  std::size_t pieces = all.Pieces().size();
  for (const std::uint64_t triangles : { 50'000, 20'000, 10'000, 8'000, 1'000 })
  {
    RefinementOptions options;
    options.triangles = triangles;
    ViewRefinement some(model, options);
    some.Follow({ camera, tree, Nothing(), nullptr, true }, {}, {});
    EXPECT_LE(some.Pieces().size(), pieces);
    EXPECT_GE(some.RemainingError(), left);
    pieces = some.Pieces().size();
    left = some.RemainingError();
  }
  EXPECT_GT(left, 1);
  EXPECT_EQ(pieces, 0u); // a budget below the preview's triangles

  RefinementOptions little;
  little.bytes = std::size_t{ 2 } << 20;
  ViewRefinement small(model, little);
  small.Follow({ camera, tree, Nothing(), nullptr, true }, {}, {});
  std::size_t bytes = 0;
  for (const PieceId piece : small.Pieces())
  {
    bytes += small.MemoryOf(piece);
  }
  EXPECT_LE(bytes, little.bytes);
  EXPECT_GT(small.RemainingError(), 1);
  EXPECT_FALSE(small.Pieces().empty());

  // Pieces that are wanted in any case use the budget first.
  std::vector<PieceId> tapped;
  for (NodeId i = 0; i < 40; ++i)
  {
    tapped.push_back({ Resolution::Original(), (NodeId{ 1 } << model.depths.partition) + i });
  }
  RefinementOptions some;
  some.triangles = 20'000;
  ViewRefinement without(model, some), with(model, some);
  without.Follow({ camera, tree, Nothing(), nullptr, true }, {}, {});
  with.Follow({ camera, tree, Nothing(), nullptr, true }, tapped, {});
  EXPECT_LT(with.Pieces().size(), without.Pieces().size());
}

TEST(TestViewRefinement, ALittleToAndFroChangesNothing)
{
  MemoryServer server = Torus();
  const ModelDescription& model = server.Description();
  KnownTree tree = WholeTree(server);
  ViewRefinement refinement(model, {});
  Follow(refinement, CameraAt(model, 1), tree);
  const std::vector<PieceId> near = refinement.Pieces();
  const Resolution finest = refinement.Finest();
  Follow(refinement, CameraAt(model, 0.86), tree);
  EXPECT_EQ(refinement.Pieces(), near);
  Follow(refinement, CameraAt(model, 0.2), tree);
  EXPECT_LT(refinement.Finest(), finest);
  ViewRefinement fresh(model, {});
  Follow(fresh, CameraAt(model, 0.86), tree);
  EXPECT_LT(fresh.Pieces().size(), near.size());
}

// Down to level S, all pieces above are needed; finer pieces can be shown without those between.
TEST(TestViewRefinement, WhatFailedIsNotWantedButWhatCanBeShownWithoutItIs)
{
  MemoryServer server = Torus();
  const ModelDescription& model = server.Description();
  KnownTree tree = WholeTree(server);
  const unsigned stitch = model.depths.stitch;
  ASSERT_LT(stitch, model.depths.finest);
  const Camera camera = CameraAt(model, 1);
  ViewRefinement whole(model, {});
  whole.Follow({ camera, tree, Nothing(), nullptr, false }, {}, {});
  std::size_t below = 0;
  for (const PieceId wanted : whole.Pieces())
  {
    for (unsigned level = PreviewLevel(model.depths) + 1; level <= model.depths.finest; ++level)
    {
      const Resolution resolution = Resolution::Level(level);
      if (!(resolution < wanted.resolution))
      {
        break;
      }
      const unsigned deeper = DepthOfNode(wanted.node) - PieceDepth(resolution, model.depths);
      const PieceId failed{ resolution, wanted.node >> deeper };
      ViewRefinement refinement(model, {});
      refinement.Follow({ camera, tree, Nothing(), nullptr, false }, {}, { failed });
      const std::set<PieceId> pieces(refinement.Pieces().begin(), refinement.Pieces().end());
      EXPECT_EQ(pieces.count(failed), 0u);
      EXPECT_EQ(pieces.count(wanted) != 0, level > stitch) << level;
      ++below;
    }
  }
  EXPECT_GT(below, 10u);
  // A piece of the original has no pieces below it; the piece above replaces it.
  ViewRefinement near(model, {});
  const Camera nearest = CameraAt(model, 40, 150, 300);
  near.Follow({ nearest, tree, Nothing(), nullptr, false }, {}, {});
  ASSERT_TRUE(near.Finest().IsOriginal());
  const PieceId last = near.Pieces().back();
  near.Follow({ nearest, tree, Nothing(), nullptr, false }, {}, { last });
  const std::set<PieceId> rest(near.Pieces().begin(), near.Pieces().end());
  EXPECT_EQ(rest.count(last), 0u);
  const unsigned up =
    DepthOfNode(last.node) - PieceDepth(Resolution::Level(model.depths.finest), model.depths);
  EXPECT_EQ(rest.count({ Resolution::Level(model.depths.finest), last.node >> up }), 1u);
}

TEST(TestViewRefinement, PagesAreAskedForAlongTheView)
{
  MemoryServer server(MakeTorus(400, 160), 32, 2);
  const ModelDescription& model = server.Description();
  KnownTree tree(model.depths, true, model.box, std::size_t{ 16 } << 20);
  ViewRefinement refinement(model, {});
  const Camera camera = CameraAt(model, 40, 150, 300);
  std::size_t pages = 0;
  for (std::set<protocol::BlobId> missing;;)
  {
    refinement.Follow({ camera, tree, Nothing(), nullptr, true }, {}, {});
    missing = tree.TakeMissing();
    if (missing.empty())
    {
      break;
    }
    for (const auto& blob : missing)
    {
      ASSERT_TRUE(tree.Add(blob, server.Blob(blob)));
      ++pages;
    }
  }
  EXPECT_LT(pages, TreePages(model.depths).size());
  KnownTree whole = WholeTree(server);
  ViewRefinement other(model, {});
  other.Follow({ camera, whole, Nothing(), nullptr, true }, {}, {});
  EXPECT_EQ(refinement.Pieces(), other.Pieces());
}

// Whatever pages contain, the walk ends within its budgets.
TEST(TestViewRefinement, LiesAboutErrorsEndAtABudget)
{
  MemoryServer server = Torus();
  const ModelDescription& model = server.Description();
  PieceTable lies = server.Table();
  for (unsigned d = 0; d <= model.depths.finest; ++d)
  {
    const NodeId first = NodeId{ 1 } << PieceDepth(Resolution::Level(d), model.depths);
    for (NodeId node = first; node < 2 * first; ++node)
    {
      auto& facts = lies.At({ Resolution::Level(d), node });
      facts.most99 = facts.most = std::numeric_limits<float>::max();
    }
  }
  server.TellOfPieces(lies);
  KnownTree tree = WholeTree(server);
  RefinementOptions options;
  options.triangles = 20'000;
  ViewRefinement refinement(model, options);
  Follow(refinement, CameraAt(model, 0.2), tree);
  EXPECT_GT(refinement.Pieces().size(), 3u);
  EXPECT_GT(refinement.RemainingError(), 1e30);
  EXPECT_LT(refinement.Pieces().size(), 200u);
}

// The estimated memory of pieces is about what they take, and not less.
TEST(TestViewRefinement, ReckonsMemory)
{
  MemoryServer server = Torus();
  const ModelDescription& model = server.Description();
  const ViewRefinement refinement(model, {});
  for (unsigned d = PreviewLevel(model.depths); d <= model.depths.finest + 1; ++d)
  {
    const bool level = d <= model.depths.finest;
    const Resolution resolution = level ? Resolution::Level(d) : Resolution::Original();
    const NodeId first = NodeId{ 1 } << PieceDepth(resolution, model.depths);
    std::size_t taken = 0;
    for (NodeId node = first; node < 2 * first; ++node)
    {
      const PieceId id{ resolution, node };
      taken +=
        MemoryOf(*DecodePiece(server.Blob(BlobOfPiece(id, model.depths)), id, server.Codec()));
    }
    const double reported = double(refinement.MemoryOf({ resolution, first })) * double(first);
    EXPECT_GT(reported, 0.9 * double(taken)) << d;
    EXPECT_LT(reported, 4 * double(taken)) << d;
  }
}

}
