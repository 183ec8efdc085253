// SPDX-License-Identifier: BSD-3-Clause
// Reads a written relief again; also tests the grid and the permutation that it is made with.
#include "Data/Generate/Hash.h"
#include "Data/Generate/Relief.h"
#include "Testing/Fixtures/Invariants.h"
#include "Testing/Fixtures/ReadMeshFile.h"
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/core/Weld.h"
#include "filters/meshio/MeshReader.h"
#include "filters/program/TbbExecution.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace kdstream::generate
{
namespace
{

CubeGrid GridOf(std::uint64_t points)
{
  const auto grid = CubeGrid::Of(points);
  EXPECT_TRUE(grid);
  return *grid;
}

std::filesystem::path Write(
  std::uint64_t points, const ReliefOptions& options, const Execution& execution = {})
{
  const std::filesystem::path file = ::testing::TempDir() + "relief.ply";
  EXPECT_TRUE(WriteRelief(GridOf(points), options, file, execution));
  return file;
}

std::string BytesOf(
  std::uint64_t points, const ReliefOptions& options, const Execution& execution = {})
{
  return fixtures::ReadWhole(Write(points, options, execution));
}

Mesh Read(std::uint64_t points, const ReliefOptions& options)
{
  return fixtures::ReadMeshFile(Write(points, options));
}

// Every edge occurs once in each direction: the mesh is closed, consistently oriented, and manifold
// along edges.
void ExpectClosed(const Mesh& mesh)
{
  std::map<std::pair<VertexId, VertexId>, int> edges;
  for (const Triangle& t : mesh.triangles)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      ++edges[{ t[k], t[(k + 1) % 3] }];
    }
  }
  for (const auto& [edge, count] : edges)
  {
    ASSERT_EQ(count, 1);
    ASSERT_EQ(edges.count({ edge.second, edge.first }), 1u);
  }
}

using Corners = std::array<Vec3, 3>;
std::vector<Corners> SortedTriangles(const Mesh& mesh)
{
  std::vector<Corners> corners;
  for (const Triangle& t : mesh.triangles)
  {
    corners.push_back({ mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]] });
  }
  std::sort(corners.begin(), corners.end());
  return corners;
}

TEST(CubeGrid, NumbersEveryPointOnce)
{
  for (const std::uint64_t side : { 1, 2, 3, 7 })
  {
    const CubeGrid grid{ side };
    std::uint64_t onSurface = 0;
    for (std::uint64_t i = 0; i < (side + 1) * (side + 1) * (side + 1); ++i)
    {
      const CubeGrid::Place place{ i % (side + 1), i / (side + 1) % (side + 1),
        i / (side + 1) / (side + 1) };
      const bool on =
        std::any_of(place.begin(), place.end(), [&](auto x) { return x == 0 || x == side; });
      onSurface += on;
      if (on)
      {
        ASSERT_LT(grid.PointAt(place), grid.Points());
        ASSERT_EQ(grid.PlaceOf(grid.PointAt(place)), place) << side;
      }
    }
    ASSERT_EQ(onSurface, grid.Points());
  }
}

TEST(CubeGrid, IsAsLargeAsWanted)
{
  EXPECT_EQ(GridOf(14030000).Points(), 14027048u);
  EXPECT_EQ(GridOf(14030000).Triangles(), 28054092u);
  EXPECT_GE(GridOf(150000000).Points(), 150000000u);
  EXPECT_GE(GridOf(150000000).Triangles(), 300000000u);
  EXPECT_EQ(GridOf(8).Points(), 8u);
  EXPECT_LE(GridOf(std::uint64_t{ 1 } << 32).Points(), std::uint64_t{ 1 } << 32);
  for (const std::uint64_t points :
    { std::uint64_t{ 0 }, std::uint64_t{ 7 }, std::uint64_t{ 1 } << 33, ~std::uint64_t{ 0 } })
  {
    const auto grid = CubeGrid::Of(points);
    ASSERT_FALSE(grid) << points;
    EXPECT_EQ(grid.GetError().code, ErrorCode::InvalidArgument);
  }
}

// Nothing may overflow when ids come near 2^32. The corners of triangles at the ends of every side
// are on that side, and next to each other.
TEST(CubeGrid, HoldsAtItsLargest)
{
  const CubeGrid grid = GridOf(std::uint64_t{ 1 } << 32);
  const std::uint64_t perSide = grid.Triangles() / 6;
  for (std::uint64_t face = 0; face < 6; ++face)
  {
    for (const std::uint64_t triangle :
      { face * perSide, face * perSide + perSide / 2, (face + 1) * perSide - 1 })
    {
      for (const std::uint64_t corner : grid.CornersOf(triangle))
      {
        ASSERT_LT(corner, grid.Points());
        EXPECT_EQ(grid.PlaceOf(corner)[face / 2], face % 2 == 0 ? 0 : grid.side);
      }
    }
  }
}

TEST(Permutation, IsOneAndItsInverse)
{
  for (const std::uint64_t count : { 1, 2, 3, 5, 64, 65, 1000, 4097 })
  {
    for (const std::uint64_t seed : { 0, 1, 99 })
    {
      const Permutation permutation(count, seed);
      std::vector<int> hits(count, 0);
      for (std::uint64_t i = 0; i < count; ++i)
      {
        ASSERT_LT(permutation(i), count);
        ++hits[permutation(i)];
        ASSERT_EQ(permutation.Inverse(permutation(i)), i);
      }
      ASSERT_EQ(std::count(hits.begin(), hits.end(), 1), static_cast<std::ptrdiff_t>(count));
    }
  }
}

// Neighbouring inputs have distant outputs, and an output says nothing about the next one.
TEST(Permutation, Scatters)
{
  constexpr std::uint64_t count = 300000000, samples = 10000;
  const Permutation permutation(count, 1);
  double distance = 0;
  std::uint64_t rising = 0;
  for (std::uint64_t i = 0; i < samples; ++i)
  {
    const auto a = static_cast<double>(permutation(i)), b = static_cast<double>(permutation(i + 1));
    distance += std::abs(a - b);
    rising += a < b;
  }
  EXPECT_NEAR(distance / samples / static_cast<double>(count), 1.0 / 3.0, 0.01);
  EXPECT_NEAR(static_cast<double>(rising) / samples, 0.5, 0.02);
}

TEST(Relief, IsClosedAndFacesOutwards)
{
  for (const std::uint64_t points : { 8, 26, 5000 })
  {
    for (const bool shuffled : { false, true })
    {
      const Mesh mesh = Read(points, { 1, shuffled, shuffled });
      ASSERT_EQ(mesh.triangles.size(), 2 * (mesh.points.size() - 2));
      ExpectClosed(mesh);
      EXPECT_GT(fixtures::VolumeOf(mesh), points < 10 ? 1.0 : 2.5);
    }
  }
}

TEST(Relief, HasNoCoincidentPoints)
{
  Mesh mesh = Read(100000, {});
  EXPECT_EQ(WeldVertices(mesh), 0u);
}

// The relief at a given size: how much points differ, on average, from the mean of the points
// `step` squares away along a row, divided by the distance. A smooth ball has almost none at small
// steps.
TEST(Relief, IsRoughAtEveryScale)
{
  const CubeGrid grid = GridOf(600000);
  const Relief relief(grid, ReliefOptions());
  const auto radius = [&](std::uint64_t column, std::uint64_t row)
  {
    const Vec3 p = relief.At(grid.PointAt({ column, row, 0 }));
    return std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
  };
  for (const std::uint64_t step : { 1, 2, 4, 8, 16, 32, 64 })
  {
    double sum = 0;
    int count = 0;
    for (std::uint64_t row = 3; row < grid.side; row += 7)
    {
      for (std::uint64_t column = step; column + step <= grid.side; column += step)
      {
        sum += std::abs(
          radius(column, row) - radius(column - step, row) / 2 - radius(column + step, row) / 2);
        ++count;
      }
    }
    const double length = static_cast<double>(step) * 1.5 / static_cast<double>(grid.side);
    EXPECT_GT(sum / count / length, 0.012) << step;
    EXPECT_LT(sum / count / length, 0.5) << step;
  }
}

// The grid with twice as many squares along a side contains all points of the other one.
TEST(Relief, IsTheSameShapeForTheSameDetail)
{
  const std::uint64_t few = 6 * 16 * 16 + 2, many = 6 * 32 * 32 + 2;
  const auto shared = [](const Mesh& coarse, const Mesh& fine)
  {
    std::size_t count = 0;
    const std::set<Vec3> places(fine.points.begin(), fine.points.end());
    for (const Vec3& point : coarse.points)
    {
      count += places.count(point);
    }
    return count;
  };
  ReliefOptions options;
  options.detail = 100000;
  EXPECT_EQ(shared(Read(few, options), Read(many, options)), few);
  options.detail = 0;
  EXPECT_LT(shared(Read(few, options), Read(many, options)), few / 10);
}

TEST(Relief, ShuffledIsTheSameSetOfTriangles)
{
  const Mesh plain = Read(3000, {}), triangles = Read(3000, { 1, true, false }),
             both = Read(3000, { 1, true, true });
  EXPECT_EQ(plain.points, triangles.points);
  EXPECT_NE(plain.triangles, triangles.triangles);
  EXPECT_NE(plain.points, both.points);
  EXPECT_EQ(SortedTriangles(plain), SortedTriangles(triangles));
  EXPECT_EQ(SortedTriangles(plain), SortedTriangles(both));
}

TEST(Relief, IsTheSameForTheSameSeed)
{
  // EXPECT_EQ would take minutes to show how the files differ.
  EXPECT_TRUE(BytesOf(3000, { 7 }) == BytesOf(3000, { 7 }));
  EXPECT_FALSE(BytesOf(3000, { 7 }) == BytesOf(3000, { 8 }));
  EXPECT_NE(Read(3000, { 7, true }).triangles, Read(3000, { 8, true }).triangles);
}

// More triangles than a block holds, so that threads have something to divide.
TEST(Relief, DoesNotDependOnThreads)
{
  EXPECT_TRUE(BytesOf(700000, { 3, true }) == BytesOf(700000, { 3, true }, MakeTbbExecution(4)));
}

TEST(Relief, LeavesNothingWhenCancelled)
{
  const std::filesystem::path folder = ::testing::TempDir() + "relief-cancelled";
  std::filesystem::create_directories(folder);
  Execution execution;
  execution.progress = [](std::string_view step, double) { return step == "vertices"; };
  const Status status = WriteRelief(GridOf(1000), {}, folder / "relief.ply", execution);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.GetError().code, ErrorCode::Cancelled);
  EXPECT_TRUE(std::filesystem::is_empty(folder));
}

TEST(Relief, SaysWhereItCannotBeWritten)
{
  EXPECT_FALSE(WriteRelief(GridOf(100), {}, "/nonexistent/relief.ply"));
}

}
}
