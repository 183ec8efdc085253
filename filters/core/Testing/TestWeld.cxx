// Coincident points: found, counted and welded.
#include "filters/core/Weld.h"
#include "filters/program/TbbExecution.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

namespace kdstream
{
namespace
{

// Several blocks of points, about half of them where another is; some of them at zeros of both
// signs.
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

// By value: as a map of doubles compares them.
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
