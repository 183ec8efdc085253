// SPDX-License-Identifier: BSD-3-Clause
// The session that chooses by the view, against a server in memory: what is seen is fine, what is
// drawn is closed at every moment, and it comes to rest.
#include "viewer/session/Testing/SessionsByView.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

using namespace kdstream;
using kdstream::testing::CountBoundaryEdges;
using kdstream::testing::height;
using kdstream::testing::MakeTorus;
using kdstream::testing::MemoryServer;
using kdstream::testing::onRingX;
using kdstream::testing::onRingY;
using kdstream::testing::OpenFullScreen;
using kdstream::testing::width;
using protocol::BlobId;
using protocol::BlobKind;

namespace
{

// P = 9, levels 11 … 16: 64,000 vertices.
const MemoryServer& Torus()
{
  static const MemoryServer server(MakeTorus(400, 160), 128, 2);
  return server;
}

void ExpectClosed(const ViewerSession& session)
{
  ASSERT_EQ(CountBoundaryEdges(session.Scene().surface->Whole().triangles), 0u);
}

void DoubleTap(ViewerSession& session, double x, double y, double& clock)
{
  clock += 1;
  for (int i = 0; i < 2; ++i)
  {
    session.HandleTouches({ clock += 0.1, { { 1, x, y } } });
    session.HandleTouches({ clock += 0.05, {} });
  }
}

std::size_t VerticesOfOriginal(const ViewerSession& session)
{
  const auto& sources = session.Scene().surface->Whole().sources;
  return static_cast<std::size_t>(std::count_if(sources.begin(), sources.end(),
    [](const auto& source) { return source.resolution.IsOriginal(); }));
}

TEST(TestViewDetail, WhatIsSeenIsFineAndTheRestCostsNothing)
{
  MemoryServer server = Torus();
  ViewerSession session;
  OpenFullScreen(session, server);
  ASSERT_TRUE(session.IsIdle());
  const ViewerStatus whole = session.GetStatus();
  EXPECT_GT(whole.shownLevel, 11u);
  EXPECT_EQ(whole.shownLevel, whole.targetLevel);
  session.Zoom(40, onRingX, onRingY);
  server.Serve(session);
  const ViewerStatus near = session.GetStatus();
  EXPECT_TRUE(session.IsIdle());
  EXPECT_EQ(near.error, "");
  EXPECT_EQ(near.shownLevel, server.Codec().depths.finest);
  EXPECT_GT(VerticesOfOriginal(session), 100u) << "the finest is the original";
  EXPECT_LT(near.triangles, whole.triangles / 2) << "what is not on the screen is coarse";
  std::size_t partitions = 0, sent = 0;
  for (const BlobId& blob : server.sent)
  {
    partitions += blob.kind == BlobKind::Partition ? 1 : 0;
    sent += server.sent.count(blob) == 1 ? 0 : 1;
  }
  EXPECT_EQ(sent, 0u) << "nothing comes twice";
  EXPECT_LT(partitions, server.Description().partitions / 16);

  // And back: nothing has to be fetched.
  server.log.clear();
  session.Zoom(1.0 / 40, onRingX, onRingY);
  server.Serve(session);
  EXPECT_TRUE(server.log.empty());
  EXPECT_NEAR(
    double(session.GetStatus().triangles), double(whole.triangles), 0.3 * double(whole.triangles));
}

// What is on the line when it is called back comes all the same: it is kept, once, and not asked
// for again; what was never asked for is not taken.
TEST(TestViewDetail, WhatComesLateIsKept)
{
  MemoryServer server = Torus();
  std::vector<std::string> late; // what the trace tells of it
  SessionOptions options;
  options.TraceTo(
    [&late](std::string_view line)
    {
      if (line.find("\"late\"") != std::string_view::npos)
      {
        late.emplace_back(line);
      }
    });
  ViewerSession session(options);
  OpenFullScreen(session, server);
  session.Zoom(20, onRingX, onRingY);
  session.BeginFrame();
  std::vector<std::pair<std::uint32_t, BlobId>> onTheLine;
  for (const SessionRequest& request : session.TakeRequests())
  {
    for (const BlobId& blob : request.blobs)
    {
      onTheLine.emplace_back(request.id, blob);
    }
  }
  ASSERT_GT(onTheLine.size(), 2u);
  session.GoHome();
  session.Zoom(20, width - onRingX, onRingY); // elsewhere: it is called back
  session.BeginFrame();
  std::size_t cancels = 0;
  for (const SessionRequest& request : session.TakeRequests())
  {
    cancels += request.kind == SessionRequest::Kind::Cancel ? 1 : 0;
  }
  ASSERT_GT(cancels, 0u);
  const auto damaged = onTheLine.front();
  session.BlobArrived(damaged.first, damaged.second, std::vector<std::uint8_t>(100), 0.1, false);
  session.BlobArrived(damaged.first, BlobId::Partition(300), server.Blob(BlobId::Partition(300)),
    0.1, false); // not this request's
  for (const auto& [request, blob] : onTheLine)
  {
    session.BlobArrived(request, blob, server.Blob(blob), 0.1, false);
    session.BlobArrived(request, blob, server.Blob(blob), 0.1, false);
    ExpectClosed(session);
  }
  EXPECT_EQ(session.GetStatus().error, "");
  EXPECT_GT(late.size(), 0u);
  EXPECT_LE(late.size(), onTheLine.size()) << "each once";
  EXPECT_TRUE(std::none_of(late.begin(), late.end(),
    [](const std::string& line) { return line.find("partitions/300\"") != std::string::npos; }));
  server.Serve(session);
  server.sent.clear();
  session.GoHome();
  session.Zoom(20, onRingX, onRingY);
  server.Serve(session);
  std::size_t again = 0;
  for (const auto& [request, blob] : onTheLine)
  {
    again +=
      blob.kind != BlobKind::Tree && blob.kind != BlobKind::Boxes ? server.sent.count(blob) : 0;
  }
  EXPECT_LE(again, 1u) << "but for the one that came damaged";
  EXPECT_LE(session.GetTraffic().wasted, session.GetTraffic().bytes);
}

TEST(TestViewDetail, AStillCameraComesToRest)
{
  MemoryServer server = Torus();
  ViewerSession session;
  OpenFullScreen(session, server);
  session.Zoom(6, onRingX, onRingY);
  server.Serve(session);
  const auto version = session.Scene().surfaceVersion;
  const auto choices = session.Choices();
  server.log.clear();
  for (int i = 0; i < 10; ++i)
  {
    session.Resize({ width, height, 1 });
    session.BeginFrame();
    session.EndFrame(0.01);
    server.Take(session);
  }
  EXPECT_TRUE(session.IsIdle());
  EXPECT_TRUE(server.log.empty());
  EXPECT_EQ(session.Scene().surfaceVersion, version);
  EXPECT_EQ(session.Choices(), choices);
}

// What comes for a pinch to 1.4 times the size in the middle of the screen, after all was served.
std::size_t BytesOfAPinch(std::size_t aheadBytes, std::uint64_t& before, Surface& shown)
{
  MemoryServer server = Torus();
  SessionOptions options;
  options.aheadBytes = aheadBytes;
  ViewerSession session(options);
  OpenFullScreen(session, server);
  EXPECT_TRUE(session.IsIdle());
  before = session.GetTraffic().bytes;
  session.Zoom(1.4, width / 2.0, height / 2.0);
  std::uint64_t bytes = before;
  for (session.BeginFrame(); server.Take(session), !session.IsIdle(); session.BeginFrame())
  {
    EXPECT_TRUE(server.Answer(session));
    bytes = session.GetTraffic().bytes;
  }
  shown = session.Scene().surface->Whole();
  EXPECT_EQ(session.GetStatus().blobsWanted, 0u) << "what is fetched ahead is no progress";
  return bytes - before;
}

TEST(TestViewDetail, WhatIsWantedNextIsFetchedAhead)
{
  std::uint64_t without = 0, with = 0;
  Surface plain, ahead;
  const std::size_t fetched = BytesOfAPinch(0, without, plain);
  EXPECT_GT(fetched, 5'000u);
  EXPECT_LT(BytesOfAPinch(std::size_t{ 4 } << 20, with, ahead), fetched / 10);
  EXPECT_GT(with, without);
  EXPECT_EQ(ahead.sources, plain.sources) << "what is shown is the same";
  EXPECT_EQ(ahead.triangles, plain.triangles);

  std::uint64_t little = 0;
  BytesOfAPinch(8'000, little, ahead);
  EXPECT_GT(little, without);
  EXPECT_LT(little, without + 12'000) << "about as many bytes as are allowed";
  EXPECT_EQ(ahead.sources, plain.sources);
}

TEST(TestViewDetail, WhatIsFetchedAheadMakesWay)
{
  MemoryServer server = Torus();
  SessionOptions options;
  options.aheadBytes = std::size_t{ 4 } << 20;
  ViewerSession session(options);
  session.Resize({ width, height, 1 });
  ASSERT_TRUE(session.SelectModel("torus"));
  session.EnterFullScreen();
  for (server.Take(session); !session.IsIdle(); server.Take(session))
  {
    ASSERT_TRUE(server.Answer(session));
    session.BeginFrame();
  }
  const std::vector<BlobId> ahead = server.Outstanding();
  ASSERT_GT(ahead.size(), 2u);
  // Something else is wanted.
  session.Zoom(40, onRingX, onRingY);
  session.BeginFrame();
  EXPECT_FALSE(session.IsIdle());
  server.Take(session);
  const std::vector<BlobId> now = server.Outstanding();
  const std::set<BlobId> still(now.begin(), now.end());
  EXPECT_LT(std::count_if(ahead.begin(), ahead.end(),
              [&still](const BlobId& blob) { return still.count(blob) > 0; }),
    static_cast<std::ptrdiff_t>(ahead.size() / 2));
  server.Serve(session);
  EXPECT_TRUE(session.IsIdle());
  ExpectClosed(session);
}

// As of a server that is away, while all that is seen is in the cache.
TEST(TestViewDetail, WhatIsFetchedAheadMayFail)
{
  MemoryServer server = Torus();
  SessionOptions options;
  ViewerSession before(options);
  OpenFullScreen(before, server); // fetches what is seen, alone
  server.lie = [seen = server.sent](const BlobId& blob, std::vector<std::uint8_t>&)
  { return seen.count(blob) > 0; };
  server.sent.clear();
  options.aheadBytes = std::size_t{ 4 } << 20;
  ViewerSession session(options);
  OpenFullScreen(session, server);
  while (server.Take(session), !server.Outstanding().empty())
  {
    ASSERT_TRUE(server.Answer(session));
    session.BeginFrame();
  }
  EXPECT_TRUE(session.IsIdle());
  EXPECT_EQ(session.GetStatus().error, "");
  // What is wanted is told.
  session.Zoom(6, onRingX, onRingY);
  server.Serve(session);
  EXPECT_NE(session.GetStatus().error.find(" of torus cannot be had: "), std::string::npos);
}

// Finer than level S and than the preview: can be shown without what is between.
bool IsOnTheWay(PieceId piece, const TreeDepths& depths)
{
  return !piece.resolution.IsOriginal() && piece.resolution.Depth() > depths.stitch &&
         piece.node > 1;
}

TEST(TestViewDetail, WhatFailsIsToldOnlyWhereItIsMissed)
{
  const auto look = [](MemoryServer& server, const std::set<BlobId>& refused)
  {
    server.refused = refused;
    auto session = std::make_unique<ViewerSession>();
    OpenFullScreen(*session, server);
    EXPECT_TRUE(session->IsIdle());
    ExpectClosed(*session);
    return session;
  };
  MemoryServer server(MakeTorus(300, 120), 1024, 2); // many levels finer than S
  const TreeDepths depths = server.Codec().depths;
  const auto whole = look(server, {});
  std::set<BlobId> stepsAlone;
  std::optional<PieceId> used;
  for (const BlobId& blob : server.sent)
  {
    const PieceId piece = IsOfPiece(blob) ? PieceOfBlob(blob, depths) : PieceId{};
    if (IsOfPiece(blob) && IsOnTheWay(piece, depths))
    {
      const bool isUsed = whole->ShownPieces().count(piece) > 0;
      isUsed ? void(used = piece) : void(stepsAlone.insert(blob));
    }
  }
  ASSERT_FALSE(stepsAlone.empty());
  ASSERT_TRUE(used);
  // Came first alone, until something finer was there.
  const auto withoutSteps = look(server, stepsAlone);
  EXPECT_EQ(withoutSteps->GetStatus().error, "");
  EXPECT_EQ(withoutSteps->ShownPieces(), whole->ShownPieces());

  // What is below it stands in.
  const BlobId bad = BlobOfPiece(*used, depths);
  const auto otherwise = look(server, { bad });
  EXPECT_EQ(otherwise->GetStatus().error, "");
  EXPECT_GE(otherwise->GetStatus().triangles, whole->GetStatus().triangles);

  // Unless that cannot be had either.
  std::set<BlobId> all{ bad };
  for (const PieceId piece : otherwise->ShownPieces())
  {
    const unsigned deeper =
      std::max(DepthOfNode(piece.node), DepthOfNode(used->node)) - DepthOfNode(used->node);
    if (piece != *used && piece.node >> deeper == used->node)
    {
      all.insert(BlobOfPiece(piece, depths));
    }
  }
  ASSERT_GT(all.size(), 1u);
  EXPECT_NE(
    look(server, all)->GetStatus().error.find(" of torus cannot be had: "), std::string::npos);
}

// Steps never show holes, whatever comes in whatever order, while the view moves on.
TEST(TestViewDetail, TheSurfaceIsWholeAfterEveryArrival)
{
  for (const unsigned seed : { 1u, 2u, 3u, 4u })
  {
    std::mt19937 random(seed);
    MemoryServer server = Torus();
    SessionOptions options;
    options.refinement.triangles = seed == 4 ? 9'000 : 2'000'000;
    ViewerSession session(options);
    OpenFullScreen(session, server);
    double clock = 0;
    const auto chance = [&random](double most)
    { return most * double(random()) / double(std::mt19937::max()); };
    for (int step = 0; step < 12; ++step)
    {
      switch (random() % 4)
      {
        case 0:
          session.Zoom(1 + chance(3), 100 + chance(600), 100 + chance(400));
          break;
        case 1:
          session.Zoom(0.3 + chance(0.7), 400, 300);
          break;
        case 2:
          DoubleTap(session, 100 + chance(600), 100 + chance(400), clock);
          break;
        default:
          clock += 1;
          session.HandleTouches({ clock, { { 1, 300, 300 } } });
          session.HandleTouches({ clock += 0.1, { { 1, 300 + chance(200), 250 + chance(100) } } });
          session.HandleTouches({ clock += 0.1, {} });
      }
      for (auto answers = random() % 25; answers > 0; --answers)
      {
        session.BeginFrame();
        session.EndFrame(0.01);
        ExpectClosed(session);
        if (!server.Answer(session, &random))
        {
          break;
        }
      }
    }
    server.Serve(session, &random, [&session] { ExpectClosed(session); });
    EXPECT_TRUE(session.IsIdle());
    EXPECT_EQ(session.GetStatus().error, "");
  }
}

TEST(TestViewDetail, BudgetsHold)
{
  MemoryServer server = Torus();
  SessionOptions options;
  options.refinement.triangles = 8'000;
  ViewerSession session(options);
  OpenFullScreen(session, server);
  std::uint64_t most = 0;
  for (int i = 0; i < 8; ++i)
  {
    session.Zoom(1.6, onRingX, onRingY);
    server.Serve(session, nullptr, [&] { most = std::max(most, session.GetStatus().triangles); });
    EXPECT_TRUE(session.IsIdle());
  }
  EXPECT_GT(most, 5'000u);
  EXPECT_LT(most, 10'000u);
}

// What was looked at and found to be out of sight is not asked for again when its piece has been
// evicted.
TEST(TestViewDetail, WithoutRoomForMoreThanIsShownItComesToRestToo)
{
  MemoryServer server = Torus();
  SessionOptions options;
  options.cacheBytes = 0;
  ViewerSession session(options);
  OpenFullScreen(session, server);
  std::size_t frames = 0;
  for (int i = 0; i < 6; ++i)
  {
    session.Zoom(1.7, onRingX, onRingY);
    do
    {
      session.BeginFrame();
      session.EndFrame(0.01);
      ASSERT_LT(++frames, 3000u);
    } while (server.Answer(session));
    EXPECT_TRUE(session.IsIdle());
  }
}

TEST(TestViewDetail, ATapComesFirst)
{
  MemoryServer server = Torus();
  ViewerSession session;
  OpenFullScreen(session, server);
  double clock = 0;
  session.Zoom(5, onRingX, onRingY);
  session.BeginFrame();
  server.Take(session); // much is wanted
  for (int i = 0; i < 4; ++i)
  {
    server.Answer(session);
  }
  session.BeginFrame();
  server.sent.clear();
  DoubleTap(session, 400, 300, clock);
  ASSERT_TRUE(session.GetStatus().picking || session.GetStatus().region);
  // The tree around it alone, then the way down to the partition: a piece of each level that is not
  // there yet. What was under way before is called back.
  std::size_t before = 0;
  while (session.GetStatus().region == std::nullopt || session.GetStatus().region->shown == 0)
  {
    server.Take(session);
    const std::vector<BlobId> outstanding = server.Outstanding();
    if (!session.GetStatus().region)
    {
      EXPECT_TRUE(std::none_of(outstanding.begin(), outstanding.end(), IsOfPiece));
    }
    ASSERT_TRUE(server.Answer(session));
    session.BeginFrame();
    ++before;
    ASSERT_LT(before, 100u);
  }
  EXPECT_LE(before, 8u);
  server.Serve(session);
  const auto region = session.GetStatus().region;
  ASSERT_TRUE(region);
  EXPECT_EQ(region->shown, region->partitions);
  ExpectClosed(session);

  // The next one adds to it.
  const std::size_t originals = VerticesOfOriginal(session);
  DoubleTap(session, 430, 340, clock);
  server.Serve(session);
  ASSERT_TRUE(session.GetStatus().region);
  EXPECT_GE(VerticesOfOriginal(session), originals);
  DoubleTap(session, -1e6, -1e6, clock);
  EXPECT_FALSE(session.GetStatus().region);
}

// Far away nothing of what was tapped or looked at is left.
TEST(TestViewDetail, WithPreviewsOnlyZoomsAndTapsWait)
{
  MemoryServer server = Torus();
  ViewerSession session;
  session.SetPreviewsOnly(true);
  OpenFullScreen(session, server);
  session.SetAhead(1 << 20);
  const std::size_t sent = server.sent.size();
  ASSERT_GT(sent, 0u);
  double clock = 0;
  session.Zoom(4, onRingX, onRingY);
  server.Serve(session);
  DoubleTap(session, width / 2.0, height / 2.0, clock); // goes home, or picks
  session.Zoom(4, onRingX, onRingY);
  DoubleTap(session, onRingX, onRingY, clock);
  server.Serve(session);
  EXPECT_EQ(server.sent.size(), sent) << "nothing but the preview";
  EXPECT_EQ(session.GetStatus().shownLevel, 11u);
  EXPECT_EQ(session.GetStatus().error, "");
  EXPECT_FALSE(session.GetStatus().region);
  EXPECT_TRUE(session.GetStatus().picking);

  session.SetPreviewsOnly(false);
  server.Serve(session);
  EXPECT_TRUE(session.GetStatus().region) << "the last tap";
  EXPECT_FALSE(session.GetStatus().picking);
  EXPECT_GT(VerticesOfOriginal(session), 100u);
  EXPECT_TRUE(session.IsIdle());
  ExpectClosed(session);
}

TEST(TestViewDetail, FarAwayThePreviewIsEnough)
{
  MemoryServer server = Torus();
  ViewerSession session;
  OpenFullScreen(session, server);
  double clock = 0;
  for (int i = 0; i < 3; ++i)
  {
    session.Zoom(1.7, 400, 300);
    session.Zoom(1.1, onRingX, onRingY);
    server.Serve(session);
    DoubleTap(session, 200 + 60 * i, 300, clock);
    server.Serve(session);
  }
  EXPECT_TRUE(session.GetStatus().original);
  for (int i = 0; i < 40; ++i)
  {
    session.Zoom(0.87, 400, 300);
    server.Serve(session);
    ExpectClosed(session);
  }
  const ViewerStatus status = session.GetStatus();
  EXPECT_FALSE(status.region);
  EXPECT_FALSE(status.original);
  EXPECT_EQ(status.shownLevel, 11u);
}

TEST(TestViewDetail, WhatIsNotWantedAnyMoreIsCalledBack)
{
  MemoryServer server = Torus();
  ViewerSession session;
  OpenFullScreen(session, server);
  session.Zoom(8, onRingX, onRingY);
  for (int i = 0; i < 6; ++i)
  {
    session.BeginFrame();
    ASSERT_TRUE(server.Answer(session));
  }
  ASSERT_FALSE(session.IsIdle());
  server.log.clear();
  session.Zoom(1.0 / 8, onRingX, onRingY);
  session.Zoom(8, width - onRingX, onRingY);
  session.BeginFrame();
  server.Take(session);
  EXPECT_TRUE(std::any_of(server.log.begin(), server.log.end(),
    [](const std::string& request)
    { return request.find("\"kind\":\"cancel\"") != std::string::npos; }));
  server.Serve(session);
  EXPECT_TRUE(session.IsIdle());
}

// So that a turn is answered at once: little is under way on a slow line (the server's is 0.25 s a
// blob).
TEST(TestViewDetail, LittleIsUnderWayOnASlowLine)
{
  MemoryServer server = Torus();
  ViewerSession session;
  OpenFullScreen(session, server);
  session.Zoom(30, onRingX, onRingY);
  std::size_t most = 0;
  server.Serve(session, nullptr,
    [&]
    {
      std::size_t underWay = 0;
      for (const auto& blob : server.Outstanding())
      {
        underWay += server.Blob(blob).size();
      }
      most = std::max(most, underWay);
    });
  EXPECT_GT(most, 0u);
  EXPECT_LT(most, 16u * 1024);
}

TEST(TestViewDetail, WhatFailsStaysCoarseAndIsNotAskedForAgain)
{
  MemoryServer server = Torus();
  ViewerSession session;
  constexpr unsigned level = 13;
  const NodeId first = NodeId{ 1 } << PieceDepth(Resolution::Level(level), server.Codec().depths);
  for (NodeId node = first; node < 2 * first; node += 2)
  {
    server.refused.insert(BlobId::LevelPiece(static_cast<std::uint8_t>(level), node));
  }
  OpenFullScreen(session, server);
  session.Resize({ 2 * width, 2 * height, 1 });
  server.Serve(session, nullptr, [&session] { ExpectClosed(session); });
  EXPECT_TRUE(session.IsIdle());
  EXPECT_NE(
    session.GetStatus().error.find("levels/" + std::to_string(level) + "/"), std::string::npos)
    << session.GetStatus().error;
  EXPECT_GE(session.GetStatus().shownLevel, level);

  server.refused.clear();
  server.log.clear();
  session.Resize({ 2 * width, 2 * height + 1, 1 });
  server.Serve(session);
  for (const std::string& request : server.log)
  {
    EXPECT_EQ(request.find("levels/" + std::to_string(level) + "/" + std::to_string(first) + "\""),
      std::string::npos)
      << request;
  }
  session.Zoom(1.01, onRingX, onRingY); // asks again
  server.Serve(session);
  EXPECT_EQ(session.GetStatus().error, "");
}

// A scan with fewer vertices than the preview could have is shown as it is.
TEST(TestViewDetail, ASmallScanIsShownAsItIs)
{
  const Mesh mesh = MakeTorus(60, 30);
  MemoryServer server(mesh, 128, 2);
  ViewerSession session;
  OpenFullScreen(session, server);
  session.Zoom(3, 400, 300);
  session.Zoom(0.4, 400, 300);
  session.Resize({ 4 * width, 4 * height, 1 });
  server.Serve(session);
  EXPECT_EQ(VerticesOfOriginal(session), mesh.points.size());
  EXPECT_EQ(session.GetStatus().triangles, mesh.triangles.size());
}

TEST(TestViewDetail, FullShowsAllOfTheOriginal)
{
  MemoryServer server = Torus();
  SessionOptions options;
  options.detail = DetailMode::Full;
  ViewerSession session(options);
  OpenFullScreen(session, server);
  EXPECT_TRUE(session.IsIdle());
  EXPECT_EQ(session.GetStatus().triangles, server.Description().triangles);
  ExpectClosed(session);
  session.LeaveFullScreen();
  server.Serve(session);
  EXPECT_EQ(session.GetStatus().triangles, server.Description().levels[11].triangles);
}

// A server that sends pieces for others, parts of them, nothing, or the same twice, and whose pages
// lie about errors: no endless refinement, no livelock. The surface is whole, but where a piece is
// another's, which no piece alone can tell.
TEST(TestViewDetail, AServerThatLiesIsSurvived)
{
  for (const unsigned seed : { 1u, 2u, 3u, 4u, 5u, 6u })
  {
    std::mt19937 random(seed);
    MemoryServer server = Torus();
    PieceTable lies = server.Table();
    for (unsigned d = 11; d <= server.Codec().depths.finest; ++d)
    {
      const NodeId first = NodeId{ 1 } << PieceDepth(Resolution::Level(d), server.Codec().depths);
      for (NodeId node = first; node < 2 * first; ++node)
      {
        auto& facts = lies.At({ Resolution::Level(d), node });
        facts.most99 = random() % 3 == 0 ? 1e30F : 0;
        facts.most = std::max(facts.most99, facts.most);
        facts.bytes = static_cast<std::uint32_t>(random() % 5 == 0 ? 60'000'000 : 1);
      }
    }
    server.TellOfPieces(lies);
    SessionOptions options;
    options.refinement.triangles = 60'000;
    ViewerSession session(options);
    OpenFullScreen(session, server);
    const std::vector<BlobId> all = server.AllBlobs();
    const bool swaps = seed % 2 == 0;
    std::size_t answers = 0, told = 0;
    for (int step = 0; step < 8; ++step)
    {
      session.Zoom(step % 3 == 2 ? 0.4 : 2.5, 100 + 40 * step, 300);
      server.lie = [&](const BlobId& blob, std::vector<std::uint8_t>& bytes)
      {
        const auto dice = random() % 10;
        if (dice == 0 && swaps)
        {
          bytes = server.Blob(all[random() % all.size()]);
        }
        else if (dice == 1)
        {
          bytes.resize(random() % (bytes.size() + 1));
        }
        else if (dice == 2)
        {
          session.BlobArrived(static_cast<std::uint32_t>(random() % 100), blob, bytes, 0.01, false);
        }
        return dice != 3; // else: it fails
      };
      do
      {
        session.BeginFrame();
        if (!swaps)
        {
          ExpectClosed(session);
        }
        session.EndFrame(0.01);
        ASSERT_LT(++answers, 20'000u);
      } while (server.Answer(session, &random));
      EXPECT_TRUE(session.IsIdle());
      EXPECT_LT(session.GetStatus().triangles, 100'000u);
      told += session.GetStatus().error.find(" of torus cannot be had") != std::string::npos;
    }
    EXPECT_GT(told, 0u);
  }
}

TEST(TestViewDetail, CountsWhatWasWasted)
{
  MemoryServer server = Torus();
  ViewerSession session;
  OpenFullScreen(session, server);
  std::uint64_t bytes = 0;
  for (const BlobId& blob : server.sent)
  {
    bytes += server.Blob(blob).size();
  }
  EXPECT_EQ(session.GetTraffic().blobs, server.sent.size());
  EXPECT_EQ(session.GetTraffic().bytes, bytes);
  EXPECT_EQ(session.GetTraffic().wasted, 0u);
  const auto piece = BlobId::Partition(0);
  session.BlobArrived(4711, piece, server.Blob(piece), 0, false); // nobody asked
  EXPECT_EQ(session.GetTraffic().wasted, server.Blob(piece).size());
}

}
