// SPDX-License-Identifier: BSD-3-Clause
// What is particular to each partition filter: sizes, numbers of partitions, options, bad input.
#include "filters/Partitioning/Testing/Cxx/PartitionTools.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace
{

using namespace kdstream::testing;

struct Input
{
  const char* name;
  PolyData mesh;
};

std::vector<Input> Inputs()
{
  return { { "sphere", MakeSphere(40) }, { "plate", MakePlate(33) },
    { "repeated point", MakeRepeatedPoint(30) },
    { "line", MakeGrid(20,
                [](double u, double v) {
                  return std::array<double, 3>{ u + v, 0, 0 };
                }) } };
}

template <class Filter>
std::vector<vtkIdType> SizesOf(vtkPolyData* input, vtkIdType most, vtkIdType partitions = 0)
{
  vtkNew<Filter> filter;
  FilterObserver observer(filter);
  filter->SetInputData(input);
  filter->SetVerticesPerPartition(most);
  filter->SetNumberOfPartitions(partitions);
  filter->Update();
  EXPECT_EQ(observer.error, "");
  const std::vector<vtkIdType> sizes = Sizes(*filter);
  EXPECT_EQ(
    std::accumulate(sizes.begin(), sizes.end(), vtkIdType{ 0 }), input->GetNumberOfPoints());
  return sizes;
}

TEST(KdTreePartition, Uniform)
{
  for (const Input& input : Inputs())
  {
    for (const vtkIdType most : { 1, 2, 7, 100, 2000 })
    {
      SCOPED_TRACE(std::string(input.name) + ", " + std::to_string(most));
      const std::vector<vtkIdType> sizes = SizesOf<vtkKdTreePartition>(input.mesh, most);
      const auto [smallest, largest] = std::minmax_element(sizes.begin(), sizes.end());
      EXPECT_LE(*largest - *smallest, 1);
      EXPECT_LE(*largest, most);
      const auto count = static_cast<vtkIdType>(sizes.size());
      EXPECT_EQ(count & (count - 1), 0);
      const vtkIdType points = input.mesh->GetNumberOfPoints();
      EXPECT_TRUE(count == 1 || (points + count / 2 - 1) / (count / 2) > most) << "too many";
    }
  }
}

TEST(KdTreePartition, NumberOfPartitions)
{
  for (const vtkIdType count : { 1, 2, 64, 256 })
  {
    EXPECT_EQ(SizesOf<vtkKdTreePartition>(MakeSphere(20), 2000, count).size(), std::size_t(count));
  }
  vtkNew<vtkKdTreePartition> filter;
  FilterObserver observer(filter);
  filter->SetInputData(MakePlate(3));
  filter->SetNumberOfPartitions(3);
  filter->Update();
  EXPECT_NE(observer.error.find("number of partitions 3 is not a power of two"), std::string::npos);
  EXPECT_TRUE(observer.failed);
  EXPECT_EQ(filter->GetOutput()->GetNumberOfPartitions(), 0U);
}

TEST(OctreePartition, CubesOfAtMostNAndNoneEmpty)
{
  for (const Input& input : Inputs())
  {
    for (const vtkIdType most : { 1, 7, 100, 2000 })
    {
      SCOPED_TRACE(std::string(input.name) + ", " + std::to_string(most));
      const std::vector<vtkIdType> sizes = SizesOf<vtkOctreePartition>(input.mesh, most);
      EXPECT_GE(*std::min_element(sizes.begin(), sizes.end()), 1);
      if (input.name == std::string("repeated point"))
      {
        EXPECT_EQ(sizes, std::vector<vtkIdType>{ 900 }) << "one place is not split";
      }
      else if (most > 40) // points repeat at the seam and the poles of the sphere, and on the line
      {
        EXPECT_LE(*std::max_element(sizes.begin(), sizes.end()), most);
      }
    }
  }
}

TEST(OctreePartition, TheNumberOfPartitionsIsTheNearestPossible)
{
  // A plate of 32 × 32 points is cut into 1, 4, 16, 64 … cubes.
  const PolyData plate = MakePlate(32);
  const std::pair<vtkIdType, std::size_t> cases[] = { { 1, 1 }, { 2, 1 }, { 3, 4 }, { 4, 4 },
    { 10, 4 }, { 11, 16 }, { 64, 64 }, { 100, 64 }, { 1000, 1024 } };
  for (const auto& [wanted, found] : cases)
  {
    EXPECT_EQ(SizesOf<vtkOctreePartition>(plate, 2000, wanted).size(), found) << wanted;
  }
  EXPECT_EQ(SizesOf<vtkOctreePartition>(MakeRepeatedPoint(10), 2000, 50).size(), 1U);
}

TEST(KMeansPartition, ExactlyAsManyAsRequestedNoneEmpty)
{
  for (const Input& input : Inputs())
  {
    for (const vtkIdType count :
      { vtkIdType{ 1 }, vtkIdType{ 3 }, vtkIdType{ 50 }, input.mesh->GetNumberOfPoints() })
    {
      SCOPED_TRACE(std::string(input.name) + ", " + std::to_string(count));
      const std::vector<vtkIdType> sizes = SizesOf<vtkKMeansPartition>(input.mesh, 2000, count);
      EXPECT_EQ(sizes.size(), std::size_t(count));
      EXPECT_GE(*std::min_element(sizes.begin(), sizes.end()), 1);
    }
    EXPECT_EQ(SizesOf<vtkKMeansPartition>(input.mesh, 100).size(),
      std::size_t((input.mesh->GetNumberOfPoints() + 99) / 100));
  }
}

// Clusters follow the surface: with two plates, one above the other, each cluster is on one plate.
TEST(KMeansPartition, ClustersFollowTheSurface)
{
  PolyData plates = MakePlate(20);
  for (vtkIdType i = 0; i < 400; ++i)
  {
    const auto p = Point(*plates, i);
    plates->GetPoints()->InsertNextPoint(p[0], p[1], p[2] + 1e-3);
  }
  vtkNew<vtkCellArray> triangles;
  triangles->DeepCopy(plates->GetPolys());
  triangles->Append(plates->GetPolys(), 400);
  plates->SetPolys(triangles);
  plates->GetPointData()->Initialize();
  plates->GetCellData()->Initialize();
  AddIds(*plates);
  vtkNew<vtkKMeansPartition> filter;
  filter->SetInputData(plates);
  filter->SetNumberOfPartitions(10);
  filter->Update();
  for (vtkPolyData* partition : Partitions(*filter))
  {
    const bool upper = Value(partition->GetPointData(), "Point", 0) >= 400;
    for (vtkIdType i = 0; i < partition->GetNumberOfPoints(); ++i)
    {
      EXPECT_EQ(Value(partition->GetPointData(), "Point", i) >= 400, upper);
    }
  }
}

TEST(KMeansPartition, OptionsAreClampedPrintedAndUsed)
{
  vtkNew<vtkKMeansPartition> filter;
  EXPECT_EQ(filter->GetNumberOfIterations(), 5);
  EXPECT_EQ(filter->GetDistanceWeight(), 1);
  EXPECT_EQ(filter->GetCompactnessWeight(), 4);
  EXPECT_EQ(filter->GetCountWeight(), 1);
  filter->SetNumberOfIterations(0);
  filter->SetDistanceWeight(0);
  filter->SetCompactnessWeight(0);
  filter->SetCountWeight(1e9);
  EXPECT_EQ(filter->GetNumberOfIterations(), 1);
  EXPECT_EQ(filter->GetDistanceWeight(), 1e-6);
  EXPECT_EQ(filter->GetCompactnessWeight(), 0);
  EXPECT_EQ(filter->GetCountWeight(), 1e6);
  filter->SetNumberOfIterations(7);
  filter->SetDistanceWeight(2);
  filter->SetCompactnessWeight(3);
  filter->SetCountWeight(5);
  std::ostringstream text;
  filter->Print(text);
  for (const char* line : { "NumberOfIterations: 7\n", "DistanceWeight: 2\n",
         "CompactnessWeight: 3\n", "CountWeight: 5\n", "VerticesPerPartition: 2000\n" })
  {
    EXPECT_NE(text.str().find(line), std::string::npos) << line;
  }

  // Each of these changes the result, so the filter must run again.
  const PolyData input = MakeSphere(40);
  vtkNew<vtkKMeansPartition> other;
  FilterObserver observer(other);
  other->SetInputData(input);
  other->SetNumberOfPartitions(12);
  other->Update();
  std::vector<vtkIdType> before = Sizes(*other);
  const auto runs = [&](int expected)
  {
    other->Update();
    EXPECT_EQ(observer.runs, expected);
    EXPECT_NE(Sizes(*other), before);
    before = Sizes(*other);
  };
  other->SetNumberOfIterations(1);
  runs(2);
  other->SetDistanceWeight(0.2);
  runs(3);
  other->SetCompactnessWeight(0);
  runs(4);
  other->SetCountWeight(0);
  runs(5);
  other->SetCountWeight(0);
  other->Update();
  EXPECT_EQ(observer.runs, 5);
  other->SetDistanceWeight(2);
  other->SetDistanceWeight(std::numeric_limits<double>::quiet_NaN());
  EXPECT_NE(observer.error.find("DistanceWeight must be from 1e-06 to 1e+06, not nan: it stays 2"),
    std::string::npos)
    << observer.error;
  EXPECT_EQ(other->GetDistanceWeight(), 2);
}

}
