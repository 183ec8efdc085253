// SPDX-License-Identifier: BSD-3-Clause
// The partition filters in pipelines: threads, progress, abort, errors, re-execution.
#include "filters/Partitioning/Testing/Cxx/PartitionTools.h"
#include "filters/adapter/Testing/SmpBackend.h"

#include <gtest/gtest.h>
#include <vtkErrorCode.h>
#include <vtkImageData.h>
#include <vtkMultiBlockDataSet.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <numeric>

namespace
{

using namespace kdstream::testing;

std::string DescribeOutputs(vtkMeshPartition& filter)
{
  std::string text;
  for (vtkPolyData* partition : Partitions(filter))
  {
    text += Describe(*partition) + "\n--\n";
  }
  return text + Describe(*vtkPolyData::SafeDownCast(filter.GetOutputDataObject(1)));
}

template <class Filter>
class MeshPartitionPipeline : public ::testing::Test
{
};
TYPED_TEST_SUITE(MeshPartitionPipeline, PartitionFilters);

void ExpectEmpty(vtkMeshPartition& filter)
{
  EXPECT_EQ(filter.GetOutput()->GetNumberOfPartitions(), 0U);
  EXPECT_EQ(vtkPolyData::SafeDownCast(filter.GetOutputDataObject(1))->GetNumberOfPoints(), 0);
}

TYPED_TEST(MeshPartitionPipeline, SameOnEveryBackendAndNumberOfThreads)
{
  std::string first;
  for (const std::string& backend : smpBackends)
  {
    for (const int threads : { 8, 2, 1 })
    {
      if (!UseSmpBackend(backend, threads))
      {
        continue;
      }
      vtkNew<TypeParam> filter;
      filter->SetInputData(MakeSphere(70));
      filter->SetVerticesPerPartition(20);
      filter->GeneratePartitionIdsOn();
      filter->Update();
      ASSERT_GT(Partitions(*filter).size(), 200U);
      const std::string outputs = DescribeOutputs(*filter);
      first = first.empty() ? outputs : first;
      EXPECT_TRUE(outputs == first) << backend << ", " << threads << " threads";
    }
  }
}

TYPED_TEST(MeshPartitionPipeline, ProgressRises)
{
  vtkNew<TypeParam> filter;
  filter->SetInputData(MakeSphere(70));
  filter->SetVerticesPerPartition(20);
  FilterObserver observer(filter);
  filter->Update();
  EXPECT_TRUE(std::is_sorted(observer.progress.begin(), observer.progress.end()));
  EXPECT_GT(observer.progress.size(), 8U);
  EXPECT_LE(observer.progress.front(), 0.1);
  EXPECT_EQ(observer.progress.back(), 1.0);
}

TYPED_TEST(MeshPartitionPipeline, AbortLeavesEmptyOutputsAndIsNotAnError)
{
  for (const double at : { 0.0, 0.2, 0.45, 0.55, 0.9 })
  {
    vtkNew<TypeParam> filter;
    filter->SetInputData(MakeSphere(70));
    filter->SetVerticesPerPartition(20);
    FilterObserver observer(filter);
    observer.abortAt = at;
    filter->Update();
    SCOPED_TRACE(at);
    EXPECT_EQ(observer.error, "");
    EXPECT_FALSE(observer.failed);
    ExpectEmpty(*filter);
    observer.StopAborting();
    filter->Update();
    EXPECT_GT(filter->GetOutput()->GetNumberOfPartitions(), 200U);
  }
}

TYPED_TEST(MeshPartitionPipeline, ErrorsNameWhatIsWrongAndLeaveEmptyOutputs)
{
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const PolyData outside = MakePlate(3);
  AddCell(outside->GetPolys(), { 0, 1, 9 });
  const PolyData offsets = MakePlate(3);
  offsets->SetPolys(MakeCells({ 0, 1000000 }, { 0, 1, 2 }));
  const struct
  {
    PolyData input;
    vtkIdType partitions;
    const char* message;
  } cases[] = {
    { MakePoints({ { 0, 0, 0 }, { 0, nan, 0 } }), 0, "point 1: a coordinate is not finite" },
    { outside, 0, "cell 8 uses point 9, but there are 9" },
    { offsets, 0, "cell 0 uses corners 0 to 1000000 of a list of 3" },
    { MakePlate(3), 16, "number of partitions 16 is above the number of vertices, 9" },
  };
  for (const auto& c : cases)
  {
    SCOPED_TRACE(c.message);
    vtkNew<TypeParam> filter;
    filter->SetInputData(MakePlate(3));
    filter->Update();
    ASSERT_EQ(filter->GetOutput()->GetNumberOfPartitions(), 1U);
    FilterObserver observer(filter);
    filter->SetInputData(c.input);
    filter->SetNumberOfPartitions(c.partitions);
    filter->Update();
    EXPECT_NE(observer.error.find(c.message), std::string::npos) << observer.error;
    EXPECT_TRUE(observer.failed) << "the pipeline was not told";
    ExpectEmpty(*filter);
  }
}

TYPED_TEST(MeshPartitionPipeline, EmptyInputs)
{
  const PolyData noPoints = PolyData::New(); // a null vtkPoints
  for (const PolyData& input : { noPoints, MakePoints({}) })
  {
    vtkNew<TypeParam> filter;
    FilterObserver observer(filter);
    filter->SetInputData(input);
    filter->GeneratePartitionIdsOn();
    filter->Update();
    EXPECT_EQ(observer.error, "");
    ExpectEmpty(*filter);
  }
}

TYPED_TEST(MeshPartitionPipeline, OnlyLinesAndOnlyPoints)
{
  const PolyData input = MakePoints({ { 0, 0, 0 }, { 1, 0, 0 }, { 2, 0, 0 }, { 3, 0, 0 } });
  vtkNew<vtkCellArray> cells;
  AddCell(cells, { 0, 1, 2, 3 });
  input->SetLines(cells);
  vtkNew<TypeParam> filter;
  filter->SetInputData(input);
  filter->SetVerticesPerPartition(2);
  filter->Update();
  ASSERT_EQ(Partitions(*filter).size(), 2U);
  vtkIdType lines = 0, own = 0; // one of the three belongs to both
  for (vtkPolyData* partition : Partitions(*filter))
  {
    lines += partition->GetNumberOfLines();
    for (vtkIdType c = 0; c < partition->GetNumberOfCells(); ++c)
    {
      own += !IsGhost(partition->GetCellData(), c);
    }
  }
  EXPECT_EQ(lines, 4);
  EXPECT_EQ(own, 3);
  filter->SetInputData(MakePoints({ { 5, 5, 5 } }));
  filter->Update();
  ASSERT_EQ(Partitions(*filter).size(), 1U);
  EXPECT_EQ(Partitions(*filter)[0]->GetNumberOfPoints(), 1);
}

TYPED_TEST(MeshPartitionPipeline, RunsAgainOnlyWhenSomethingChanged)
{
  vtkNew<TypeParam> filter;
  const PolyData input = MakeSphere(20);
  filter->SetInputData(input);
  FilterObserver observer(filter);
  filter->Update();
  filter->Update();
  filter->SetVerticesPerPartition(filter->GetVerticesPerPartition());
  filter->SetNumberOfPartitions(0);
  filter->GeneratePartitionIdsOff();
  filter->Update(1);
  EXPECT_EQ(observer.runs, 1);
  filter->SetVerticesPerPartition(100);
  filter->Update();
  EXPECT_EQ(observer.runs, 2);
  EXPECT_GE(Partitions(*filter).size(), 4U);
  filter->SetNumberOfPartitions(8);
  filter->Update();
  EXPECT_EQ(observer.runs, 3);
  EXPECT_EQ(Partitions(*filter).size(), 8U);
  filter->GeneratePartitionIdsOn();
  filter->Update();
  EXPECT_EQ(observer.runs, 4);
  EXPECT_TRUE(Partitions(*filter)[0]->GetPointData()->HasArray("PartitionId"));
  input->Modified();
  filter->Update();
  EXPECT_EQ(observer.runs, 5);
}

// If only port 1 is requested, it has the partition of each point, and nothing is cut. When port 0
// is requested afterwards, points are not assigned again.
TYPED_TEST(MeshPartitionPipeline, IdsDoNotCutAnything)
{
  vtkNew<TypeParam> filter, both;
  for (TypeParam* each : { filter.Get(), both.Get() })
  {
    each->SetInputData(MakeSphere(70));
    each->SetVerticesPerPartition(20);
    each->GeneratePartitionIdsOn();
  }
  both->Update();
  FilterObserver observer(filter);
  filter->Update(1);
  EXPECT_EQ(filter->GetOutput()->GetNumberOfPartitions(), 0U);
  const auto ids = vtkPolyData::SafeDownCast(filter->GetOutputDataObject(1));
  EXPECT_EQ(Describe(*ids), Describe(*vtkPolyData::SafeDownCast(both->GetOutputDataObject(1))));
  EXPECT_EQ(observer.progress.back(), 1.0);
  filter->Update(1);
  EXPECT_EQ(observer.runs, 1);

  observer.progress.clear();
  filter->Update();
  EXPECT_EQ(observer.runs, 2);
  EXPECT_TRUE(DescribeOutputs(*filter) == DescribeOutputs(*both));
  for (const double progress : observer.progress)
  {
    EXPECT_TRUE(progress == 0 || progress > 0.5) << progress << ": it was found out again";
  }
  filter->Update(1);
  EXPECT_EQ(observer.runs, 2);

  const PolyData outside = MakePlate(3);
  AddCell(outside->GetPolys(), { 0, 1, 9 });
  filter->SetInputData(outside);
  filter->Update(1);
  EXPECT_NE(observer.error.find("cell 8 uses point 9, but there are 9"), std::string::npos)
    << observer.error;
}

// Points are assigned again if a block was changed in place, which does not change the composite's
// own time, and if a block was replaced by another one with the same time.
TYPED_TEST(MeshPartitionPipeline, BlocksChangedInPlaceAreFoundOutAgain)
{
  const PolyData older = MakePlate(20); // has the same number of points as MakeSphere(20)
  vtkNew<vtkMultiBlockDataSet> blocks, inner;
  const PolyData block = MakeSphere(20);
  inner->SetBlock(0, block);
  blocks->SetBlock(0, inner);
  const auto cut = [&](bool idsFirst)
  {
    auto filter = vtkSmartPointer<TypeParam>::New();
    filter->SetInputDataObject(blocks);
    filter->SetVerticesPerPartition(30);
    if (idsFirst)
    {
      filter->Update(1);
    }
    return filter;
  };
  const std::vector<std::function<void()>> changes{
    [&]
    {
      const PolyData larger = MakeSphere(40);
      block->SetPoints(larger->GetPoints());
      block->SetPolys(larger->GetPolys());
      block->GetPointData()->Initialize();
      block->GetCellData()->Initialize();
    },
    [&]
    {
      for (vtkIdType i = 0; i < block->GetNumberOfPoints(); i += 3)
      {
        block->GetPoints()->SetPoint(i, 5 + double(i), 0, 0);
      }
      block->GetPoints()->Modified();
    },
    [&] { inner->SetBlock(0, older); },
  };
  for (const auto& change : changes)
  {
    const auto filter = cut(true);
    change();
    filter->Update();
    const auto anew = cut(false);
    anew->Update();
    EXPECT_TRUE(DescribeOutputs(*filter) == DescribeOutputs(*anew));
  }
}

TYPED_TEST(MeshPartitionPipeline, OptionsAreClampedAndPrinted)
{
  vtkNew<TypeParam> filter;
  EXPECT_EQ(filter->GetVerticesPerPartition(), 2000);
  EXPECT_EQ(filter->GetNumberOfPartitions(), 0);
  EXPECT_FALSE(filter->GetGeneratePartitionIds());
  filter->SetVerticesPerPartition(0);
  {
    FilterObserver observer(filter);
    filter->SetNumberOfPartitions(-4);
    filter->SetVerticesPerPartition(-2);
    EXPECT_NE(observer.error.find("NumberOfPartitions must be from 0 to "), std::string::npos);
    EXPECT_NE(observer.error.find("VerticesPerPartition must be from 1 to "), std::string::npos);
  }
  EXPECT_EQ(filter->GetVerticesPerPartition(), 1);
  EXPECT_EQ(filter->GetNumberOfPartitions(), 0);
  filter->SetVerticesPerPartition(VTK_ID_MAX);
  EXPECT_EQ(filter->GetVerticesPerPartition(), VTK_INT_MAX);
  filter->SetVerticesPerPartition(17);
  filter->SetNumberOfPartitions(32);
  filter->GeneratePartitionIdsOn();
  std::ostringstream text;
  filter->Print(text);
  for (const char* line :
    { "VerticesPerPartition: 17\n", "NumberOfPartitions: 32\n", "GeneratePartitionIds: on\n" })
  {
    EXPECT_NE(text.str().find(line), std::string::npos) << line;
  }
}

TYPED_TEST(MeshPartitionPipeline, BlocksOfACompositeInputAreOneMesh)
{
  vtkNew<vtkMultiBlockDataSet> blocks, inner;
  inner->SetBlock(0, MakeSphere(20));
  inner->SetBlock(1, nullptr);
  blocks->SetBlock(0, inner);
  blocks->SetBlock(1, MakePlate(10));
  blocks->SetBlock(2, PolyData::New());
  vtkNew<TypeParam> filter;
  FilterObserver observer(filter);
  filter->SetInputDataObject(blocks);
  filter->SetVerticesPerPartition(100);
  filter->Update();
  EXPECT_EQ(observer.error, "");
  EXPECT_EQ(observer.warning, "");
  const std::vector<vtkIdType> sizes = Sizes(*filter);
  EXPECT_GE(sizes.size(), 5U);
  EXPECT_EQ(std::accumulate(sizes.begin(), sizes.end(), vtkIdType{ 0 }), 500);
  blocks->SetBlock(1, vtkSmartPointer<vtkImageData>::New());
  vtkImageData::SafeDownCast(blocks->GetBlock(1))->SetDimensions(2, 2, 2);
  filter->Modified();
  filter->Update();
  EXPECT_NE(observer.error.find("block 4 is a vtkImageData, not a vtkPolyData"), std::string::npos)
    << observer.error;
  EXPECT_EQ(filter->GetErrorCode(), static_cast<unsigned long>(vtkErrorCode::UnknownError));
}

}
