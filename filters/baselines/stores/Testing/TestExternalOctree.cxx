// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/HardPoints.h"
#include "filters/baselines/OctreeClustering.h"
#include "filters/baselines/stores/ExternalOctree.h"
#include "filters/outofcore/Testing/SpillTools.h"
#include "filters/outofcore/files/RecordFile.h"
#include "filters/program/TbbExecution.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

using namespace kdstream;
using kdstream::testing::MakeSpillFolder;
using namespace kdstream::fixtures;
namespace fs = std::filesystem;

namespace
{

template <class Scalar>
SpillFile FileOf(SpillFolder& folder, const std::vector<Vec3>& points)
{
  SpillFile file = std::move(*folder.CreateFile("points", 0));
  RecordWriter<PointRecord<Scalar>> writer(file);
  for (std::size_t i = 0; i < points.size(); ++i)
  {
    PointRecord<Scalar> record{};
    for (std::size_t k = 0; k < 3; ++k)
    {
      record.p[k] = static_cast<Scalar>(points[i][k]);
    }
    record.id = static_cast<VertexId>(i);
    writer.Append(record);
  }
  EXPECT_TRUE(writer.Finish());
  return file;
}

template <class Scalar>
void Compare(SpillFolder& folder, const std::vector<Vec3>& points, const OctreeClustering& expected,
  const ExternalOctreeOptions& options, const Execution& execution)
{
  SpillFile file = FileOf<Scalar>(folder, points);
  const auto octree = ClusterByExternalOctree<Scalar>(folder, file, options, execution);
  ASSERT_TRUE(octree) << octree.GetError().message;
  EXPECT_EQ(octree->depth, expected.depth);
  ASSERT_EQ(octree->clusterBegin.size(), expected.clusters + 1U);
  ASSERT_EQ(octree->clusterBegin.front(), 0U);
  ASSERT_EQ(octree->clusterBegin.back(), points.size());
  std::vector<PointRecord<Scalar>> records(points.size());
  ASSERT_TRUE(
    ReadRecords<PointRecord<Scalar>>(octree->records, 0, std::span<PointRecord<Scalar>>(records)));
  if (options.keepPoints)
  {
    std::vector<PointRecord<Scalar>> kept(points.size());
    ASSERT_TRUE(ReadRecords<PointRecord<Scalar>>(file, 0, std::span<PointRecord<Scalar>>(kept)));
    for (std::size_t i = 0; i < kept.size(); ++i)
    {
      ASSERT_EQ(kept[i].id, i);
    }
  }
  for (std::uint32_t cluster = 0; cluster < expected.clusters; ++cluster)
  {
    for (std::uint64_t i = octree->clusterBegin[cluster]; i < octree->clusterBegin[cluster + 1];
         ++i)
    {
      ASSERT_EQ(expected.clusterOf[records[i].id], cluster);
      ASSERT_EQ(double(records[i].p[2]), points[records[i].id][2]);
      ASSERT_TRUE(i == octree->clusterBegin[cluster] || records[i - 1].id < records[i].id);
    }
  }
}

}

TEST(ExternalOctree, IsTheOctreeInMemoryForEveryLimit)
{
  SpillFolder folder = MakeSpillFolder();
  for (const HardPoints& hard : AllHardPoints({ 1, 2, 100, 3000 }))
  {
    for (const std::uint32_t most : { 1U, 20U, 300U, 10000U })
    {
      const auto expected = ClusterByOctree(hard.points, { most, {} });
      ASSERT_TRUE(expected);
      for (const std::uint64_t memory : { 8192U, 30000U, 1U << 24 })
      {
        for (const bool keepPoints : { false, true })
        {
          SCOPED_TRACE(hard.name + ", " + std::to_string(hard.points.size()) + ", N " +
                       std::to_string(most) + ", memory " + std::to_string(memory));
          Compare<double>(folder, hard.points, *expected, { most, memory, keepPoints }, {});
          if (hard.fitFloats)
          {
            Compare<float>(folder, hard.points, *expected, { most, memory, keepPoints }, {});
          }
          if (::testing::Test::HasFatalFailure())
          {
            return;
          }
        }
      }
    }
  }
  EXPECT_EQ(folder.Counts().bytesOnDisk, 0U);
}

TEST(ExternalOctree, IsTheSameOnAnyNumberOfThreads)
{
  SpillFolder folder = MakeSpillFolder();
  for (const HardPoints& hard : AllHardPoints({ 100000 }))
  {
    SCOPED_TRACE(hard.name);
    const auto expected = ClusterByOctree(hard.points, { 500, {} });
    for (const unsigned threads : { 1U, 5U })
    {
      Compare<double>(
        folder, hard.points, *expected, { 500, 2 << 20, false }, MakeTbbExecution(threads));
    }
  }
}

TEST(ExternalOctree, ACellCostsTwoReadsAndAWrite)
{
  const HardPoints hard = AllHardPoints({ 40000 }).front();
  SpillFolder folder = MakeSpillFolder();
  SpillFile file = FileOf<double>(folder, hard.points);
  const std::uint64_t bytes = file.Size();
  const auto octree = ClusterByExternalOctree<double>(folder, file, { 500, bytes, false });
  ASSERT_TRUE(octree);
  EXPECT_EQ(octree->statistics.distributions, 1U);
  EXPECT_EQ(octree->statistics.distributedRecords, 40000U);
  EXPECT_EQ(octree->statistics.bytesRead, 4 * bytes); // survey, counts, groups, cells in memory
  EXPECT_EQ(octree->statistics.bytesWritten, 2 * bytes);
  EXPECT_EQ(octree->statistics.peakBytesOnDisk, 2 * bytes);
}

TEST(ExternalOctree, SaysWhatIsWrong)
{
  SpillFolder folder = MakeSpillFolder();
  std::vector<Vec3> points = AllHardPoints({ 500 }).front().points;
  const auto build = [&](const ExternalOctreeOptions& options)
  {
    SpillFile file = FileOf<double>(folder, points);
    const auto octree = ClusterByExternalOctree<double>(folder, file, options);
    EXPECT_FALSE(octree);
    return octree ? Error{} : octree.GetError();
  };
  EXPECT_EQ(build({ 0, 1 << 20, false }).code, ErrorCode::InvalidArgument);
  EXPECT_EQ(build({ 10, 100, false }).code, ErrorCode::LimitExceeded);
  points[77][0] = INFINITY;
  EXPECT_TRUE(IsAt(build({ 10, 1 << 20, false }), ErrorCode::InvalidInput, "vertex 77: x"));
  points.clear();
  EXPECT_EQ(build({ 10, 1 << 20, false }).code, ErrorCode::InvalidArgument);
}

TEST(ExternalOctree, LeavesNoFilesWhereverItIsCancelled)
{
  const std::vector<Vec3> points = AllHardPoints({ 3000 }).front().points;
  SpillFolder parent = MakeSpillFolder();
  bool finished = false;
  for (unsigned stop = 0; !finished; stop += 1 + stop / 8)
  {
    {
      SpillFolder folder = std::move(*SpillFolder::Create(parent.Path()));
      SpillFile file = FileOf<double>(folder, points);
      unsigned reports = 0;
      Execution execution;
      execution.progress = [&](std::string_view, double fraction)
      {
        EXPECT_LE(fraction, 1);
        return reports++ != stop;
      };
      const auto octree =
        ClusterByExternalOctree<double>(folder, file, { 20, 10000, stop % 2 == 0 }, execution);
      finished = octree.HasValue();
      EXPECT_EQ(finished, reports <= stop);
    }
    ASSERT_TRUE(fs::is_empty(parent.Path()));
  }
}
