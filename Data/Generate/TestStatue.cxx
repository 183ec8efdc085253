// SPDX-License-Identifier: BSD-3-Clause
// The statue is closed, its photographs cover all of it, and it is the same each time.
#include "Data/Generate/Statue.h"
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/program/TbbExecution.h"
#include "filters/texture/BakeTextures.h"
#include "filters/texture/FindTextures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <vector>

using namespace kdstream;
using namespace kdstream::generate;

namespace
{

const StatueOptions small{ 3000, 128, 1 };

}

TEST(Statue, IsTheSameForAnyThreadsAndAnotherForAnotherSeed)
{
  const fixtures::TemporaryFolder folder;
  for (const char* const name : { "a", "b", "c" })
  {
    std::filesystem::create_directory(folder / name);
  }
  ASSERT_TRUE(WriteStatue(small, folder / "a" / "s.obj"));
  ASSERT_TRUE(WriteStatue(small, folder / "b" / "s.obj", MakeTbbExecution(2)));
  ASSERT_TRUE(WriteStatue({ 3000, 128, 2 }, folder / "c" / "s.obj"));
  for (const char* const name : { "s.obj", "s-0.jpg", "s-1.png", "s-2.jpg", "s-3.png" })
  {
    const std::string bytes = fixtures::ReadWhole(folder / "a" / name);
    EXPECT_FALSE(bytes.empty()) << name;
    EXPECT_EQ(bytes, fixtures::ReadWhole(folder / "b" / name)) << name;
    EXPECT_NE(bytes, fixtures::ReadWhole(folder / "c" / name)) << name;
  }
  EXPECT_EQ(
    fixtures::ReadWhole(folder / "a" / "s.mtl"), fixtures::ReadWhole(folder / "b" / "s.mtl"));
}

TEST(Statue, IsClosedAndTexturedWhereItIsPhotographed)
{
  const fixtures::TemporaryFolder folder;
  const std::filesystem::path file = folder / "s.obj";
  // Enough texels to show the bands; finer detail is not tested.
  ASSERT_TRUE(WriteStatue({ 20000, 512, 1 }, file));
  ASSERT_TRUE(FindTextures(file));
  EXPECT_TRUE(FindTextures(file)->any);
  Result<TexturedFile> read = ReadTextured(file);
  ASSERT_TRUE(read) << read.GetError().message;
  EXPECT_TRUE(read->warnings.empty());
  Mesh& mesh = read->textured.mesh;
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
    ASSERT_EQ((edges.count({ edge.second, edge.first })), 1U);
  }
  double volume = 0;
  for (const Triangle& t : mesh.triangles)
  {
    const Vec3 &a = mesh.points[t[0]], &b = mesh.points[t[1]], &c = mesh.points[t[2]];
    volume += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
              a[2] * (b[0] * c[1] - b[1] * c[0]);
  }
  EXPECT_GT(volume / 6, 0.3) << "it faces outwards";
  const Result<BakeReport> report = BakeTextures(read->textured);
  ASSERT_TRUE(report);
  EXPECT_TRUE(report->warnings.empty());
  EXPECT_EQ(report->pictures, 4U);
  EXPECT_GT(report->texelsPerVertex, 20);
  EXPECT_GT(report->loss, 3);
  // Compares the stone's own colour at the vertices with the colour in the photographs.
  const std::uint64_t rings = static_cast<std::uint64_t>(std::llround(std::sqrt(20000 / 1.2)));
  const std::uint64_t columns = (mesh.points.size() - 2) / rings;
  const ColoredSurface surface = MakeStatue(1);
  double off = 0, elsewhere = 0;
  const Attribute& colors = mesh.attributes.back();
  for (std::uint64_t v = 1; v + 1 < mesh.points.size(); ++v)
  {
    const double along = double((v - 1) / columns + 1) / double(rings + 1);
    const double around = double((v - 1) % columns) / double(columns);
    const ColoredPoint here = surface(along, around), there = surface(along + 0.05, around);
    off += std::abs(colors.Get(v, 1) - here.color[1]);
    elsewhere += std::abs(colors.Get(v, 1) - there.color[1]);
  }
  EXPECT_LT(off, elsewhere / 2);
}

// However the surface is cut, its vertices have nearly the same colours.
TEST(Statue, OtherChartsShowTheSame)
{
  const fixtures::TemporaryFolder folder;
  std::vector<double> expected;
  for (const StatueCharts charts : { StatueCharts::Few, StatueCharts::Small, StatueCharts::Udim })
  {
    const std::filesystem::path file = folder / "s.obj";
    ASSERT_TRUE(WriteStatue({ 20000, 1024, 1, charts }, file));
    Result<TexturedFile> read = ReadTextured(file);
    ASSERT_TRUE(read) << read.GetError().message;
    double most = 0;
    for (const auto& corners : read->textured.corners)
    {
      most = std::max(most, double(corners[0][0]));
    }
    EXPECT_EQ(most > 3, charts == StatueCharts::Udim);
    const Result<BakeReport> report = BakeTextures(read->textured);
    ASSERT_TRUE(report);
    EXPECT_TRUE(report->warnings.empty());
    EXPECT_EQ(report->pictures, 4U);
    const Attribute& colors = read->textured.mesh.attributes.back();
    std::vector<double> found;
    for (std::size_t v = 0; v < read->textured.mesh.points.size(); ++v)
    {
      found.push_back(colors.Get(v, 1));
    }
    expected = expected.empty() ? found : expected;
    ASSERT_EQ(found.size(), expected.size());
    double off = 0;
    for (std::size_t v = 0; v < found.size(); ++v)
    {
      off += std::abs(found[v] - expected[v]) / double(found.size());
    }
    EXPECT_LT(off, 6);
  }
}

TEST(Statue, FewVerticesAreRefused)
{
  const fixtures::TemporaryFolder folder;
  EXPECT_FALSE(WriteStatue({ 10, 64, 1 }, folder / "s.obj"));
  EXPECT_TRUE(WriteStatue({ 40, 64, 1 }, folder / "s.obj"));
  EXPECT_FALSE(WriteStatue({ 1000, 512, 1, StatueCharts::Small }, folder / "s.obj"));
  EXPECT_FALSE(WriteStatue({ 9000, 64, 1, StatueCharts::Small }, folder / "s.obj"));
}
