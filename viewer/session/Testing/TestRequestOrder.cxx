// SPDX-License-Identifier: BSD-3-Clause
// The order in which a view requests (doc/viewing.md#requests): the tree first, coarse before fine,
// the worst error first, the middle of the screen before its edges. Without prefetching, nothing
// else is requested. The expected order is computed from the server's own tables.
#include "viewer/session/SessionParts.h"
#include "viewer/session/Testing/SessionsByView.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <random>
#include <set>
#include <utility>
#include <vector>

using namespace kdstream;
using namespace kdstream::testing;
using protocol::BlobId;

namespace
{

// What a view should request, computed from the facts about pieces in the server's pages.
class Expectation
{
public:
  Expectation(const MemoryServer& server, const Camera& camera)
    : Server(server)
    , Eye(camera)
  {
  }

  const TreeDepths& Depths() const { return this->Server.Codec().depths; }
  // The piece of the next coarser resolution.
  PieceId Above(PieceId piece) const
  {
    const TreeDepths& depths = this->Server.Codec().depths;
    const auto coarser = Resolution::Level(
      piece.resolution.IsOriginal() ? depths.finest : piece.resolution.Depth() - 1);
    return { coarser, piece.node >> (DepthOfNode(piece.node) - PieceDepth(coarser, depths)) };
  }
  bool IsBelowPreview(PieceId piece) const
  {
    return piece.resolution != Resolution::Level(PreviewLevel(this->Server.Codec().depths));
  }
  // The error of a piece, in points of the screen.
  double Error(PieceId piece) const
  {
    const PieceId above = this->Above(piece);
    const ModelDescription& model = this->Server.Description();
    const double vertices = static_cast<double>(model.levels[above.resolution.Depth()].vertices) /
                            std::ldexp(1.0, static_cast<int>(DepthOfNode(above.node)));
    const Box around = RoundedBoxOf(this->Server.Tree(), above.node);
    const double geometricError = std::max<double>(RoundedUp(this->Server.Table().At(above)).most99,
      LightPartOf(model) * VertexSpacing(around, vertices));
    const Box box = RoundedBoxOf(this->Server.Tree(), piece.node);
    return geometricError * this->Eye.PointsPerUnit(std::max(this->Eye.DistanceTo(box), 1e-6));
  }
  // The urgency: the error, halved at the upper and lower edges of the screen.
  double Urgency(PieceId piece) const
  {
    const Box box = RoundedBoxOf(this->Server.Tree(), piece.node);
    const double away = this->Eye.Eccentricity(box.lo * 0.5 + box.hi * 0.5);
    return this->Error(piece) / (1 + std::min(away * away, 100.0));
  }
  // The urgency, which is never more than that of a piece above.
  double LeastUrgency(PieceId piece) const
  {
    double least = this->Urgency(piece);
    for (PieceId each = this->Above(piece); this->IsBelowPreview(each); each = this->Above(each))
    {
      least = std::min(least, this->Urgency(each));
    }
    return least;
  }

private:
  const MemoryServer& Server;
  const Camera& Eye;
};

// What the session has requested since one of its choices, in order.
class AskedInOrder
{
public:
  void Note(ViewerSession& session, MemoryServer& server)
  {
    server.Take(session);
    if (session.Parts().lod.Choices() != this->Choice)
    {
      this->Finish(session, server);
      this->Choice = session.Parts().lod.Choices();
    }
    for (const BlobId& blob : server.Outstanding())
    {
      if (this->Before.count(blob) == 0)
      {
        this->Asked.push_back(blob);
        this->FollowsWhatIsAbove(blob, Expectation(server, session.GetCamera()));
      }
    }
    const std::vector<BlobId> now = server.Outstanding();
    this->Before = { now.begin(), now.end() };
  }

  void Finish(const ViewerSession& session, const MemoryServer& server)
  {
    const std::vector<BlobId> asked = std::exchange(this->Asked, {});
    const TreeDepths& depths = server.Codec().depths;
    const Expectation expected(server, session.GetCamera());
    const auto firstPiece = std::find_if(asked.begin(), asked.end(), IsOfPiece);
    EXPECT_EQ(std::count_if(firstPiece, asked.end(), IsOfTree), 0) << "the tree comes first";
    std::vector<PieceId> pieces;
    std::transform(firstPiece, asked.end(), std::back_inserter(pieces),
      [&depths](const BlobId& blob) { return PieceOfBlob(blob, depths); });
    for (std::size_t i = 0; i < pieces.size(); ++i)
    {
      for (std::size_t j = i + 1; j < pieces.size(); ++j)
      {
        this->Compare(pieces[i], pieces[j], expected);
      }
    }
  }

  std::size_t worseFirst = 0, middleFirst = 0, coarseFirst = 0; // pairs, by rule

private:
  // Down to level S, no piece is requested before the piece above it; and no piece finer than S
  // before the one of level S above it.
  void FollowsWhatIsAbove(const BlobId& blob, const Expectation& expected)
  {
    const TreeDepths& depths = expected.Depths();
    if (!IsOfPiece(blob))
    {
      return;
    }
    PieceId piece = PieceOfBlob(blob, depths);
    this->Ever.insert(piece);
    if (!expected.IsBelowPreview(piece))
    {
      return;
    }
    do
    {
      piece = expected.Above(piece);
    } while (piece.resolution.Depth() > depths.stitch && expected.IsBelowPreview(piece));
    if (expected.IsBelowPreview(piece))
    {
      ASSERT_EQ(this->Ever.count(piece), 1u) << "coarse before fine";
      ++this->coarseFirst;
    }
  }
  // Checks the order of two pieces, of which `first` was requested first.
  void Compare(PieceId first, PieceId second, const Expectation& expected)
  {
    if (!expected.IsBelowPreview(first) || !expected.IsBelowPreview(second))
    {
      return;
    }
    constexpr double deadBand = 1.25 * 1.01;
    const double most = deadBand * expected.Urgency(first);
    ASSERT_GE(most, expected.LeastUrgency(second)) << "the worst first";
    if (expected.LeastUrgency(first) > deadBand * expected.Urgency(second))
    {
      ++this->worseFirst;
      this->middleFirst += expected.Error(first) < expected.Error(second) ? 1 : 0;
    }
  }

  std::uint64_t Choice = 0;
  std::set<BlobId> Before;
  std::set<PieceId> Ever;
  std::vector<BlobId> Asked;
};

TEST(TestRequestOrder, CoarseBeforeFineTheWorstFirstTheMiddleBeforeTheEdge)
{
  std::size_t worseFirst = 0, middleFirst = 0, coarseFirst = 0;
  for (const unsigned seed : { 1u, 2u, 3u, 4u, 5u, 6u, 7u, 8u })
  {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> part(0, 1);
    MemoryServer server = Torus();
    ViewerSession session;
    session.Resize({ width, height, 1 });
    ASSERT_TRUE(session.SelectModel("torus"));
    server.Serve(session);
    const double x = width * part(random), y = height * part(random);
    session.HandleTouches({ 1, { { 1, x, y } } });
    session.HandleTouches({ 1.1, { { 1, width * part(random), height * part(random) } } });
    session.HandleTouches({ 1.2, {} });
    session.Zoom(std::exp2(4 * part(random)), width * part(random), height * part(random));
    session.EnterFullScreen();
    AskedInOrder asked;
    do
    {
      session.BeginFrame();
      asked.Note(session, server);
      ASSERT_FALSE(::testing::Test::HasFatalFailure()) << "seed " << seed;
    } while (server.Answer(session));
    asked.Finish(session, server);
    EXPECT_TRUE(session.IsIdle());
    worseFirst += asked.worseFirst;
    middleFirst += asked.middleFirst;
    coarseFirst += asked.coarseFirst;
  }
  EXPECT_GT(worseFirst, 100u);
  EXPECT_GT(middleFirst, 10u);
  EXPECT_GT(coarseFirst, 100u);
}

std::size_t Sent(std::size_t ahead, bool turnOff)
{
  MemoryServer server = Torus();
  SessionOptions options;
  options.prefetchBytes = ahead;
  ViewerSession session(options);
  if (turnOff)
  {
    session.SetPrefetch(0);
  }
  OpenFullScreen(session, server);
  session.Zoom(2, onRingX, onRingY);
  server.Serve(session);
  EXPECT_TRUE(session.IsIdle());
  for (int frame = 0; frame < 10; ++frame)
  {
    session.BeginFrame();
    server.Take(session);
    EXPECT_EQ(server.Outstanding().size(), 0u) << "of a session that rests";
  }
  return server.sent.size();
}

TEST(TestRequestOrder, WhatIsTurnedOffIsNotPrefetched)
{
  constexpr std::size_t much = std::size_t{ 4 } << 20;
  const std::size_t without = Sent(0, false);
  EXPECT_GT(Sent(much, false), without);
  EXPECT_EQ(Sent(much, true), without);
}

// Turning prefetching off cancels the prefetches in flight.
TEST(TestRequestOrder, TurningItOffCancelsWhatIsInFlight)
{
  MemoryServer server = Torus();
  SessionOptions options;
  options.prefetchBytes = std::size_t{ 4 } << 20;
  ViewerSession session(options);
  OpenUntilIdle(session, server);
  ASSERT_GT(server.Outstanding().size(), 0u);
  session.SetPrefetch(0);
  server.Take(session);
  EXPECT_EQ(server.Outstanding().size(), 0u);
  const std::size_t sent = server.sent.size();
  server.Serve(session);
  EXPECT_EQ(server.sent.size(), sent);
  EXPECT_TRUE(session.IsIdle());
}

}
