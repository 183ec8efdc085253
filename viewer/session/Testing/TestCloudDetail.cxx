// SPDX-License-Identifier: BSD-3-Clause
// Clouds of points are refined as surfaces are: as fine as the screen can show them, in the view.
#include "viewer/session/SessionParts.h"
#include "viewer/session/Testing/SessionsByView.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

using namespace kdstream;
using namespace kdstream::testing;
using protocol::BlobId;
using protocol::BlobKind;

namespace
{

// 64,000 points.
const MemoryServer& Cloud()
{
  static const MemoryServer server = []
  {
    Mesh mesh = MakeTorus(400, 160);
    mesh.triangles.clear();
    return MemoryServer(mesh, 512, 2);
  }();
  return server;
}

std::size_t PartitionsSent(const MemoryServer& server)
{
  return static_cast<std::size_t>(std::count_if(server.sent.begin(), server.sent.end(),
    [](const BlobId& blob) { return blob.kind == BlobKind::Partition; }));
}

}

TEST(TestCloudDetail, IsFineWhereOneLooksAndTheRestCostsNothing)
{
  MemoryServer server = Cloud();
  ASSERT_EQ(server.Description().triangles, 0u);
  ViewerSession session;
  OpenSmall(session, server);
  EXPECT_EQ(PartitionsSent(server), 0u);
  session.Resize({ width, height, 1 });
  session.Zoom(20, onRingX, onRingY); // then the preview's points are too far apart
  server.Serve(session);
  EXPECT_TRUE(session.IsIdle());
  EXPECT_EQ(session.GetStatus().error, "");
  EXPECT_EQ(session.GetStatus().remainingError, 0);
  EXPECT_EQ(session.GetStatus().shownLevel, server.Codec().depths.finest);
  EXPECT_GT(PartitionsSent(server), 0u);
  EXPECT_LT(PartitionsSent(server), server.Description().partitions / 4);
  for (std::uint32_t i = 0; i < server.Description().partitions; ++i)
  {
    const NodeId node = NodeOfPartition(i, server.Codec().depths);
    const bool isShown =
      session.Parts().model.surface.Pieces().count({ Resolution::Original(), node }) > 0;
    EXPECT_EQ(isShown, session.GetCamera().MaySee(server.Tree()[node])) << node;
  }
  const std::size_t sent = server.sent.size();
  const std::uint64_t choices = session.Parts().lod.Choices();
  for (int i = 0; i < 10; ++i)
  {
    server.Serve(session);
  }
  EXPECT_EQ(server.sent.size(), sent);
  EXPECT_EQ(session.Parts().lod.Choices(), choices) << "a still camera comes to rest";
}

// In every view.
TEST(TestCloudDetail, PointsCountForTheBudget)
{
  constexpr std::size_t most = 12'000;
  MemoryServer server = Cloud();
  SessionOptions options;
  options.refinement.triangles = most;
  ViewerSession session(options);
  OpenFullScreen(session, server);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> part(0, 1);
  bool isBound = false;
  for (int step = 0; step < 20; ++step)
  {
    session.Zoom(0.5 + 2 * part(random), width * part(random), height * part(random));
    server.Serve(
      session, &random, [&] { ASSERT_LE(session.Scene().surface->PointCount(), 2 * most); });
    ASSERT_TRUE(session.IsIdle());
    EXPECT_LE(session.Scene().surface->PointCount(), most + most / 4);
    isBound = isBound || session.GetStatus().remainingError > 0;
  }
  EXPECT_TRUE(isBound);
}
