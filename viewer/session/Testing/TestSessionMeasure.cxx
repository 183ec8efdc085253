// SPDX-License-Identifier: BSD-3-Clause
// Distances between two taps: measured on the original when it has arrived; until then with a known
// error.
#include "viewer/session/Picker.h"
#include "viewer/session/Testing/SessionsByLevel.h"

#include <algorithm>
#include <random>

using namespace kdstream;
using namespace kdstream::testing;
using protocol::BlobKind;

namespace
{

const DrawnSurface& OriginalTorus()
{
  static const DrawnSurface surface = []
  {
    const Mesh mesh = MakeTorus(200, 80);
    Surface whole;
    whole.points = mesh.points;
    whole.triangles = mesh.triangles;
    whole.sources.resize(mesh.points.size());
    return DrawnSurface(std::move(whole));
  }();
  return surface;
}

Ray RayThrough(const ViewerSession& session, double x, double y)
{
  const ViewerScene scene = session.Scene();
  const double unit = 2 * Camera::tangentOfHalfAngle / height;
  const Vec3 sight{ (x - width * 0.5) * unit, (height * 0.5 - y) * unit, -1 };
  return { scene.eye, Normalized(scene.orientation.Rotate(sight)) };
}

void SlowTap(Fingers& fingers, ViewerSession& session, double x, double y)
{
  fingers.now += 1;
  fingers.Tap(session, x, y);
}

std::unique_ptr<ViewerSession> Measuring(MemoryServer& server, SessionOptions options = {})
{
  auto session = std::make_unique<ViewerSession>(options);
  Open(*session);
  server.Serve(*session);
  session->EnterFullScreen();
  server.Serve(*session);
  session->SetTool(Tool::Measure);
  return session;
}

std::size_t PartitionsSent(const MemoryServer& server)
{
  return static_cast<std::size_t>(std::count_if(server.sent.begin(), server.sent.end(),
    [](const auto& blob) { return blob.kind == BlobKind::Partition; }));
}

TEST(TestSessionMeasure, EndsLieOnTheOriginalOnceItHasCome)
{
  Fingers fingers;
  const double step = SmallTorus().Description().grid.step;
  for (unsigned seed = 0; seed < 24; ++seed)
  {
    SCOPED_TRACE("seed " + std::to_string(seed));
    MemoryServer server = SmallTorus();
    SessionOptions options;
    options.detail = seed % 2 == 0 ? DetailMode::View : DetailMode::Level;
    const auto session = Measuring(server, options);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(0, 1);
    std::vector<SurfaceHit> meant;
    while (meant.size() < 2)
    {
      const double x = any(random) * width, y = any(random) * height;
      const Ray ray = RayThrough(*session, x, y);
      const auto hit = PickSurface(OriginalTorus(), ray);
      const auto shown = PickSurface(*session->Scene().surface, ray);
      if (hit && shown && std::abs(hit->distance - shown->distance) < 0.01) // not at a silhouette
      {
        meant.push_back(*hit);
        SlowTap(fingers, *session, x, y);
        while (server.Take(*session), !session->IsIdle() && any(random) < 0.9)
        {
          (void)server.Answer(*session, &random);
          session->BeginFrame();
        }
      }
    }
    for (int i = 0; server.Take(*session), !session->IsIdle(); ++i)
    {
      ASSERT_LT(i, 1000);
      const Measurement& now = session->Measurements().front();
      for (const MeasuredPoint* end : { &now.from, &*now.to })
      {
        const Vec3 near = NearestOnSurface(OriginalTorus(), end->point)->point;
        EXPECT_LE(Length(near - end->point), end->error) << end->resolution.IsOriginal();
      }
      (void)server.Answer(*session, &random);
      session->BeginFrame();
    }
    ASSERT_EQ(session->Measurements().size(), 1u);
    const Measurement& done = session->Measurements().front();
    ASSERT_TRUE(done.to);
    EXPECT_TRUE(done.IsExact());
    EXPECT_FALSE(done.from.waits || done.to->waits);
    EXPECT_LT(done.Error(), 4 * step);
    EXPECT_NEAR(done.Distance(), Length(meant[1].point - meant[0].point), 40 * step);
  }
}

TEST(TestSessionMeasure, FetchesLittle)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  const auto session = Measuring(server, ByLevel());
  server.sent.clear();
  const auto [x, y] = OnModel(*session);
  SlowTap(fingers, *session, x, y);
  EXPECT_TRUE(session->Measurements().front().from.waits);
  EXPECT_FALSE(session->Measurements().front().IsExact());
  EXPECT_EQ(session->Measurements().front().Distance(), 0);
  server.Serve(*session);
  EXPECT_FALSE(session->Measurements().front().from.waits);
  EXPECT_TRUE(session->Measurements().front().from.resolution.IsOriginal());
  EXPECT_GE(PartitionsSent(server), 1u);
  EXPECT_LE(PartitionsSent(server), 6u);
}

TEST(TestSessionMeasure, WhatMayNotBeHadStaysOnTheLevel)
{
  Fingers fingers;
  for (const bool isRefused : { true, false })
  {
    MemoryServer server = SmallTorus();
    for (std::uint32_t i = 0; isRefused && i < 1u << server.Codec().depths.partition; ++i)
    {
      server.refused.insert(protocol::BlobId::Partition(i));
    }
    ViewerSession session;
    Open(session);
    if (!isRefused) // refused to this user by the server
    {
      for (const SessionRequest& request : session.TakeRequests())
      {
        session.Opened(request.id, WithDetail(server.Description(), ModelDetail::Levels));
      }
    }
    server.Serve(session);
    session.EnterFullScreen();
    server.Serve(session);
    session.SetTool(Tool::Measure);
    const auto [x, y] = OnModel(session);
    SlowTap(fingers, session, x, y);
    server.Serve(session);
    EXPECT_TRUE(session.IsIdle());
    ASSERT_EQ(session.Measurements().size(), 1u);
    const MeasuredPoint& end = session.Measurements().front().from;
    EXPECT_FALSE(end.waits);
    EXPECT_FALSE(end.resolution.IsOriginal());
    EXPECT_GT(end.error, 0);
    EXPECT_EQ(PartitionsSent(server), 0u);
  }
}

TEST(TestSessionMeasure, TapsPlaceOneEndAfterTheOther)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  const auto session = Measuring(server);
  const auto [x, y] = OnModel(*session);
  fingers.DoubleTap(*session, x, y); // a quick one
  ASSERT_EQ(session->Measurements().size(), 1u);
  EXPECT_TRUE(session->Measurements().front().to);
  EXPECT_FALSE(session->GetStatus().region) << "no region is asked for meanwhile";
  SlowTap(fingers, *session, 3, 3); // beside the model
  EXPECT_EQ(session->Measurements().size(), 1u);
  SlowTap(fingers, *session, x, y);
  EXPECT_EQ(session->Measurements().size(), 2u);
  EXPECT_EQ(session->Measurements().back().name, "2");
  session->SetTool(Tool::None);
  EXPECT_EQ(session->Measurements().size(), 1u) << "half of one is dropped";
  session->NameMeasurement(0, "nose");
  EXPECT_EQ(session->Measurements().front().name, "nose");
  SlowTap(fingers, *session, x, y);
  EXPECT_EQ(session->Measurements().size(), 1u);
  session->SetTool(Tool::Measure);
  for (int i = 0; i < 200; ++i)
  {
    SlowTap(fingers, *session, x + i % 7, y);
  }
  EXPECT_EQ(session->Measurements().size(), 64u);
  session->RemoveMeasurement(0);
  session->RemoveMeasurement(70);
  EXPECT_EQ(session->Measurements().size(), 63u);
  server.Serve(*session);
  for (const Measurement& each : session->Measurements())
  {
    EXPECT_TRUE(each.IsExact());
  }
  ASSERT_TRUE(session->SelectModel("other"));
  EXPECT_TRUE(session->Measurements().empty());
}

TEST(TestSessionMeasure, ALinkNamesThem)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  const auto mine = Measuring(server);
  const auto [x, y] = OnModel(*mine);
  for (int i = 0; i < 4; ++i)
  {
    SlowTap(fingers, *mine, x + 5 * i, y - 4 * i);
    server.Serve(*mine);
  }
  ASSERT_EQ(mine->Measurements().size(), 2u);
  const std::string text = FormatViewLink(mine->Link());
  EXPECT_LT(text.size(), 200u) << text;
  ViewerSession theirs(ByLevel());
  theirs.Resize({ width, height, 1 });
  ASSERT_TRUE(theirs.Follow(*ParseViewLink(text)));
  server.Serve(theirs);
  ASSERT_EQ(theirs.Measurements().size(), 2u);
  for (std::size_t i = 0; i < 2; ++i)
  {
    const Measurement &a = mine->Measurements()[i], &b = theirs.Measurements()[i];
    EXPECT_TRUE(b.IsExact());
    EXPECT_NEAR(a.Distance(), b.Distance(), 1e-8);
    EXPECT_LT(Length(a.from.point - b.from.point), 1e-8);
  }
}

TEST(TestSessionMeasure, HeightsAreAlongUp)
{
  Measurement m{ "a", { { 1, 2, 3 }, Resolution::Original(), 0.5, false }, {} };
  EXPECT_EQ(m.Height({ 0, 0, 1 }), 0);
  EXPECT_FALSE(m.IsExact());
  m.to = MeasuredPoint{ { 4, 6, 1 }, Resolution::Level(7), 0.25, true };
  EXPECT_DOUBLE_EQ(m.Distance(), std::sqrt(29.0));
  EXPECT_DOUBLE_EQ(m.Height({ 0, 0, 1 }), -2);
  EXPECT_DOUBLE_EQ(m.Horizontal({ 0, 0, 1 }), 5);
  EXPECT_DOUBLE_EQ(m.Error(), 0.75);
  EXPECT_FALSE(m.IsExact());
  m.to->resolution = Resolution::Original();
  EXPECT_TRUE(m.IsExact());
}

}
