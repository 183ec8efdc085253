// SPDX-License-Identifier: BSD-3-Clause
// What the session in view mode requests from a server: the order, prefetches, cancels, and what it
// does about blobs that arrive late, damaged, or not at all.
#include "viewer/session/SessionParts.h"
#include "viewer/session/Testing/SessionsByView.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

using namespace kdstream;
using namespace kdstream::testing;
using protocol::BlobId;
using protocol::BlobKind;

namespace
{

// Cancelled blobs that were in flight still arrive. They are kept, once, and not requested again.
// Blobs that were never requested are not accepted.
TEST(TestViewFetching, WhatComesLateIsKept)
{
  MemoryServer server = Torus();
  std::vector<std::string> late; // lines of the trace about late blobs
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
  std::vector<std::pair<std::uint32_t, BlobId>> inFlight;
  for (const SessionRequest& request : session.TakeRequests())
  {
    for (const BlobId& blob : request.blobs)
    {
      inFlight.emplace_back(request.id, blob);
    }
  }
  ASSERT_GT(inFlight.size(), 2u);
  session.GoHome();
  session.Zoom(20, width - onRingX, onRingY); // elsewhere: cancels what is in flight
  session.BeginFrame();
  std::size_t cancels = 0;
  for (const SessionRequest& request : session.TakeRequests())
  {
    cancels += request.kind == SessionRequest::Kind::Cancel ? 1 : 0;
  }
  ASSERT_GT(cancels, 0u);
  const auto damaged = inFlight.front();
  EXPECT_EQ(
    session.BlobArrived(damaged.first, damaged.second, std::vector<std::uint8_t>(100), 0.1, false),
    BlobArrival::Damaged);
  EXPECT_EQ(session.BlobArrived(damaged.first, BlobId::Partition(300),
              server.Blob(BlobId::Partition(300)), 0.1, false),
    BlobArrival::Unwanted); // not a blob of this request
  for (const auto& [request, blob] : inFlight)
  {
    EXPECT_EQ(session.BlobArrived(request, blob, server.Blob(blob), 0.1, false),
      blob == damaged.second ? BlobArrival::Unwanted : BlobArrival::Taken);
    EXPECT_EQ(
      session.BlobArrived(request, blob, server.Blob(blob), 0.1, false), BlobArrival::Unwanted);
    ExpectClosed(session);
  }
  EXPECT_EQ(session.GetStatus().error, "");
  EXPECT_GT(late.size(), 0u);
  EXPECT_LE(late.size(), inFlight.size()) << "each once";
  EXPECT_TRUE(std::none_of(late.begin(), late.end(),
    [](const std::string& line) { return line.find("partitions/300\"") != std::string::npos; }));
  server.Serve(session);
  server.sent.clear();
  session.GoHome();
  session.Zoom(20, onRingX, onRingY);
  server.Serve(session);
  std::size_t again = 0;
  for (const auto& [request, blob] : inFlight)
  {
    again +=
      blob.kind != BlobKind::Tree && blob.kind != BlobKind::Boxes ? server.sent.count(blob) : 0;
  }
  EXPECT_LE(again, 1u) << "but for the one that came damaged";
  EXPECT_LE(session.GetTraffic().wasted, session.GetTraffic().bytes);
}

// The bytes that arrive for a pinch to 1.4 times the size, in the middle of the screen, after
// everything has been served.
std::size_t BytesOfAPinch(std::size_t prefetchBytes, std::uint64_t& before, Surface& shown)
{
  MemoryServer server = Torus();
  SessionOptions options;
  options.prefetchBytes = prefetchBytes;
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

TEST(TestViewFetching, WhatIsWantedNextIsPrefetched)
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

TEST(TestViewFetching, WhatIsPrefetchedMakesWay)
{
  MemoryServer server = Torus();
  SessionOptions options;
  options.prefetchBytes = std::size_t{ 4 } << 20;
  ViewerSession session(options);
  OpenUntilIdle(session, server);
  const std::vector<BlobId> ahead = server.Outstanding();
  ASSERT_GT(ahead.size(), 2u);
  // Now other pieces are wanted.
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

// As if the server is away, and everything that is visible is in the cache.
TEST(TestViewFetching, WhatIsPrefetchedMayFail)
{
  MemoryServer server = Torus();
  SessionOptions options;
  ViewerSession before(options);
  OpenFullScreen(before, server); // fetches only what is visible
  server.lie = [seen = server.sent](const BlobId& blob, std::vector<std::uint8_t>&)
  { return seen.count(blob) > 0; };
  server.sent.clear();
  options.prefetchBytes = std::size_t{ 4 } << 20;
  ViewerSession session(options);
  OpenFullScreen(session, server);
  while (server.Take(session), !server.Outstanding().empty())
  {
    ASSERT_TRUE(server.Answer(session));
    session.BeginFrame();
  }
  EXPECT_TRUE(session.IsIdle());
  EXPECT_EQ(session.GetStatus().error, "");
  // Wanted pieces that fail are reported.
  session.Zoom(6, onRingX, onRingY);
  server.Serve(session);
  EXPECT_NE(session.GetStatus().error.find(" of torus cannot be loaded: "), std::string::npos);
}

// BlobArrived says that a prefetched blob is damaged, because a web page keeps only undamaged
// blobs; but the user gets no message.
TEST(TestViewFetching, ADamagedBlobIsReportedToItsBringerAlsoWhereNobodyMissesIt)
{
  MemoryServer server = Torus();
  SessionOptions options;
  options.prefetchBytes = std::size_t{ 4 } << 20;
  ViewerSession session(options);
  kdstream::testing::OpenUntilIdle(session, server);
  ASSERT_FALSE(session.Parts().fetcher.Wishes().Book().AllOutstanding().empty());
  const auto [blob, request] = *session.Parts().fetcher.Wishes().Book().AllOutstanding().rbegin();
  EXPECT_EQ(session.BlobArrived(request, blob, std::vector<std::uint8_t>(100), 0.1, false),
    BlobArrival::Damaged);
  EXPECT_EQ(session.GetStatus().error, "");
}

// Finer than level S and than the preview, but not the original. Such a piece only comes in
// between: finer ones can be shown without it.
bool IsIntermediate(PieceId piece, const TreeDepths& depths)
{
  return !piece.resolution.IsOriginal() && piece.resolution.Depth() > depths.stitch &&
         piece.node > 1;
}

TEST(TestViewFetching, WhatFailsIsReportedOnlyWhereItIsMissed)
{
  const auto viewAll = [](MemoryServer& server, const std::set<BlobId>& refused)
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
  const auto whole = viewAll(server, {});
  std::set<BlobId> stepsAlone;
  std::optional<PieceId> used;
  for (const BlobId& blob : server.sent)
  {
    const PieceId piece = IsOfPiece(blob) ? PieceOfBlob(blob, depths) : PieceId{};
    if (IsOfPiece(blob) && IsIntermediate(piece, depths))
    {
      const bool isUsed = whole->Parts().model.surface.Pieces().count(piece) > 0;
      isUsed ? void(used = piece) : void(stepsAlone.insert(blob));
    }
  }
  ASSERT_FALSE(stepsAlone.empty());
  ASSERT_TRUE(used);
  // These pieces only came first, and were replaced by finer ones: without them, the result is the
  // same.
  const auto withoutSteps = viewAll(server, stepsAlone);
  EXPECT_EQ(withoutSteps->GetStatus().error, "");
  EXPECT_EQ(withoutSteps->Parts().model.surface.Pieces(), whole->Parts().model.surface.Pieces());

  // If a used piece fails, the pieces below it replace it.
  const BlobId bad = BlobOfPiece(*used, depths);
  const auto otherwise = viewAll(server, { bad });
  EXPECT_EQ(otherwise->GetStatus().error, "");
  EXPECT_GE(otherwise->GetStatus().triangles, whole->GetStatus().triangles);

  // It is reported if those cannot be fetched either.
  std::set<BlobId> all{ bad };
  for (const PieceId piece : otherwise->Parts().model.surface.Pieces())
  {
    const unsigned deeper =
      std::max(DepthOfNode(piece.node), DepthOfNode(used->node)) - DepthOfNode(used->node);
    if (piece != *used && piece.node >> deeper == used->node)
    {
      all.insert(BlobOfPiece(piece, depths));
    }
  }
  ASSERT_GT(all.size(), 1u);
  EXPECT_NE(viewAll(server, all)->GetStatus().error.find(" of torus cannot be loaded: "),
    std::string::npos);
}

// Loses everything that is requested now; returns how many requests that were.
std::size_t Lose(ViewerSession& session)
{
  session.BeginFrame();
  const std::vector<SessionRequest> requests = session.TakeRequests();
  for (const SessionRequest& request : requests)
  {
    session.RequestFailed(request.id, "the line was lost");
  }
  return requests.size();
}

// Loses everything that is requested, until nothing is requested any more, which takes at most 9
// rounds.
void LoseAll(ViewerSession& session)
{
  for (int round = 0; round < 9; ++round)
  {
    Lose(session);
  }
  EXPECT_TRUE(session.IsIdle());
  EXPECT_NE(session.GetStatus().error.find("the line was lost"), std::string::npos);
}

void TurnALittle(ViewerSession& session)
{
  session.HandleTouches({ 1, { { 1, 300, 300 } } });
  session.HandleTouches({ 2, { { 1, 330, 310 } } });
  session.HandleTouches({ 3, {} });
}

// Blobs that fail together with their whole request are requested again as soon as anything
// arrives.
TEST(TestViewFetching, WhatALostLineTookIsHadOnceItIsBack)
{
  MemoryServer server = Torus();
  ViewerSession lucky, session;
  for (ViewerSession* each : { &lucky, &session })
  {
    OpenFullScreen(*each, server);
    each->Zoom(6, onRingX, onRingY);
  }
  LoseAll(session);
  for (ViewerSession* each : { &lucky, &session })
  {
    TurnALittle(*each);
    server.Serve(*each);
  }
  EXPECT_EQ(session.GetStatus().error, "");
  EXPECT_EQ(session.Parts().model.surface.Pieces(), lucky.Parts().model.surface.Pieces());
}

// The connection is lost again before all of it has arrived.
TEST(TestViewFetching, WhatIsLostAgainIsHadToo)
{
  for (const std::size_t answers : { 2u, 3u, 5u, 8u })
  {
    MemoryServer server = Torus();
    ViewerSession lucky, session;
    for (ViewerSession* each : { &lucky, &session })
    {
      OpenFullScreen(*each, server);
      each->Zoom(6, onRingX, onRingY);
    }
    LoseAll(session);
    TurnALittle(lucky);
    server.Serve(lucky);
    TurnALittle(session);
    std::vector<std::uint32_t> unanswered;
    for (std::size_t come = 0; come < answers;)
    {
      session.BeginFrame();
      for (const SessionRequest& request : session.TakeRequests())
      {
        unanswered.push_back(request.id);
        for (const BlobId& blob : request.blobs)
        {
          if (come < answers)
          {
            ++come;
            session.BlobArrived(request.id, blob, server.Blob(blob), 0.1, false);
          }
        }
      }
    }
    for (const std::uint32_t request : unanswered)
    {
      session.RequestFailed(request, "the line was lost");
    }
    LoseAll(session);
    TurnALittle(session);
    TurnALittle(lucky);
    server.Serve(session);
    server.Serve(lucky);
    EXPECT_EQ(session.GetStatus().error, "") << answers;
    EXPECT_EQ(session.Parts().model.surface.Pieces(), lucky.Parts().model.surface.Pieces())
      << answers;
  }
}

// A server never sends some pieces, and drops each request that has one. It is not asked for them
// endlessly, although other pieces arrive.
TEST(TestViewFetching, WhatIsLostEachTimeIsNotAskedForWithoutEnd)
{
  MemoryServer server = Torus();
  ViewerSession session;
  OpenFullScreen(session, server);
  session.Zoom(6, onRingX, onRingY);
  std::map<BlobId, std::size_t> asked;
  std::size_t requests = 0, come = 0;
  for (int round = 0; round < 300; ++round)
  {
    if (session.IsIdle() && round < 200)
    {
      TurnALittle(session);
    }
    session.BeginFrame();
    for (const SessionRequest& request : session.TakeRequests())
    {
      ++requests;
      for (const BlobId& blob : request.blobs)
      {
        ++asked[blob];
        if (IsOfTree(blob) || blob.number % 4 != 1)
        {
          ++come;
          session.BlobArrived(request.id, blob, server.Blob(blob), 0.1, false);
        }
      }
      session.RequestFailed(request.id, "no");
    }
  }
  EXPECT_TRUE(session.IsIdle());
  EXPECT_GT(come, 20u);
  EXPECT_GT(requests, 10u);
  EXPECT_LT(requests, 200u);
  std::size_t most = 0;
  for (const auto& [blob, times] : asked)
  {
    most = std::max(most, times);
  }
  EXPECT_EQ(most, 2u);
  EXPECT_NE(session.GetStatus().error.find(" cannot be loaded: no"), std::string::npos);
}

// Messages about other failures stay, and blobs that arrived damaged are not requested again.
TEST(TestViewFetching, WhatWasNotLostStaysReported)
{
  MemoryServer server = Torus();
  ViewerSession session;
  OpenFullScreen(session, server);
  session.Zoom(6, onRingX, onRingY);
  LoseAll(session);
  TurnALittle(session);
  session.BeginFrame();
  std::optional<BlobId> damaged;
  std::string reported;
  for (const SessionRequest& request : session.TakeRequests())
  {
    for (const BlobId& blob : request.blobs)
    {
      if (!damaged)
      {
        damaged = blob;
        session.BlobFailed(request.id, blob, "it is damaged");
        reported = session.GetStatus().error;
      }
      else
      {
        session.BlobArrived(request.id, blob, server.Blob(blob), 0.1, false);
      }
    }
  }
  ASSERT_TRUE(damaged);
  ASSERT_NE(reported.find("it is damaged"), std::string::npos) << reported;
  server.sent.clear();
  server.Serve(session);
  EXPECT_EQ(session.GetStatus().error, reported);
  EXPECT_EQ(server.sent.count(*damaged), 0u);
}

TEST(TestViewFetching, ATapComesFirst)
{
  MemoryServer server = Torus();
  ViewerSession session;
  OpenFullScreen(session, server);
  double clock = 0;
  session.Zoom(5, onRingX, onRingY);
  session.BeginFrame();
  server.Take(session); // many blobs are wanted
  for (int i = 0; i < 4; ++i)
  {
    server.Answer(session);
  }
  session.BeginFrame();
  server.sent.clear();
  DoubleTap(session, 400, 300, clock);
  ASSERT_TRUE(session.GetStatus().picking || session.GetStatus().region);
  // First only pages and boxes of the tree around the tap are requested, then the way down to the
  // partition: a piece of each level that is not loaded yet. Earlier requests in flight are
  // cancelled.
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

  // The next region adds to it.
  const std::size_t originals = VerticesOfOriginal(session);
  DoubleTap(session, 430, 340, clock);
  server.Serve(session);
  ASSERT_TRUE(session.GetStatus().region);
  EXPECT_GE(VerticesOfOriginal(session), originals);
  DoubleTap(session, -1e6, -1e6, clock);
  EXPECT_FALSE(session.GetStatus().region);
}

TEST(TestViewFetching, WhatIsNotWantedAnyMoreIsCancelled)
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

// So that a new view is answered soon, little is in flight on a slow connection (here 0.25 s for
// each blob), however long the wish list is.
TEST(TestViewFetching, LittleIsInFlightOnASlowLine)
{
  for (const DetailMode detail : { DetailMode::View, DetailMode::Full })
  {
    SCOPED_TRACE(static_cast<int>(detail));
    MemoryServer server = Torus();
    ViewerSession session;
    OpenFullScreen(session, server); // the session now knows how slow the connection is
    server.sent.clear();
    session.SetDetail(detail);
    session.Zoom(30, onRingX, onRingY);
    std::size_t most = 0;
    server.Serve(session, nullptr,
      [&]
      {
        std::size_t inFlight = 0;
        for (const auto& blob : server.Outstanding())
        {
          inFlight += server.Blob(blob).size();
        }
        most = std::max(most, inFlight);
      });
    std::size_t largest = 0, all = 0;
    for (const BlobId& blob : server.sent)
    {
      largest = std::max(largest, server.Blob(blob).size());
      all += server.Blob(blob).size();
    }
    EXPECT_GT(most, 0u);
    EXPECT_LT(most, 16u * 1024 + largest);
    EXPECT_TRUE(detail == DetailMode::View || all > 10 * most) << all;
    EXPECT_TRUE(session.IsIdle());
  }
}

TEST(TestViewFetching, WhatFailsStaysCoarseAndIsNotAskedForAgain)
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
  session.Zoom(1.01, onRingX, onRingY); // requests again what has failed
  server.Serve(session);
  EXPECT_EQ(session.GetStatus().error, "");
}

TEST(TestViewFetching, CountsWhatWasWasted)
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
  session.BlobArrived(4711, piece, server.Blob(piece), 0, false); // nobody requested it
  EXPECT_EQ(session.GetTraffic().wasted, server.Blob(piece).size());
}

}
