// SPDX-License-Identifier: BSD-3-Clause
// All chunks together have the triangles and points of the surface.
#include "Testing/Fixtures/Model.h"
#include "viewer/mobile/SurfaceChunks.h"
#include "viewer/mobile/Testing/GlesTools.h"
#include "viewer/session/Testing/MemoryServer.h"
#include "viewer/session/appearance/SceneRules.h"
#include "viewer/session/appearance/SplatRadii.h"
#include "viewer/session/appearance/VertexNormals.h"

#include <map>
#include <random>
#include <set>

namespace kdstream::test
{
namespace
{

std::vector<SurfaceChunk> AllChunks(const Surface& surface, const Coloring& coloring,
  const Vec3& center = { 0, 0, 0 }, double scale = 1.0)
{
  const std::vector<float> radii =
    surface.triangles.empty() ? SplatRadii(surface) : std::vector<float>();
  ChunkCutter cutter(surface, NormalsOf(surface), radii, depths, coloring, center, scale);
  std::vector<SurfaceChunk> chunks;
  for (SurfaceChunk chunk; cutter.Next(chunk);)
  {
    chunks.push_back(chunk);
  }
  return chunks;
}

using Corner = std::array<float, 3>;
using Corners = std::array<Corner, 3>;

// Rotates a triangle so that its lowest corner is first.
Corners Turned(Corners t)
{
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
}

std::multiset<Corners> TrianglesOf(const Surface& surface)
{
  std::multiset<Corners> triangles;
  for (const Triangle& t : surface.triangles)
  {
    Corners corners;
    for (std::size_t k = 0; k < 3; ++k)
    {
      for (std::size_t axis = 0; axis < 3; ++axis)
      {
        corners[k][axis] = static_cast<float>(surface.points[t[k]][axis]);
      }
    }
    triangles.insert(Turned(corners));
  }
  return triangles;
}

std::multiset<Corners> TrianglesOf(const std::vector<SurfaceChunk>& chunks)
{
  std::multiset<Corners> triangles;
  for (const SurfaceChunk& chunk : chunks)
  {
    for (std::size_t i = 0; i < chunk.indices.size(); i += 3)
    {
      Corners corners;
      for (std::size_t k = 0; k < 3; ++k)
      {
        corners[k] = chunk.vertices.at(chunk.indices[i + k]).position;
      }
      triangles.insert(Turned(corners));
    }
  }
  return triangles;
}

std::size_t VerticesOf(const std::vector<SurfaceChunk>& chunks)
{
  std::size_t count = 0;
  for (const SurfaceChunk& chunk : chunks)
  {
    EXPECT_LE(chunk.vertices.size(), SurfaceChunk::mostVertices);
    // The index 65,535 would start a new strip.
    EXPECT_EQ(std::count(chunk.indices.begin(), chunk.indices.end(), 65535), 0);
    count += chunk.vertices.size();
  }
  return count;
}

TEST(SurfaceChunks, HoldEveryTriangleOnce)
{
  for (const std::uint32_t rows : { 2, 60, 201 })
  {
    const Surface sphere = BumpySphere(rows);
    for (const auto coloring : { SurfaceColoring::Stone, SurfaceColoring::Partition })
    {
      const auto chunks = AllChunks(sphere, coloring);
      EXPECT_EQ(chunks.size(), sphere.points.size() > SurfaceChunk::mostVertices ? 2u : 1u);
      EXPECT_EQ(TrianglesOf(chunks), TrianglesOf(sphere)) << rows;
    }
  }
}

// A random order is the worst case: every chunk is full, and nothing is lost.
TEST(SurfaceChunks, TakeTrianglesInAnyOrder)
{
  Surface sphere = BumpySphere(201);
  std::mt19937 random(3);
  std::shuffle(sphere.triangles.begin(), sphere.triangles.end(), random);
  const auto chunks = AllChunks(sphere, SurfaceColoring::Resolution);
  EXPECT_GE(chunks.size(), 3u);
  static_assert(SurfaceChunk::mostVertices == 65535);
  EXPECT_EQ(TrianglesOf(chunks), TrianglesOf(sphere));
  VerticesOf(chunks);
  for (std::size_t i = 0; i + 1 < chunks.size(); ++i)
  {
    EXPECT_GT(chunks[i].vertices.size(), SurfaceChunk::mostVertices - 3);
  }
}

// The order in which sessions draw, piece by piece: 90,000 vertices in 64 partitions. Borders
// between chunks run along borders of pieces, so only 0.6 % of the vertices are repeated.
TEST(SurfaceChunks, RepeatFewVerticesOfADrawnSurface)
{
  const auto model = fixtures::MakeModel(kdstream::testing::MakeTorus(450, 200));
  Cut cut;
  cut.depths = model->tree.depths;
  cut.base = Resolution::Original();
  const auto surface = DrawSurface(cut, model->Lookup());
  ASSERT_TRUE(surface);
  ASSERT_EQ(surface->points.size(), std::size_t{ 90000 });
  for (const auto coloring : { SurfaceColoring::Stone, SurfaceColoring::Partition })
  {
    const auto chunks = AllChunks(*surface, coloring);
    EXPECT_EQ(chunks.size(), 2u);
    EXPECT_LE(VerticesOf(chunks), 90000 * 101 / 100);
  }
}

// Points without triangles are left out only if there are several chunks: a surface that fits into
// one chunk is not changed.
TEST(SurfaceChunks, LeaveOutVerticesWithoutTriangles)
{
  for (const std::uint32_t rows : { 10U, 201U })
  {
    Surface sphere = BumpySphere(rows);
    const std::size_t whole = VerticesOf(AllChunks(sphere, SurfaceColoring::Stone));
    for (int i = 0; i < 1000; ++i)
    {
      sphere.points.push_back({ 9, 9, 9 });
      sphere.sources.emplace_back();
    }
    const auto chunks = AllChunks(sphere, SurfaceColoring::Stone);
    EXPECT_EQ(VerticesOf(chunks), chunks.size() == 1 ? whole + 1000 : whole) << rows;
  }
}

TEST(SurfaceChunks, HoldEveryPointOfACloudOnce)
{
  Surface cloud = BumpySphere(201);
  cloud.triangles.clear();
  const auto chunks = AllChunks(cloud, SurfaceColoring::Resolution);
  ASSERT_EQ(chunks.size(), 2u);
  std::size_t at = 0;
  for (const SurfaceChunk& chunk : chunks)
  {
    EXPECT_TRUE(chunk.indices.empty());
    ASSERT_EQ(chunk.colors.size(), chunk.vertices.size());
    for (std::size_t i = 0; i < chunk.vertices.size(); ++i, ++at)
    {
      EXPECT_EQ(chunk.vertices[i].position[1], static_cast<float>(cloud.points[at][1]));
      const Color color = ResolutionColor(cloud.sources[at].resolution);
      EXPECT_EQ(
        chunk.colors[i], (std::array<std::uint8_t, 4>{ color[0], color[1], color[2], 255 }));
    }
  }
  EXPECT_EQ(at, cloud.points.size());
}

// Each corner has its own colour, in whatever triangle it is; so does each point of a cloud.
TEST(SurfaceChunks, HoldTheModelsOwnColors)
{
  for (const bool isCloud : { false, true })
  {
    Surface surface = BumpySphere(30);
    if (isCloud)
    {
      surface.triangles.clear();
    }
    Attribute colors{ { "RGBA", AttributeType::UInt8, AttributeAssociation::Point, 4 }, {} };
    std::map<Corner, std::array<std::uint8_t, 4>> byPosition;
    for (std::size_t i = 0; i < surface.points.size(); ++i)
    {
      const std::array<std::uint8_t, 4> color{ static_cast<std::uint8_t>(i % 251),
        static_cast<std::uint8_t>(i % 17), static_cast<std::uint8_t>(i / 7 % 256), 255 };
      colors.values.insert(colors.values.end(), { color[0], color[1], color[2], 3 });
      const Vec3& p = surface.points[i];
      byPosition[{ static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2]) }] =
        color;
    }
    surface.attributes = { colors };
    const auto chunks = AllChunks(surface, SurfaceColoring::Own);
    ASSERT_EQ(chunks.size(), 1u);
    ASSERT_EQ(chunks[0].colors.size(), chunks[0].vertices.size());
    for (std::size_t i = 0; i < chunks[0].vertices.size(); ++i)
    {
      EXPECT_EQ(chunks[0].colors[i], byPosition.at(chunks[0].vertices[i].position));
    }
    EXPECT_TRUE(AllChunks(surface, SurfaceColoring::Stone)[0].colors.empty());
    surface.attributes.clear();
    EXPECT_TRUE(AllChunks(surface, SurfaceColoring::Own)[0].colors.empty());
  }
}

TEST(SurfaceChunks, HoldTheScaledRadiiOfSplats)
{
  Surface cloud = BumpySphere(201);
  EXPECT_TRUE(AllChunks(cloud, SurfaceColoring::Own)[0].radii.empty());
  cloud.triangles.clear();
  const std::vector<float> radii = SplatRadii(cloud);
  std::size_t at = 0;
  for (const SurfaceChunk& chunk : AllChunks(cloud, SurfaceColoring::Own, {}, 0.25))
  {
    ASSERT_EQ(chunk.radii.size(), chunk.vertices.size());
    for (const float radius : chunk.radii)
    {
      EXPECT_EQ(radius, 0.25f * radii.at(at++));
    }
  }
  EXPECT_EQ(at, radii.size());
}

TEST(SurfaceChunks, HoldNothingOfNothing)
{
  EXPECT_TRUE(AllChunks(Surface{}, SurfaceColoring::Stone).empty());
}

// The rule of SceneRules.h, for triangles whose corners differ in all possible ways.
TEST(SurfaceChunks, PutTheColorOfATriangleIntoItsLastCorner)
{
  Surface sphere = BumpySphere(30);
  std::mt19937 random(5);
  for (Surface::Source& source : sphere.sources)
  {
    source.resolution = random() % 3 ? Resolution::Level(5 + random() % 4) : Resolution::Original();
    source.key = MakeKey(random() % 8, 0);
  }
  std::map<Corners, Triangle> byCorners;
  for (const Triangle& t : sphere.triangles)
  {
    Surface one = sphere;
    one.triangles = { t };
    byCorners[*TrianglesOf(one).begin()] = t;
  }
  for (const auto coloring : { SurfaceColoring::Partition, SurfaceColoring::Resolution })
  {
    for (const SurfaceChunk& chunk : AllChunks(sphere, coloring))
    {
      for (std::size_t i = 0; i < chunk.indices.size(); i += 3)
      {
        const auto cornerOf = [&](std::size_t k)
        { return chunk.vertices[chunk.indices[i + k]].position; };
        const Triangle& t = byCorners.at(Turned({ cornerOf(0), cornerOf(1), cornerOf(2) }));
        const auto sourceOf = [&](std::size_t k)
        { return ColorSourceOf(sphere.sources[t[k]], depths); };
        const Color color =
          ColorOf(Together(Together(sourceOf(0), sourceOf(1)), sourceOf(2)), coloring);
        EXPECT_EQ(chunk.colors[chunk.indices[i + 2]],
          (std::array<std::uint8_t, 4>{ color[0], color[1], color[2], 255 }));
      }
    }
  }
}

TEST(SurfaceChunks, AreRelativeToTheCenterAndScaled)
{
  const Surface sphere = BumpySphere(10, { 4e6, -4e6, 1e6 });
  const Surface atOrigin = BumpySphere(10);
  const auto chunks = AllChunks(sphere, SurfaceColoring::Stone, { 4e6, -4e6, 1e6 }, 0.25);
  Surface quarter = atOrigin;
  for (Vec3& p : quarter.points)
  {
    p = p * 0.25;
  }
  EXPECT_EQ(TrianglesOf(chunks), TrianglesOf(quarter));
}

TEST(SurfaceChunks, PackNormalsIntoTenBitsAnAxis)
{
  const Surface sphere = BumpySphere(40);
  const auto normals = ComputeVertexNormals(sphere.points, sphere.triangles);
  std::map<Corner, std::array<float, 3>> byPosition;
  for (std::size_t i = 0; i < normals.size(); ++i)
  {
    byPosition[{ static_cast<float>(sphere.points[i][0]), static_cast<float>(sphere.points[i][1]),
      static_cast<float>(sphere.points[i][2]) }] = normals[i];
  }
  const auto chunks = AllChunks(sphere, SurfaceColoring::Stone);
  for (const ChunkVertex& vertex : chunks.at(0).vertices)
  {
    for (unsigned k = 0; k < 3; ++k)
    {
      // Ten bits, signed.
      const auto bits = static_cast<int>(vertex.normal >> (10 * k) & 1023u);
      const double value = (bits < 512 ? bits : bits - 1024) / 511.0;
      EXPECT_NEAR(value, byPosition.at(vertex.position)[k], 0.51 / 511.0);
    }
  }
}

}
}
