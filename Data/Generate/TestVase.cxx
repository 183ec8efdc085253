// SPDX-License-Identifier: BSD-3-Clause
// Reads a written vase again.
#include "Data/Generate/ClosedGrid.h"
#include "Data/Generate/Vase.h"
#include "Testing/Fixtures/ReadMeshFile.h"
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/core/tree/KdTree.h"
#include "filters/meshio/MeshReader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>
#include <set>

namespace kdstream::generate
{
namespace
{

std::string BytesOf(std::uint64_t vertices, std::uint64_t seed)
{
  const std::string file = ::testing::TempDir() + "vase.ply";
  const auto grid = ClosedGrid::Of(vertices, vaseColumnsPerRing);
  EXPECT_TRUE(grid);
  EXPECT_TRUE(WritePly(*grid, MakeVase(seed), file));
  return fixtures::ReadWhole(file);
}

Mesh ReadVase(std::uint64_t vertices)
{
  BytesOf(vertices, 1);
  return fixtures::ReadMeshFile(::testing::TempDir() + "vase.ply");
}

TEST(Vase, IsClosedAndFacesOutwards)
{
  const Mesh vase = ReadVase(5000);
  EXPECT_NEAR(static_cast<double>(vase.points.size()), 5000, 100);
  std::map<std::pair<VertexId, VertexId>, int> edges;
  double volume = 0;
  for (const Triangle& t : vase.triangles)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      ++edges[{ t[k], t[(k + 1) % 3] }];
    }
    const Vec3 &a = vase.points[t[0]], &b = vase.points[t[1]], &c = vase.points[t[2]];
    volume += (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                a[2] * (b[0] * c[1] - b[1] * c[0])) /
              6;
  }
  for (const auto& [edge, count] : edges)
  {
    EXPECT_EQ(count, 1);
    EXPECT_EQ(edges.count({ edge.second, edge.first }), 1u);
  }
  // The volume of the vase's wall: less than a tenth of the cylinder around the vase.
  EXPECT_GT(volume, 0.02);
  EXPECT_LT(volume, 0.5);
}

TEST(Vase, IsPainted)
{
  const Mesh vase = ReadVase(100000);
  ASSERT_FALSE(vase.attributes.empty());
  EXPECT_EQ(RoleOf(vase.attributes[0]), AttributeRole::Colors);
  // Blue, red, green and gold each cover at least 0.5 % of the vase.
  std::map<std::string, std::size_t> counts;
  for (std::size_t i = 0; i < vase.points.size(); ++i)
  {
    const double r = vase.attributes[0].Get(i, 0), g = vase.attributes[0].Get(i, 1),
                 b = vase.attributes[0].Get(i, 2);
    ++counts[b > 2 * r              ? "blue"
             : r > 2.5 * g          ? "red"
             : g > 1.4 * r          ? "green"
             : r > 2 * b && g > 100 ? "gold"
                                    : "other"];
  }
  for (const char* color : { "blue", "red", "green", "gold" })
  {
    EXPECT_GT(counts[color], vase.points.size() / 200) << color;
  }
}

TEST(Vase, IsTheSameForTheSameSeed)
{
  EXPECT_EQ(BytesOf(3000, 7), BytesOf(3000, 7));
  EXPECT_NE(BytesOf(3000, 7), BytesOf(3000, 8));
}

TEST(Vase, HasAtLeastAFewVertices)
{
  for (const std::uint64_t vertices : { std::uint64_t{ 0 }, std::uint64_t{ 1 }, std::uint64_t{ 5 },
         std::uint64_t{ 1 } << 33, ~std::uint64_t{ 0 } })
  {
    const auto grid = ClosedGrid::Of(vertices, vaseColumnsPerRing);
    ASSERT_FALSE(grid) << vertices;
    EXPECT_EQ(grid.GetError().code, ErrorCode::InvalidArgument);
  }
  EXPECT_TRUE(ClosedGrid::Of(30, vaseColumnsPerRing));
}

TEST(Vase, SaysWhereItCannotBeWritten)
{
  EXPECT_FALSE(WritePly({ 3, 3 }, MakeVase(1), "/nonexistent/vase.ply"));
}

}
}
