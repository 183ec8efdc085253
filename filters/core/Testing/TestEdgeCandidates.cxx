// SPDX-License-Identifier: BSD-3-Clause
// The parts of edge collapse: the queue of candidates, placing two edges at once, the triangles
// around a merged vertex.
#include "filters/core/TriangleDistance.h"
#include "filters/core/collapse/EdgeCandidates.h"
#include "filters/core/collapse/EdgePlacement.h"
#include "filters/core/collapse/MergedStar.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <set>

using namespace kdstream;

namespace
{

constexpr double infinity = std::numeric_limits<double>::infinity();

// Random numbers of many magnitudes, some of them equal, 0, huge, or not a number.
class HardNumbers
{
public:
  explicit HardNumbers(unsigned seed)
    : Random(seed)
  {
  }

  std::size_t Below(std::size_t end) { return this->Random() % end; }
  double Next()
  {
    const double digits = double(this->Below(2001)) / 1000 - 1;
    switch (this->Below(12))
    {
      case 0:
        return 0;
      case 1:
        return double(this->Below(3));
      case 2:
        return std::ldexp(digits, int(this->Below(600)) - 300);
      case 3:
        return this->Below(20) == 0 ? infinity : -0.0;
      default:
        return digits;
    }
  }
  Vec3 NextPoint()
  {
    const double x = this->Next(), y = this->Next(), z = this->Next();
    return { x, y, z };
  }

private:
  std::mt19937 Random;
};

bool SameBits(double a, double b)
{
  return BitCast<std::uint64_t>(a) == BitCast<std::uint64_t>(b) || (std::isnan(a) && std::isnan(b));
}

std::array<Lanes, 3> Both(const Vec3& p, const Vec3& q)
{
  return { Lanes(p[0], q[0]), Lanes(p[1], q[1]), Lanes(p[2], q[2]) };
}

void ExpectLane(
  const QuadraticForm<Lanes>& forms, std::size_t lane, const QuadraticForm<double>& form)
{
  for (std::size_t k = 0; k < 6; ++k)
  {
    ASSERT_TRUE(SameBits(forms.a[k][lane], form.a[k]));
  }
  for (std::size_t k = 0; k < 3; ++k)
  {
    ASSERT_TRUE(SameBits(forms.b[k][lane], form.b[k]));
  }
  ASSERT_TRUE(SameBits(forms.c[lane], form.c));
}

}

TEST(EdgeCandidates, LeaveInOrder)
{
  HardNumbers random(1);
  for (unsigned round = 0; round < 40; ++round)
  {
    EdgeCandidates queue;
    std::multiset<EdgeCandidate> expected;
    std::vector<std::uint32_t> stamps(20, 0); // older candidates of an edge are not current
    const auto isCurrent = [&](const EdgeCandidate& c) { return stamps[c.u] == c.stamp; };
    for (unsigned i = 0; i < 2000; ++i)
    {
      if (random.Below(5) > 1)
      {
        const auto u = static_cast<VertexId>(random.Below(20));
        const EdgeCandidate candidate{ std::abs(random.Next()), u,
          static_cast<VertexId>(u + 1 + random.Below(3)), stamps[u], random.Below(4) == 0 };
        if (queue.IsFull() || random.Below(100) == 0)
        {
          queue.MakeRoom(isCurrent);
        }
        queue.Push(candidate);
        expected.insert(candidate);
      }
      if (random.Below(30) == 0)
      {
        ++stamps[random.Below(20)];
      }
      if (random.Below(3) == 0)
      {
        std::erase_if(expected, [&](const EdgeCandidate& c) { return !isCurrent(c); });
        EdgeCandidate first{};
        ASSERT_EQ(queue.Pop(first, isCurrent), !expected.empty());
        if (!expected.empty())
        {
          const EdgeCandidate least = *expected.begin();
          ASSERT_FALSE(first < least || least < first) << first.cost << " for " << least.cost;
          const auto same = std::find_if(expected.begin(), expected.end(),
            [&](const EdgeCandidate& c) { return !(least < c) && c.measured == first.measured; });
          ASSERT_NE(same, expected.end());
          expected.erase(same);
        }
      }
    }
  }
}

TEST(EdgeCandidates, WhatIsOutOfDateTakesNoMemory)
{
  constexpr std::uint32_t edges = 3000, rounds = 200;
  EdgeCandidates queue;
  std::uint32_t stamp = 0; // of all edges
  const auto isCurrent = [&](const EdgeCandidate& c) { return c.stamp == stamp; };
  for (stamp = 0; stamp < rounds; ++stamp)
  {
    for (VertexId u = 0; u < edges; ++u)
    {
      if (queue.IsFull())
      {
        queue.MakeRoom(isCurrent);
      }
      queue.Push({ double(u % 7) * double(stamp + 1), u, u + 1, stamp, u % 2 == 0 });
    }
  }
  stamp = rounds - 1;
  EdgeCandidate first;
  for (std::uint32_t left = edges; left > 0; --left)
  {
    ASSERT_TRUE(queue.Pop(first, isCurrent));
  }
  EXPECT_FALSE(queue.Pop(first, isCurrent));
  std::uint32_t room = 0; // for how many candidates there is memory
  for (; !queue.IsFull() && room < 3 * edges; ++room)
  {
    queue.Push({ 1e30, room, room + 1, stamp, false }); // costs more than all popped ones
  }
  EXPECT_LT(room, 3 * edges);
}

TEST(EdgeCandidates, AreOrderedByCostThenByVertices)
{
  const std::array<EdgeCandidate, 5> ordered{ { { 1, 5, 6, 0, false }, { 2, 3, 8, 9, true },
    { 2, 4, 5, 3, false }, { 2, 4, 6, 1, false }, { 2, 4, 6, 2, false } } };
  for (std::size_t i = 0; i < ordered.size(); ++i)
  {
    for (std::size_t k = 0; k < ordered.size(); ++k)
    {
      EXPECT_EQ(ordered[i] < ordered[k], i < k);
    }
  }
}

TEST(EdgeCandidates, TwoEdgesAtOnceAreEachAsByThemselves)
{
  HardNumbers random(2);
  std::size_t beside = 0;
  for (unsigned i = 0; i < 50000; ++i)
  {
    std::array<EdgeToPlace<double>, 2> edges;
    std::array<Quadric, 2> quadrics;
    Box bounds;
    for (std::size_t e = 0; e < 2; ++e)
    {
      for (std::size_t planes = random.Below(5); planes-- > 0;)
      {
        quadrics[e].Add(
          Quadric::OfTriangle(random.NextPoint(), random.NextPoint(), random.NextPoint()));
      }
      edges[e] = { random.NextPoint(), random.NextPoint(), quadrics[e],
        random.Below(2) == 0 ? 1 : 0.25 };
      bounds.Add(edges[e].a);
      bounds.Add(edges[e].b);
    }
    const EdgeToPlace<Lanes> both{ Both(edges[0].a, edges[1].a), Both(edges[0].b, edges[1].b),
      SideBySide(quadrics[0], quadrics[1]), Lanes(edges[0].beside, edges[1].beside) };
    const PlacedVertex<Lanes> placed = PlaceVertex(both, bounds);
    for (std::size_t e = 0; e < 2; ++e)
    {
      const PlacedVertex<double> alone = PlaceVertex(edges[e], bounds);
      ASSERT_TRUE(SameBits(placed.cost[e], alone.cost));
      for (std::size_t k = 0; k < 3; ++k)
      {
        ASSERT_TRUE(SameBits(placed.position[k][e], alone.position[k]));
      }
      ASSERT_TRUE(SameBits(alone.cost, quadrics[e].At(alone.position)));
      ASSERT_FALSE(quadrics[e].At(edges[e].a) < alone.cost);
      ASSERT_FALSE(quadrics[e].At(edges[e].b) < alone.cost);
      const double away = SquaredToSegment(alone.position, edges[e].a, edges[e].b);
      for (std::size_t k = 0; k < 3 && away > 1e-6; ++k)
      {
        ASSERT_GE(alone.position[k], bounds.lo[k]);
        ASSERT_LE(alone.position[k], bounds.hi[k]);
      }
      beside += away > 1e-6;
    }
  }
  EXPECT_GT(beside, 1000U) << "too few places beside their edges";
}

TEST(EdgeCandidates, TwoPlanesAtOnceAreEachAsByThemselves)
{
  HardNumbers random(3);
  for (unsigned i = 0; i < 20000; ++i)
  {
    std::array<std::array<Vec3, 3>, 2> corners;
    for (auto& triangle : corners)
    {
      triangle = { random.NextPoint(), random.NextPoint(), random.NextPoint() };
      if (random.Below(10) == 0)
      {
        triangle[2] = triangle[random.Below(2)]; // without area
      }
    }
    const QuadraticForm<Lanes> both =
      QuadraticForm<Lanes>::OfTriangle(Both(corners[0][0], corners[1][0]),
        Both(corners[0][1], corners[1][1]), Both(corners[0][2], corners[1][2]));
    for (std::size_t lane = 0; lane < 2; ++lane)
    {
      const auto& [p, q, r] = corners[lane];
      ExpectLane(both, lane, QuadraticForm<double>::OfTriangle(p, q, r));
      Quadric added;
      added.Add(Quadric::OfTriangle(p, q, r));
      EXPECT_FALSE(std::isnan(added.Trace()));
    }
  }
}

// A merged vertex among random triangles: skipping triangles must not change the result.
TEST(EdgeCandidates, RetreatIsTheFarthestOfTheNearest)
{
  HardNumbers random(4);
  std::size_t far = 0, turned = 0;
  for (unsigned i = 0; i < 20000; ++i)
  {
    std::vector<Vec3> positions(12);
    const bool hard = i % 4 == 0;
    for (Vec3& p : positions)
    {
      p = hard ? random.NextPoint()
               : Vec3{ double(random.Below(9)), double(random.Below(9)), double(random.Below(2)) };
    }
    const auto end = static_cast<VertexId>(i % 2);
    std::vector<Triangle> triangles{ { end, 1 - end, 2 } };
    const auto other = [&] { return static_cast<VertexId>(2 + random.Below(10)); };
    for (std::size_t t = random.Below(12); t-- > 0;)
    {
      const auto own = static_cast<VertexId>(random.Below(2));
      const Triangle triangle{ own, random.Below(5) == 0 ? 1 - own : other(), other() };
      if (triangle[0] != triangle[1] && triangle[1] != triangle[2])
      {
        triangles.push_back(triangle);
      }
    }
    EdgeStar star;
    VertexStars(triangles, positions.size()).Gather(0, 1, star);
    const Vec3 position = hard ? random.NextPoint() : Vec3{ 4, 4, double(random.Below(2)) };
    MergedStar merged;
    merged.Set(positions, star, 0, 1, position);

    double farthest = 0, longest = 0;
    std::set<VertexId> from{ 0, 1 };
    std::vector<Triangle> remaining;
    bool turns = false;
    for (const Triangle& t : triangles)
    {
      if (std::count(t.begin(), t.end(), 0U) + std::count(t.begin(), t.end(), 1U) == 2)
      {
        from.insert(t.begin(), t.end());
        for (std::size_t k = 0; k < 3; ++k)
        {
          const Vec3 side = Minus(positions[t[k]], positions[t[(k + 1) % 3]]);
          longest = std::max(longest, Dot(side, side));
        }
        continue;
      }
      remaining.push_back(t);
      const auto normal = [&](const Vec3& p)
      { return Cross(Minus(positions[t[1]], p), Minus(positions[t[2]], p)); };
      const Vec3 before = normal(positions[t[0]]), after = normal(position);
      const double cosine = Dot(before, after);
      turns |=
        Dot(before, before) > 0 &&
        !(cosine > 0 && cosine * cosine > 0.2 * 0.2 * Dot(before, before) * Dot(after, after));
    }
    std::set<VertexId> facing{ 0, 1 };
    for (const EdgeStar::Facing& corner : star.facing)
    {
      facing.insert(corner.vertex);
    }
    ASSERT_EQ(facing, from);
    for (const VertexId v : from)
    {
      double nearest = longest;
      for (const Triangle& t : remaining)
      {
        nearest = std::min(
          nearest, SquaredToTriangle(positions[v], position, positions[t[1]], positions[t[2]]));
      }
      farthest = std::max(farthest, nearest);
    }
    ASSERT_EQ(merged.KeepsNormals(), !turns);
    turned += turns;
    const double enough = double(random.Below(20)), scale = 1.5;
    const double retreat = merged.SquaredRetreat(positions, star, 0, 1, scale, enough);
    ASSERT_EQ(scale * retreat > enough, scale * farthest > enough);
    if (scale * farthest > enough)
    {
      ASSERT_EQ(retreat, farthest);
      ++far;
    }
  }
  EXPECT_GT(far, 1000U);
  EXPECT_GT(turned, 1000U);
  EXPECT_LT(turned, 19000U);
}
