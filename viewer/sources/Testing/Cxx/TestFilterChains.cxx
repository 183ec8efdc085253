// SPDX-License-Identifier: BSD-3-Clause
// Chains of any two filters: if a filter outputs a mesh in parts, the next filter takes them as the
// same mesh. Prints a table of own cells, areas and error codes.
#include "viewer/sources/Testing/Cxx/ModelSourceTools.h"

#include <vtkErrorCode.h>
#include <vtkKMeansPartition.h>
#include <vtkKdClusterSimplification.h>
#include <vtkKdMeshReader.h>
#include <vtkKdStoreReader.h>
#include <vtkKdStoreWriter.h>
#include <vtkKdTreePartition.h>
#include <vtkOctreePartition.h>
#ifdef KDSTREAM_RECONSTRUCTION
#include <vtkPCLSurfaceReconstruction.h>
#endif
#include <vtkPartitionMeasures.h>
#include <vtkTable.h>
#include <vtkTriangle.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <numeric>

namespace
{

using namespace kdstream;
using namespace kdstream::testing;
using kdstream::fixtures::TemporaryFolder;

using Data = vtkSmartPointer<vtkDataObject>;

struct Outcome
{
  Data data;  // the output
  Data whole; // the output as one mesh, if there is one
  vtkIdType cells = 0;
  double area = 0;
  unsigned long error = 0;
};

void AddOwn(vtkPolyData& mesh, Outcome& outcome)
{
  vtkDataArray* const marks = mesh.GetCellData()->GetArray(vtkDataSetAttributes::GhostArrayName());
  for (vtkIdType i = 0; i < mesh.GetNumberOfCells(); ++i)
  {
    if (!marks || marks->GetComponent(i, 0) == 0)
    {
      const Ids ids = CellPoints(mesh, i);
      ++outcome.cells;
      outcome.area += ids.size() != 3 ? 0
                                      : vtkTriangle::TriangleArea(Point(mesh, ids[0]).data(),
                                          Point(mesh, ids[1]).data(), Point(mesh, ids[2]).data());
    }
  }
}

void Measure(Outcome& outcome)
{
  if (auto* const mesh = vtkPolyData::SafeDownCast(outcome.data))
  {
    AddOwn(*mesh, outcome);
  }
  else if (auto* const parts = vtkPartitionedDataSet::SafeDownCast(outcome.data))
  {
    for (unsigned int i = 0; i < parts->GetNumberOfPartitions(); ++i)
    {
      if (auto* const part = vtkPolyData::SafeDownCast(parts->GetPartitionAsDataObject(i)))
      {
        AddOwn(*part, outcome);
      }
    }
  }
  else if (auto* const table = vtkTable::SafeDownCast(outcome.data))
  {
    for (vtkIdType i = 0; i < table->GetNumberOfRows(); ++i)
    {
      outcome.cells += table->GetValueByName(i, "OwnTriangles").ToTypeInt64();
      outcome.area += table->GetValueByName(i, "Area").ToDouble();
    }
  }
}

using Filter = std::function<Outcome(vtkDataObject&)>;

Outcome RunOn(vtkAlgorithm& filter, vtkDataObject& input, int port = 0, int wholePort = 0)
{
  FilterObserver heard(&filter);
  filter.SetInputDataObject(0, &input);
  filter.Update();
  EXPECT_EQ(heard.warning, "");
  EXPECT_EQ(heard.error.empty(), filter.GetErrorCode() == 0) << heard.error;
  Outcome outcome{ filter.GetOutputDataObject(port), filter.GetOutputDataObject(wholePort) };
  outcome.error = filter.GetErrorCode();
  Measure(outcome);
  return outcome;
}

template <class Partition>
Filter Partitioner(vtkIdType size)
{
  return [size](vtkDataObject& input)
  {
    vtkNew<Partition> filter;
    filter->SetVerticesPerPartition(size);
    filter->GeneratePartitionIdsOn();
    return RunOn(*filter, input, 0, 1);
  };
}

std::string DescribeParts(vtkDataObject& data)
{
  auto* const parts = vtkPartitionedDataSet::SafeDownCast(&data);
  std::string text;
  for (unsigned int i = 0; parts && i < parts->GetNumberOfPartitions(); ++i)
  {
    text += Describe(*vtkPolyData::SafeDownCast(parts->GetPartitionAsDataObject(i))) + "\n--\n";
  }
  return parts ? text : Describe(*vtkPolyData::SafeDownCast(&data));
}

class TestFilterChains : public ::testing::Test
{
protected:
  std::vector<std::pair<std::string, Filter>> Filters(vtkIdType size)
  {
    std::vector<std::pair<std::string, Filter>> filters{
      { "KdTreePartition", Partitioner<vtkKdTreePartition>(size) },
      { "OctreePartition", Partitioner<vtkOctreePartition>(size) },
      { "KMeansPartition", Partitioner<vtkKMeansPartition>(size) },
      { "Simplification, cluster",
        [](vtkDataObject& input)
        {
          vtkNew<vtkKdClusterSimplification> filter;
          filter->SetMakerToCluster();
          return RunOn(*filter, input);
        } },
      { "Simplification, collapse",
        [](vtkDataObject& input)
        {
          vtkNew<vtkKdClusterSimplification> filter;
          filter->SetMakerToCollapse();
          filter->SetTargetNumberOfTriangles(600);
          return RunOn(*filter, input);
        } },
      { "PartitionMeasures",
        [](vtkDataObject& input)
        {
          vtkNew<vtkPartitionMeasures> filter;
          return RunOn(*filter, input);
        } },
      { "StoreWriter",
        [this, size](vtkDataObject& input)
        {
          const std::string file = (this->Folder / "chain.kds").string();
          vtkNew<vtkKdStoreWriter> writer;
          writer->SetFileName(file.c_str());
          writer->SetGridBits(0);
          writer->SetVerticesPerPartition(size);
          writer->SetInputDataObject(0, &input);
          FilterObserver heard(writer);
          writer->Write();
          EXPECT_EQ(heard.warning, "");
          vtkNew<vtkKdStoreReader> reader;
          reader->SetFileName(file.c_str());
          Outcome outcome;
          outcome.error = writer->GetErrorCode();
          if (outcome.error == 0)
          {
            reader->Update();
            outcome.data = reader->GetOutputDataObject(0);
            vtkNew<vtkKdStoreReader> whole;
            whole->SetFileName(file.c_str());
            whole->SetOutputTypeToPolyData();
            whole->Update();
            outcome.whole = whole->GetOutputDataObject(0);
            Measure(outcome);
          }
          return outcome;
        } },
    };
#ifdef KDSTREAM_RECONSTRUCTION
    filters.emplace_back("SurfaceReconstruction",
      [](vtkDataObject& input)
      {
        vtkNew<vtkPCLSurfaceReconstruction> filter;
        return RunOn(*filter, input);
      });
#endif
    return filters;
  }

  // For each pair: from the parts that the first filter outputs, the second filter makes the same
  // as from one mesh.
  void ExpectChains(vtkPolyData& mesh, vtkIdType size, double tolerance)
  {
    for (const auto& [name, first] : this->Filters(size))
    {
      const Outcome before = first(mesh);
      ASSERT_TRUE(before.data) << name << ": error " << before.error;
      for (const auto& [next, second] : this->Filters(size))
      {
        SCOPED_TRACE(name + " -> " + next);
        if (before.data->IsA("vtkTable"))
        {
          continue; // a table ends a chain
        }
        const Outcome one = second(*before.whole), parts = second(*before.data);
        std::printf("%-26s %-26s %8lld %8lld  %.6f %.6f  %5lu %5lu\n", name.c_str(), next.c_str(),
          static_cast<long long>(one.cells), static_cast<long long>(parts.cells), one.area,
          parts.area, one.error, parts.error);
        // The tolerance for stores: a store keeps global ids, and its parts are joined in the order
        // of these, but its single mesh is in the store's order. The order decides between equal
        // coordinates.
        std::fflush(stdout);
        const double most = name == "StoreWriter" ? std::max(tolerance, 0.01) : tolerance;
        EXPECT_NEAR(double(parts.cells), double(one.cells), most * double(one.cells));
        EXPECT_NEAR(parts.area, one.area, (most + 1e-9) * one.area);
        EXPECT_EQ(parts.error, one.error);
        EXPECT_EQ(parts.error == 0, parts.cells > 0);
      }
    }
  }

  // The partitions of a store are the same as its single mesh; bit for bit if the store is
  // lossless. On a coarse grid, several points may get the same position; then one cannot know
  // which of them a cell uses.
  void ExpectStoreChain(vtkPolyData& mesh, int bits, vtkIdType size, vtkIdType target)
  {
    SCOPED_TRACE(bits);
    const std::string file = (this->Folder / "model.kds").string();
    vtkNew<vtkKdStoreWriter> writer;
    writer->SetInputData(&mesh);
    writer->SetFileName(file.c_str());
    writer->SetGridBits(bits);
    writer->SetVerticesPerPartition(size);
    ASSERT_EQ(writer->Write(), 1);
    std::vector<Outcome> cuts, levels;
    for (const bool whole : { true, false })
    {
      vtkNew<vtkKdStoreReader> reader;
      reader->SetFileName(file.c_str());
      reader->SetOutputType(
        whole ? vtkKdModelSource::PolyData : vtkKdModelSource::PartitionedDataSet);
      vtkNew<vtkKdTreePartition> partition;
      partition->SetInputConnection(reader->GetOutputPort());
      partition->SetVerticesPerPartition(size * 3 / 2);
      partition->Update();
      cuts.push_back({ partition->GetOutput(), nullptr });
      vtkNew<vtkKdClusterSimplification> level;
      level->SetInputConnection(partition->GetOutputPort());
      level->SetTargetNumberOfTriangles(target);
      level->Update();
      levels.push_back({ level->GetOutput(), nullptr });
      Measure(cuts.back());
      Measure(levels.back());
      std::printf("%-26s %8lld %.9f %8lld %.9f\n", whole ? "one mesh" : "partitions",
        static_cast<long long>(cuts.back().cells), cuts.back().area,
        static_cast<long long>(levels.back().cells), levels.back().area);
    }
    EXPECT_EQ(cuts[0].cells, mesh.GetNumberOfCells());
    EXPECT_EQ(cuts[1].cells, cuts[0].cells);
    EXPECT_NEAR(cuts[1].area, cuts[0].area, 1e-9 * cuts[0].area);
    EXPECT_GT(levels[0].cells, target / 2);
    EXPECT_NEAR(
      double(levels[1].cells), double(levels[0].cells), bits == 0 ? 0 : 0.001 * double(target));
    EXPECT_NEAR(levels[1].area, levels[0].area, bits == 0 ? 0 : 1e-3 * levels[0].area);
    if (bits == 0)
    {
      EXPECT_TRUE(DescribeParts(*cuts[0].data) == DescribeParts(*cuts[1].data));
      EXPECT_TRUE(DescribeParts(*levels[0].data) == DescribeParts(*levels[1].data));
    }
  }

  TemporaryFolder Folder;
};

PolyData NumberedSphere(int side)
{
  PolyData sphere = MakeSphere(side);
  for (vtkDataSetAttributes* data :
    std::array<vtkDataSetAttributes*, 2>{ sphere->GetPointData(), sphere->GetCellData() })
  {
    vtkDataArray* const ids = data->GetArray(0);
    ids->SetName("GlobalIds");
    data->SetGlobalIds(ids);
  }
  return sphere;
}

// With global ids, the parts are the mesh to the bit, so everything that is made from them is the
// same.
TEST_F(TestFilterChains, OfPartsWithGlobalIdsAreThoseOfTheMesh)
{
  this->ExpectChains(*NumberedSphere(50), 200, 0);
}

// Without ids the order of points in the same place may differ, and so may the choice between two
// equally good edges.
TEST_F(TestFilterChains, OfPartsWithoutIdsAreThoseOfTheMesh)
{
  const PolyData sphere = MakeSphere(50);
  sphere->GetPointData()->Initialize();
  sphere->GetCellData()->Initialize();
  this->ExpectChains(*sphere, 200, 0.02);
}

TEST_F(TestFilterChains, StoreToPartitionsToLevelIsThatOfTheOneMesh)
{
  const PolyData sphere = MakeSphere(60);
  sphere->GetPointData()->Initialize();
  sphere->GetCellData()->Initialize();
  for (const int bits : { 0, 14 })
  {
    this->ExpectStoreChain(*sphere, bits, 100, 1000);
  }
}

TEST_F(TestFilterChains, TheDragon)
{
  if (!std::filesystem::exists(KDSTREAM_DRAGON))
  {
    GTEST_SKIP() << "Data/fetch-dragon fetches the dragon";
  }
  vtkNew<vtkKdMeshReader> reader;
  reader->SetFileName(KDSTREAM_DRAGON);
  reader->Update();
  for (const int bits : { 0, 20 })
  {
    this->ExpectStoreChain(*reader->GetOutput(), bits, 2000, 20000);
  }
}

}
