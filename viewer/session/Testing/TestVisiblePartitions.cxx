// SPDX-License-Identifier: BSD-3-Clause
// Which parts of a torus may be visible according to coarse levels, compared with all triangles of
// the finer pieces.
#include "viewer/session/Testing/MemoryServer.h"
#include "viewer/session/model/VisiblePartitions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

using namespace kdstream;
using kdstream::testing::MakeTorus;
using kdstream::testing::MemoryServer;

namespace
{

// P = 9, S = 13, L = 15: 64,000 vertices.
MemoryServer& Torus()
{
  static MemoryServer server(MakeTorus(400, 160), 128, 2);
  return server;
}

Piece PieceOf(PieceId id)
{
  MemoryServer& server = Torus();
  return *DecodePiece(server.Blob(BlobOfPiece(id, server.Codec().depths)), id, server.Codec());
}

NodeId FirstNode(Resolution resolution)
{
  return NodeId{ 1 } << PieceDepth(resolution, Torus().Codec().depths);
}

VisiblePartitions AllLevels()
{
  const TreeDepths& depths = Torus().Codec().depths;
  VisiblePartitions seen(depths);
  for (unsigned d = 0; d <= depths.finest; ++d)
  {
    const NodeId first = FirstNode(Resolution::Level(d));
    for (NodeId node = first; node < 2 * first; ++node)
    {
      seen.Add(PieceOf({ Resolution::Level(d), node }));
    }
  }
  return seen;
}

// Whether any triangle with an own vertex has its middle on the screen, and, if `closed`, faces the
// camera.
bool IsSeen(const Piece& piece, const Camera& camera, bool closed)
{
  const Vec3 eye = camera.Eye();
  return std::any_of(piece.triangles.begin(), piece.triangles.end(),
    [&](const Triangle& t)
    {
      const Vec3 &a = piece.positions[t[0]], &b = piece.positions[t[1]], &c = piece.positions[t[2]];
      const Vec3 middle = (a + b + c) * (1.0 / 3);
      Box point;
      point.Add(middle);
      const bool faces = Dot(eye - middle, Cross(b - a, c - a)) > 0;
      return camera.MaySee(point) && (faces || !closed);
    });
}

std::vector<Camera> Cameras()
{
  std::mt19937 random(7);
  const auto chance = [&random](double most)
  { return most * static_cast<double>(random()) / static_cast<double>(std::mt19937::max()); };
  std::vector<Camera> cameras;
  for (const double zoom : { 0.7, 1.0, 3.0, 8.0, 20.0 })
  {
    for (int i = 0; i < 4; ++i)
    {
      Camera camera;
      camera.SetViewport({ 800, 600, 1 });
      camera.FitTo(Torus().Description().box);
      camera.Rotate(400, 300, chance(800), chance(600));
      camera.Zoom(zoom, 150 + chance(500), 200 + chance(200));
      cameras.push_back(camera);
    }
  }
  return cameras;
}

TEST(TestVisiblePartitions, NothingThatIsSeenIsLeftOutAndMuchElseIs)
{
  const TreeDepths& depths = Torus().Codec().depths;
  VisiblePartitions seen = AllLevels();
  for (const bool closed : { true, false })
  {
    std::size_t shown = 0, reported = 0, all = 0, wrong = 0;
    for (const Camera& camera : Cameras())
    {
      seen.Cull(camera, closed);
      for (unsigned d = PreviewLevel(depths) + 1; d <= depths.finest + 1; ++d)
      {
        const bool original = d > depths.finest;
        if (d > depths.stitch && !original)
        {
          continue;
        }
        const Resolution resolution = original ? Resolution::Original() : Resolution::Level(d);
        const NodeId first = FirstNode(resolution);
        for (NodeId node = first; node < 2 * first; ++node)
        {
          const PieceId id{ resolution, node };
          const bool is = IsSeen(PieceOf(id), camera, closed);
          const bool may = original ? seen.MayBeVisible(node) : seen.MayBeVisible(id);
          shown += is;
          reported += may;
          wrong += is && !may;
          ++all;
        }
      }
    }
    EXPECT_EQ(wrong, 0u) << closed;
    EXPECT_GT(shown, 1000u);
    EXPECT_LT(reported, all * (closed ? 45u : 60u) / 100) << shown << " of " << all;
  }
}

TEST(TestVisiblePartitions, OfWhatIsNotLoadedAllMayBeVisible)
{
  VisiblePartitions nothing(Torus().Codec().depths);
  nothing.Cull(Cameras().front(), true);
  EXPECT_TRUE(nothing.MayBeVisible(NodeId{ 1 }));
  EXPECT_TRUE(nothing.MayBeVisible(FirstNode(Resolution::Original())));
}

TEST(TestVisiblePartitions, KnowsWhatIsClosed)
{
  Piece preview = PieceOf({ Resolution::Level(11), 1 });
  EXPECT_TRUE(VisiblePartitions::IsNearlyClosed(preview));
  preview.triangles.resize(preview.triangles.size() - preview.triangles.size() / 20);
  EXPECT_FALSE(VisiblePartitions::IsNearlyClosed(preview));
  EXPECT_FALSE(VisiblePartitions::IsNearlyClosed({})); // a cloud
}

}
