// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/HardPoints.h"
#include "filters/baselines/stores/Baselines.h"
#include "filters/outofcore/Testing/SpillTools.h"
#include "filters/outofcore/files/RecordFile.h"
#include "filters/outofcore/tree/ExternalTree.h"
#include "filters/program/TbbExecution.h"

#include <gtest/gtest.h>

#include <cmath>
#include <csignal>
#include <filesystem>

#include <sys/resource.h>

using namespace kdstream;
using kdstream::testing::MakeSpillFolder;
using namespace kdstream::fixtures;
namespace fs = std::filesystem;

namespace
{

const char* const allMethods[] = { "histogram", "heaps", "torben", "sort" };

template <class Scalar>
std::vector<PointRecord<Scalar>> RecordsOf(const std::vector<Vec3>& points)
{
  std::vector<PointRecord<Scalar>> records(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      records[i].p[k] = static_cast<Scalar>(points[i][k]);
    }
    records[i].id = static_cast<VertexId>(i);
  }
  return records;
}

template <class Scalar>
SpillFile FileOf(SpillFolder& folder, const std::vector<Vec3>& points)
{
  SpillFile file =
    std::move(*folder.CreateFile("points", points.size() * sizeof(PointRecord<Scalar>)));
  const auto records = RecordsOf<Scalar>(points);
  EXPECT_TRUE(
    WriteRecords<PointRecord<Scalar>>(file, 0, std::span<const PointRecord<Scalar>>(records)));
  return file;
}

template <class Scalar>
std::vector<PointRecord<Scalar>> ReadAll(const SpillFile& file)
{
  std::vector<PointRecord<Scalar>> records(file.Size() / sizeof(PointRecord<Scalar>));
  EXPECT_TRUE(ReadRecords<PointRecord<Scalar>>(file, 0, std::span<PointRecord<Scalar>>(records)));
  return records;
}

// The least memory in bytes that building a tree accepts.
std::uint64_t LeastMemory(std::size_t vertices, const TreeDepths& depths, std::size_t recordBytes)
{
  const std::uint64_t cell = ((vertices - 1) >> depths.finest) + 1;
  return (std::uint64_t{ 2 } << depths.partition) * sizeof(Box) +
         std::max<std::uint64_t>(64, cell) * recordBytes;
}

// Builds out of core and compares with the tree in memory, bit for bit.
template <class Scalar>
void Compare(SpillFolder& folder, const std::vector<Vec3>& points, const KdTree& tree,
  const ExternalTreeOptions& options, const Execution& execution)
{
  SpillFile file = FileOf<Scalar>(folder, points);
  const auto external = BuildExternalTree<Scalar>(folder, file, tree.depths, options, execution);
  ASSERT_TRUE(external) << external.GetError().message;
  const auto records = ReadAll<Scalar>(external->records);
  ASSERT_EQ(records.size(), points.size());
  for (std::size_t i = 0; i < records.size(); ++i)
  {
    ASSERT_EQ(records[i].id, tree.order[i]) << "position " << i;
    for (std::size_t k = 0; k < 3; ++k)
    {
      const double expected = points[records[i].id][k];
      ASSERT_EQ(double(records[i].p[k]), expected);
      ASSERT_EQ(std::signbit(records[i].p[k]), std::signbit(expected));
    }
  }
  EXPECT_EQ(external->boxes, tree.boxes);
  if (options.keepPoints)
  {
    const auto kept = ReadAll<Scalar>(file);
    ASSERT_EQ(kept.size(), points.size());
    for (std::size_t i = 0; i < kept.size(); ++i)
    {
      ASSERT_EQ(kept[i].id, i);
    }
  }
  else
  {
    EXPECT_EQ(file.Size(), 0U);
  }
}

}

TEST(ExternalTree, IsTheTreeInMemoryForEveryMethodAndLimit)
{
  SpillFolder folder = MakeSpillFolder();
  for (const HardPoints& hard : AllHardPoints({ 65, 100, 2049 }))
  {
    const auto tree = BuildKdTree(hard.points, { 30, {}, 8 });
    ASSERT_TRUE(tree);
    const std::uint64_t least = LeastMemory(hard.points.size(), tree->depths, 32);
    for (const char* name : allMethods)
    {
      for (const std::uint64_t memory : { least, least + 5000, least + 40000 })
      {
        SCOPED_TRACE(hard.name + ", " + std::to_string(hard.points.size()) + ", memory " +
                     std::to_string(memory) + ", " + name);
        const MedianMethod method = MedianMethodOfName(name);
        Compare<double>(folder, hard.points, *tree, { memory, method, 0, memory % 2 == 0 }, {});
        if (hard.fitFloats)
        {
          Compare<float>(folder, hard.points, *tree, { memory, method, 0, false }, {});
        }
        if (::testing::Test::HasFatalFailure())
        {
          return;
        }
      }
    }
  }
}

TEST(ExternalTree, SmallMeshesOfEveryNumberOfVertices)
{
  SpillFolder folder = MakeSpillFolder();
  for (std::size_t n = 1; n <= 100; ++n)
  {
    const std::vector<HardPoints> kinds = AllHardPoints({ n });
    for (std::size_t kind = n % 4; kind < kinds.size(); kind += 4)
    {
      const HardPoints& hard = kinds[kind];
      SCOPED_TRACE(hard.name + ", " + std::to_string(n));
      const auto tree = BuildKdTree(hard.points, { 3, {}, 2 });
      ASSERT_TRUE(tree);
      Compare<double>(folder, hard.points, *tree,
        { LeastMemory(n, tree->depths, 32), FindMedianByHistogram, 0, n % 2 == 0 }, {});
    }
  }
}

TEST(ExternalTree, IsTheSameOnAnyNumberOfThreads)
{
  SpillFolder folder = MakeSpillFolder();
  // Large enough for several blocks in several slots.
  for (const HardPoints& hard : AllHardPoints({ 150000 }))
  {
    SCOPED_TRACE(hard.name);
    const auto tree = BuildKdTree(hard.points, { 2000, {}, 8 });
    ASSERT_TRUE(tree);
    for (const unsigned threads : { 1U, 2U, 5U })
    {
      const MedianMethod method = threads == 1 ? FindMedianByHeaps : FindMedianByHistogram;
      Compare<double>(
        folder, hard.points, *tree, { 2 << 20, method, 0, false }, MakeTbbExecution(threads));
    }
  }
}

TEST(ExternalTree, ADepthCostsOneReadAndOneWrite)
{
  const HardPoints hard = AllHardPoints({ 40000 }).front();
  const auto tree = BuildKdTree(hard.points, { 2000, {}, 8 });
  SpillFolder folder = MakeSpillFolder();
  SpillFile file = FileOf<double>(folder, hard.points);
  const std::uint64_t bytes = file.Size();
  const auto external = BuildExternalTree<double>(
    folder, file, tree->depths, { bytes / 4 + 4096, FindMedianByHistogram, 0, false }, {});
  ASSERT_TRUE(external);
  const ExternalTreeStatistics& statistics = external->statistics;
  ASSERT_EQ(statistics.depths.size(), 2U);
  EXPECT_EQ(statistics.depths[0].cells, 1U);
  EXPECT_EQ(statistics.depths[1].cells, 2U);
  EXPECT_EQ(statistics.depths[1].records, 40000U);
  EXPECT_EQ(statistics.cellsInMemory, 4U);
  // The root's histogram takes one pass. Those of the halves were gathered when they were written.
  // Points are uniform, so no median needs a second pass.
  EXPECT_EQ(statistics.depths[0].medianPasses, 1U);
  EXPECT_EQ(statistics.depths[1].medianPasses, 0U);
  EXPECT_EQ(statistics.bytesWritten, 3 * bytes);
  EXPECT_EQ(statistics.bytesRead, 5 * bytes); // survey, histogram, two depths, cells in memory
  EXPECT_EQ(statistics.peakBytesOnDisk, 2 * bytes);
}

TEST(ExternalTree, SaysWhatIsWrong)
{
  SpillFolder folder = MakeSpillFolder();
  std::vector<Vec3> points = AllHardPoints({ 5000 }).front().points;
  const TreeDepths depths = *ComputeDepths(points.size(), { 100, {}, 8 });
  const auto build = [&](std::uint64_t memory)
  {
    SpillFile file = FileOf<double>(folder, points);
    const auto tree = BuildExternalTree<double>(folder, file, depths, { memory, {}, 0, false });
    EXPECT_FALSE(tree);
    return tree ? Error{} : tree.GetError();
  };
  for (const std::uint64_t memory : { 20000U, 1U << 20 })
  {
    points[4321][1] = NAN;
    EXPECT_TRUE(IsAt(build(memory), ErrorCode::InvalidInput, "vertex 4321: y"));
    points[4321][1] = 1e308;
    points[1234][1] = -1e308;
    EXPECT_TRUE(IsAt(build(memory), ErrorCode::InvalidInput));
    points[1234][1] = points[4321][1] = 0;
  }
  const Error error = build(5000);
  EXPECT_TRUE(IsAt(error, ErrorCode::LimitExceeded));
  points.clear();
  EXPECT_EQ(build(5000).code, ErrorCode::InvalidArgument);
  EXPECT_EQ(folder.Counts().bytesOnDisk, 0U);
}

TEST(ExternalTree, LeavesNoFilesWhereverItIsCancelled)
{
  const std::vector<Vec3> points = AllHardPoints({ 3000 }).front().points;
  const TreeDepths depths = *ComputeDepths(points.size(), { 100, {}, 8 });
  SpillFolder parent = MakeSpillFolder();
  for (const char* name : allMethods)
  {
    const MedianMethod method = MedianMethodOfName(name);
    bool finished = false;
    for (unsigned stop = 0; !finished; stop += 1 + stop / 8)
    {
      {
        SpillFolder folder = std::move(*SpillFolder::Create(parent.Path()));
        SpillFile file = FileOf<double>(folder, points);
        unsigned reports = 0;
        double before = 0;
        Execution execution;
        execution.progress = [&](std::string_view step, double fraction)
        {
          EXPECT_LE(fraction, 1);
          EXPECT_TRUE(step == "survey" || fraction >= before);
          before = step == "survey" ? 0 : fraction;
          return reports++ != stop;
        };
        const auto tree = BuildExternalTree<double>(
          folder, file, depths, { 20000, method, 0, stop % 2 == 0 }, execution);
        if (reports > stop)
        {
          ASSERT_FALSE(tree);
          EXPECT_EQ(tree.GetError().code, ErrorCode::Cancelled);
        }
        else
        {
          EXPECT_TRUE(tree);
          finished = true;
        }
      }
      ASSERT_TRUE(fs::is_empty(parent.Path()));
    }
  }
}

TEST(ExternalTree, AFullDiskIsAnErrorAndLeavesNoFiles)
{
  const std::vector<Vec3> points = AllHardPoints({ 3000 }).front().points;
  const TreeDepths depths = *ComputeDepths(points.size(), { 100, {}, 8 });
  SpillFolder folder = MakeSpillFolder();
  SpillFile file = FileOf<double>(folder, points);
  rlimit old = {};
  getrlimit(RLIMIT_FSIZE, &old);
  const auto oldHandler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{ 50000, old.rlim_max };
  setrlimit(RLIMIT_FSIZE, &small);
  const auto tree = BuildExternalTree<double>(folder, file, depths, { 20000, {}, 0, true });
  setrlimit(RLIMIT_FSIZE, &old);
  std::signal(SIGXFSZ, oldHandler);
  ASSERT_FALSE(tree);
  EXPECT_EQ(tree.GetError().code, ErrorCode::DiskFull);
  EXPECT_NE(tree.GetError().message.find("points of the tree need 96000 bytes"), std::string::npos)
    << tree.GetError().message;
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.Path()), fs::directory_iterator()), 1);
}
