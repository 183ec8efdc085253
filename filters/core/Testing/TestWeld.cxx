// SPDX-License-Identifier: BSD-3-Clause
// Finding, counting and welding coincident points.
#include "filters/core/BitCast.h"
#include "filters/core/SeededHash.h"
#include "filters/core/Weld.h"
#include "filters/program/TbbExecution.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <map>
#include <random>
#include <set>

namespace kdstream
{
namespace
{

// Several blocks of points. About half of them are in the place of another point; some have zeros
// of either sign.
std::vector<Vec3> AnyPoints(std::size_t count, unsigned seed)
{
  std::mt19937 generator(seed);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i)
  {
    const auto any = [&]()
    {
      const double x = double(generator() % 40) - 20;
      return x == 0 && generator() % 2 == 0 ? -0.0 : x / 7;
    };
    points.push_back({ any(), any(), any() });
  }
  return points;
}

// The lowest point in the same place, with places compared by value, as a map of doubles does.
std::vector<VertexId> FirstByMap(const std::vector<Vec3>& points)
{
  std::map<Vec3, VertexId> first;
  std::vector<VertexId> result;
  for (VertexId v = 0; v < points.size(); ++v)
  {
    result.push_back(first.emplace(points[v], v).first->second);
  }
  return result;
}

TEST(Weld, FindsTheFirstOfEachPlace)
{
  for (const std::size_t count : { 0, 1, 2, 100, 150000 })
  {
    const std::vector<Vec3> points = AnyPoints(count, 1);
    const std::vector<VertexId> expected = FirstByMap(points);
    std::size_t places = 0;
    for (VertexId v = 0; v < count; ++v)
    {
      places += expected[v] == v;
    }
    for (const unsigned threads : { 1U, 3U })
    {
      const Execution execution = MakeTbbExecution(threads);
      EXPECT_TRUE(FirstCoincident(points, Coincidence::ValueEqual, execution) == expected);
      EXPECT_EQ(CountPlaces(
                  count, [&](VertexId v) { return points[v]; }, execution),
        places);
    }
    EXPECT_TRUE(count < 1000 || places < count / 2);
  }
}

// Different places that had equal hashes in an older version, whose hash could be inverted:
// computes z for any x and y.
std::vector<Vec3> PreparedPoints(std::size_t count)
{
  constexpr std::uint64_t factor = 0xFF51AFD7ED558CCDU, wanted = 12345;
  std::uint64_t inverse = factor; // of the factor, modulo 2^64: each round doubles the correct bits
  for (int i = 0; i < 6; ++i)
  {
    inverse *= 2 - factor * inverse;
  }
  const auto mixed = [](std::uint64_t hash, double x)
  {
    hash = (hash ^ BitCast<std::uint64_t>(x)) * factor;
    return hash ^ (hash >> 32);
  };
  std::mt19937_64 generator(4);
  std::vector<Vec3> points;
  while (points.size() < count)
  {
    const double x = double(generator() % 1000), y = double(generator() % 1000) / 8;
    const std::uint64_t before = mixed(mixed(0x9E3779B97F4A7C15U, x), y);
    const double z = BitCast<double>(((wanted ^ (wanted >> 32)) * inverse) ^ before);
    if (std::isfinite(z))
    {
      EXPECT_EQ(mixed(before, z), wanted);
      points.push_back({ x, y, z });
    }
  }
  return points;
}

// Counts comparisons instead of time: places are requested twice for hashing, and two more times
// whenever two of the same hash are compared.
TEST(Weld, PlacesThatSomebodyPreparedAreNotComparedWithEachOther)
{
  constexpr std::size_t count = 3000;
  const std::vector<Vec3> points = PreparedPoints(count);
  const std::size_t different = std::set<Vec3>(points.begin(), points.end()).size();
  std::atomic<std::size_t> asked{ 0 };
  EXPECT_EQ(CountPlaces(count,
              [&](VertexId v)
              {
                ++asked;
                return points[v];
              }),
    different);
  EXPECT_LE(asked, 4 * count);
}

TEST(Weld, EverySeedGivesOtherHashes)
{
  const std::vector<Vec3> points = PreparedPoints(100);
  std::set<std::uint64_t> hashes;
  for (const std::uint64_t seed : { RandomSeed(), RandomSeed(), agreedSeed })
  {
    for (const Vec3& p : std::set<Vec3>(points.begin(), points.end()))
    {
      EXPECT_TRUE(hashes.insert(HashOfPlace(p, seed)).second);
    }
  }
}

TEST(Weld, TellsZerosApartByTheirBits)
{
  const std::vector<Vec3> points{ { 0.0, 1, 1 }, { -0.0, 1, 1 }, { 0.0, 1, 1 }, { -0.0, 1, 1 } };
  EXPECT_EQ(FirstCoincident(points, Coincidence::BitEqual), (std::vector<VertexId>{ 0, 1, 0, 1 }));
  EXPECT_EQ(
    FirstCoincident(points, Coincidence::ValueEqual), (std::vector<VertexId>{ 0, 0, 0, 0 }));
}

TEST(Weld, JoinsToTheLowest)
{
  Mesh mesh;
  mesh.points = AnyPoints(100000, 2);
  std::mt19937 generator(3);
  for (int i = 0; i < 200000; ++i)
  {
    const auto any = [&]() { return static_cast<VertexId>(generator() % 100000); };
    mesh.triangles.push_back({ any(), any(), any() });
  }
  const Mesh before = mesh;
  const std::vector<VertexId> first = FirstCoincident(before.points, Coincidence::BitEqual);
  const std::size_t gone = WeldVertices(mesh, MakeTbbExecution(3));
  ASSERT_EQ(mesh.points.size() + gone, before.points.size());
  VertexId kept = 0;
  for (VertexId v = 0; v < first.size(); ++v)
  {
    if (first[v] == v)
    {
      ASSERT_EQ(mesh.points[kept++], before.points[v]);
    }
  }
  ASSERT_EQ(kept, mesh.points.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      ASSERT_EQ(mesh.points[mesh.triangles[t][k]], before.points[before.triangles[t][k]]);
    }
  }
  EXPECT_EQ(WeldVertices(mesh), 0U);
}

}
}
