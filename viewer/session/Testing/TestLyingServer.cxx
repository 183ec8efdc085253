// SPDX-License-Identifier: BSD-3-Clause
// A server sends wrong facts, with correct checksums, about where pieces are, or about the
// ancestors of their vertices. Nothing is refined endlessly, and the surface outside a wrong piece
// stays whole.
#include "viewer/session/SessionParts.h"
#include "viewer/session/Testing/SessionsByLevel.h"

#include "filters/codec/PartitionBoxes.h"
#include "filters/core/tree/PieceDepth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <random>
#include <utility>
#include <vector>

using namespace kdstream;
using namespace kdstream::testing;
using protocol::BlobId;

namespace
{

constexpr std::size_t mostAnswers = 20'000; // more than any session needs that ends

// Random boxes within their parents' boxes, because a page cannot express others.
std::vector<Box> LiesOfBoxes(const std::vector<Box>& boxes, std::mt19937& random)
{
  std::uniform_real_distribution<double> part(0, 1);
  std::vector<Box> lies = boxes;
  for (std::size_t node = 2; node < lies.size(); ++node)
  {
    const Box& parent = lies[node / 2];
    if (boxes[node].Empty())
    {
      continue;
    }
    Box lie = parent;
    const auto generator = random() % 4;
    for (unsigned axis = 0; axis < 3; ++axis)
    {
      const double length = parent.hi[axis] - parent.lo[axis];
      const double a = parent.lo[axis] + part(random) * length,
                   b = parent.lo[axis] + part(random) * length;
      if (generator < 2)
      {
        lie.lo[axis] = std::min(a, b);
        lie.hi[axis] = generator == 0 ? lie.lo[axis] : std::max(a, b); // a point, or a random part
      }
    }
    lies[node] = lie;
  }
  return lies;
}

void TellOfBoxes(MemoryServer& server, const std::vector<Box>& boxes, bool exactToo)
{
  const TreeDepths& depths = server.Codec().depths;
  for (const NodeId page : TreePages(depths))
  {
    server.Blob(BlobId::TreePage(page)) =
      EncodeTreePage(RoundTreePage(boxes, page, depths, server.Table()));
  }
  if (exactToo)
  {
    for (const NodeId node : AllPartitionBoxes(depths))
    {
      server.Blob(BlobId::PartitionBoxes(node)) = EncodePartitionBoxes(boxes, node, depths);
    }
  }
}

TEST(TestLyingServer, BoxesThatLieMakeNothingEndless)
{
  Fingers fingers;
  for (const unsigned seed : { 1u, 2u, 3u, 4u, 5u, 6u })
  {
    std::mt19937 random(seed);
    MemoryServer server = SmallTorus();
    TellOfBoxes(server, LiesOfBoxes(server.Tree(), random), seed % 2 == 0);
    SessionOptions options;
    options.TakeShares(SharesOfBudgets(12'000, std::size_t{ 1 } << 30));
    ViewerSession session(options);
    OpenFullScreen(session, server);
    std::size_t answers = 0;
    for (int step = 0; step < 6; ++step)
    {
      session.Zoom(step % 3 == 2 ? 0.4 : 2.5, 100 + 40 * step, 300);
      if (step % 2 == 1)
      {
        fingers.DoubleTap(session, onRingX, onRingY);
      }
      server.Serve(session, nullptr,
        [&]
        {
          ExpectClosed(session);
          ASSERT_LT(++answers, mostAnswers);
        });
      EXPECT_TRUE(session.IsIdle());
      EXPECT_GT(session.GetStatus().triangles, 1'000u);
      EXPECT_LT(session.GetStatus().triangles, 20'000u);
    }
  }
}

// Permutes the ancestors of a piece's vertices: the result is a valid tree of clusters, but another
// one. False if the vertices have no ancestors.
bool LieOfAncestors(MemoryServer& server, PieceId id, std::mt19937& random)
{
  const CodecContext& codec = server.Codec();
  std::vector<std::uint8_t>& blob = server.Blob(BlobOfPiece(id, codec.depths));
  auto piece = DecodePiece(blob, id, codec);
  EXPECT_TRUE(piece);
  std::vector<std::uint32_t> vertices; // those that have ancestors
  for (std::uint32_t v = 0; v < piece->VertexCount(); ++v)
  {
    if (!piece->AncestorsOf(v, codec.depths).empty())
    {
      vertices.push_back(v);
    }
  }
  if (vertices.size() < 2)
  {
    return false;
  }
  for (int swaps = 0; swaps < 300; ++swaps)
  {
    const auto row = [&](std::uint32_t v)
    {
      const auto ancestors = piece->AncestorsOf(v, codec.depths);
      return std::pair{ piece->ancestors.begin() + (ancestors.data() - piece->ancestors.data()),
        static_cast<std::ptrdiff_t>(ancestors.size()) };
    };
    const auto [a, levels] = row(vertices[random() % vertices.size()]);
    const auto [b, alike] = row(vertices[random() % vertices.size()]);
    EXPECT_EQ(levels, alike);
    if (a != b)
    {
      std::swap_ranges(a, a + levels, b);
    }
  }
  blob = EncodePiece(*piece, codec);
  return true;
}

// The ends of edges that only one triangle uses.
std::vector<Vec3> EndsOfHoles(const Surface& surface)
{
  std::map<std::array<std::uint32_t, 2>, int> uses;
  for (const Triangle& t : surface.triangles)
  {
    for (unsigned i = 0; i < 3; ++i)
    {
      const auto a = static_cast<std::uint32_t>(t[i]),
                 b = static_cast<std::uint32_t>(t[(i + 1) % 3]);
      ++uses[{ std::min(a, b), std::max(a, b) }];
    }
  }
  std::vector<Vec3> ends;
  for (const auto& [edge, count] : uses)
  {
    if (count == 1)
    {
      ends.push_back(surface.points[edge[0]]);
      ends.push_back(surface.points[edge[1]]);
    }
  }
  return ends;
}

double LongestEdge(const Surface& surface)
{
  double longest = 0;
  for (const Triangle& t : surface.triangles)
  {
    for (unsigned i = 0; i < 3; ++i)
    {
      longest = std::max(longest, Length(surface.points[t[i]] - surface.points[t[(i + 1) % 3]]));
    }
  }
  return longest;
}

// A box that contains a piece's vertices, and all vertices that share an edge with one of them.
Box Around(const MemoryServer& server, PieceId piece, double longestEdge)
{
  Box around = server.Tree()[piece.node];
  for (unsigned axis = 0; axis < 3; ++axis)
  {
    around.lo[axis] -= longestEdge;
    around.hi[axis] += longestEdge;
  }
  return around;
}

bool IsSmall(const Box& box)
{
  const Box all = SmallCells().Description().box;
  return Length(box.hi - box.lo) < Length(all.hi - all.lo) / 3;
}

void OpenNear(ViewerSession& session, MemoryServer& server)
{
  session.Resize({ width, height, 1 });
  ASSERT_TRUE(session.SelectModel("torus"));
  server.Serve(session); // the preview
  session.EnterFullScreen();
  session.Zoom(3, onRingX, onRingY);
}

// The surface outside the neighbourhood of a wrong piece stays whole. Checked only for small
// pieces: a piece of the coarsest levels is half of the model.
TEST(TestLyingServer, AncestorsThatLieSpoilNoMoreThanTheirPiece)
{
  std::size_t few = 0, holes = 0;
  MemoryServer honest = SmallCells();
  ViewerSession before;
  OpenNear(before, honest);
  honest.Serve(before);
  ASSERT_EQ(EndsOfHoles(before.Scene().surface->Whole()).size(), 0u);
  const double longest = LongestEdge(before.Scene().surface->Whole());
  std::vector<PieceId> shown(
    before.Parts().model.surface.Pieces().begin(), before.Parts().model.surface.Pieces().end());
  std::mt19937 random(15);
  std::shuffle(shown.begin() + 2, shown.end(), random); // keeps the first two, of level S
  shown.resize(12);
  for (const PieceId piece : shown)
  {
    MemoryServer server = SmallCells();
    ASSERT_TRUE(LieOfAncestors(server, piece, random));
    ViewerSession session;
    OpenNear(session, server);
    const Box around = Around(server, piece, longest);
    few += IsSmall(around) ? 1 : 0;
    std::size_t answers = 0;
    server.Serve(session, &random,
      [&]
      {
        ASSERT_LT(++answers, mostAnswers);
        for (const Vec3& end : EndsOfHoles(session.Scene().surface->Whole()))
        {
          ASSERT_TRUE(!IsSmall(around) || DistanceTo(around, end) == 0) << "node " << piece.node;
          ++holes;
        }
      });
    EXPECT_TRUE(session.IsIdle());
    EXPECT_GT(session.GetStatus().triangles, before.GetStatus().triangles / 2);
    EXPECT_LT(session.GetStatus().triangles, before.GetStatus().triangles * 3 / 2);
  }
  EXPECT_GE(few, 8u);
  EXPECT_GT(holes, 0u) << "lies that change nothing tell nothing";
}

}
