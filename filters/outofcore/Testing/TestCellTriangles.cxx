// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/Meshes.h"
#include "filters/core/TriangleBuckets.h"
#include "filters/core/tree/KdTree.h"
#include "filters/outofcore/Testing/SpillTools.h"
#include "filters/outofcore/mesh/CellTriangles.h"
#include "filters/program/TbbExecution.h"

#include <algorithm>
#include <random>

using namespace kdstream;
using namespace kdstream::fixtures;
using namespace kdstream::testing;

namespace
{

std::vector<NumberedTriangle> Numbered(const std::vector<Triangle>& triangles)
{
  std::vector<NumberedTriangle> numbered;
  for (const Triangle& t : triangles)
  {
    numbered.push_back({ t, static_cast<std::uint32_t>(numbered.size()) });
  }
  return numbered;
}

std::vector<PointRecord<double>> InOrder(const Mesh& mesh, const KdTree& tree)
{
  std::vector<PointRecord<double>> records;
  for (const VertexId v : tree.order)
  {
    records.push_back({ mesh.points[v], v });
  }
  return records;
}

}

TEST(BucketFile, KeepsOrderInEachBucket)
{
  std::mt19937 random(3);
  for (const std::uint64_t memory : { 0, 100, 1 << 20 })
  {
    SpillFolder folder = MakeSpillFolder();
    auto buckets = RecordBuckets<std::uint64_t>::Create(folder, "test", 7, 1000, memory);
    ASSERT_TRUE(buckets);
    std::vector<std::vector<std::uint64_t>> expected(7);
    for (int i = 0; i < 1000; ++i)
    {
      const std::size_t bucket = random() % 6; // the last bucket stays empty
      const std::uint64_t value = random();
      expected[bucket].push_back(value);
      ASSERT_TRUE(buckets->Add(bucket, value));
    }
    ASSERT_TRUE(buckets->Finish());
    for (std::size_t b = 0; b < 7; ++b)
    {
      std::vector<std::uint64_t> read;
      ASSERT_TRUE(buckets->ForEach(b,
        [&](std::uint64_t value) -> Status
        {
          read.push_back(value);
          return {};
        }));
      EXPECT_EQ(read, expected[b]);
      EXPECT_EQ(buckets->Size(b), expected[b].size());
    }
  }
}

TEST(BucketFile, TheVisitorsErrorComesBack)
{
  SpillFolder folder = MakeSpillFolder();
  auto buckets = RecordBuckets<std::uint32_t>::Create(folder, "test", 1, 10, 0);
  for (std::uint32_t i = 0; i < 10; ++i)
  {
    ASSERT_TRUE(buckets->Add(0, i));
  }
  ASSERT_TRUE(buckets->Finish());
  std::uint32_t last = 0;
  const Status status = buckets->ForEach(0,
    [&](std::uint32_t i) -> Status
    {
      last = i;
      return i < 4 ? Status{} : Status(Error{ ErrorCode::Cancelled, "enough" });
    });
  ASSERT_FALSE(status);
  EXPECT_EQ(status.GetError().message, "enough");
  EXPECT_EQ(last, 4U);
}

TEST(VertexMap, ReplacesCornersWhateverTheMemory)
{
  std::mt19937 random(11);
  for (const std::uint32_t count : { 1, 2, 50, 777 })
  {
    std::vector<VertexId> entries(count);
    for (VertexId& entry : entries)
    {
      entry = static_cast<VertexId>(random());
    }
    std::vector<NumberedTriangle> triangles, expected;
    for (std::uint32_t i = 0; i < 3000; ++i)
    {
      NumberedTriangle t{ { static_cast<VertexId>(random() % count),
                            static_cast<VertexId>(random() % count),
                            static_cast<VertexId>(random() % count) },
        i };
      triangles.push_back(t);
      for (VertexId& corner : t.corners)
      {
        corner = entries[corner];
      }
      expected.push_back(t);
    }
    for (const std::uint64_t memory : { 1, 64, 1000, 1 << 20 })
    {
      SpillFolder folder = MakeSpillFolder();
      const SpillFile file = Spilled(folder, triangles);
      const VertexMap map{ Spilled(folder, entries), count };
      std::vector<NumberedTriangle> mapped;
      ASSERT_TRUE(MapTriangles(folder, file, triangles.size(), map, memory, MakeTbbExecution(3),
        [&](std::span<const NumberedTriangle> block) -> Status
        {
          mapped.insert(mapped.end(), block.begin(), block.end());
          return {};
        }));
      std::sort(mapped.begin(), mapped.end(),
        [](const NumberedTriangle& a, const NumberedTriangle& b) { return a.number < b.number; });
      EXPECT_EQ(mapped, expected) << count << " entries, memory " << memory;
    }
  }
}

TEST(VertexMap, CancelledAtEachReport)
{
  const std::vector<NumberedTriangle> triangles(5000);
  for (const std::uint64_t memory : { 8, 1 << 20 })
  {
    bool done = false;
    for (int most = 0; !done; ++most)
    {
      SpillFolder folder = MakeSpillFolder();
      const SpillFile file = Spilled(folder, triangles);
      const VertexMap map{ Spilled(folder, std::vector<VertexId>(9)), 9 };
      Execution execution;
      int reports = 0;
      execution.progress = [&](std::string_view, double) { return reports++ < most; };
      const Status status = MapTriangles(folder, file, triangles.size(), map, memory, execution,
        [](std::span<const NumberedTriangle>) { return Status{}; });
      done = static_cast<bool>(status);
      EXPECT_EQ(done, reports <= most);
      if (!status)
      {
        EXPECT_EQ(status.GetError().code, ErrorCode::Cancelled);
      }
    }
  }
}

TEST(CellTriangles, AsInMemory)
{
  for (const NamedMesh& named : AllMeshes())
  {
    const Mesh& mesh = named.mesh;
    KdTreeOptions options;
    options.verticesPerPartition = 50;
    const KdTree tree = std::move(*BuildKdTree(mesh.points, options));
    for (const unsigned depth : { 0U, tree.depths.partition, tree.depths.finest })
    {
      const std::vector<std::uint32_t> cell = CellOfVertex(tree, depth);
      const TriangleBuckets expected = BucketTriangles(
        mesh.triangles, std::size_t{ 1 } << depth, [&](VertexId v) { return cell[v]; });
      for (const std::uint64_t memory : { 2000, 1 << 22 })
      {
        SCOPED_TRACE(named.name + ", depth " + std::to_string(depth));
        SpillFolder folder = MakeSpillFolder();
        const SpillFile records = Spilled(folder, InOrder(mesh, tree));
        const auto count = static_cast<std::uint32_t>(mesh.points.size());
        Result<VertexMap> ranks = RankVertices<double>(folder, records, count, memory);
        ASSERT_TRUE(ranks);
        const SpillFile triangles = Spilled(folder, Numbered(mesh.triangles));
        const auto cells = SortTrianglesIntoCells(folder, triangles, mesh.triangles.size(), *ranks,
          CellOfRank(ranks->count, depth), memory);
        ASSERT_TRUE(cells);
        for (std::size_t c = 0; c < cells->BucketCount(); ++c)
        {
          std::vector<std::uint32_t> numbers;
          ASSERT_TRUE(cells->ForEach(c,
            [&](const NumberedTriangle& t) -> Status
            {
              for (std::size_t k = 0; k < 3; ++k)
              {
                EXPECT_EQ(tree.order[t.corners[k]], mesh.triangles[t.number][k]);
              }
              numbers.push_back(t.number);
              return {};
            }));
          std::sort(numbers.begin(), numbers.end());
          const auto of = expected.Of(c);
          ASSERT_EQ(numbers, std::vector<std::uint32_t>(of.begin(), of.end()));
        }
      }
    }
  }
}

TEST(CellTriangles, CellOfEveryRank)
{
  for (const std::uint32_t vertices : { 1, 2, 3, 100, 1023, 1025, 99999 })
  {
    for (unsigned depth = 0; depth < 12; ++depth)
    {
      const CellOfRank cellOf(vertices, depth);
      for (std::uint64_t cell = 0; cell < (std::uint64_t{ 1 } << depth); ++cell)
      {
        const CellRange range = RangeOfCell(vertices, depth, cell);
        for (std::uint64_t rank = range.begin; rank < range.begin + range.size; ++rank)
        {
          ASSERT_EQ(cellOf(static_cast<VertexId>(rank)), cell);
        }
      }
    }
  }
}
