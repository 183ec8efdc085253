// SPDX-License-Identifier: BSD-3-Clause
// Stores of what a pipeline gives: equal to the store of the mesh itself, also if it is
// partitioned.
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/adapter/Testing/FilterTools.h"
#include "filters/store/Store.h"
#include "filters/store/StoreMesh.h"

#include <gtest/gtest.h>
#include <vtkErrorCode.h>
#include <vtkImageData.h>
#include <vtkKdMeshReader.h>
#include <vtkKdStoreWriter.h>
#include <vtkKdTreePartition.h>
#include <vtkPartitionedDataSet.h>
#include <vtkStringArray.h>

#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <limits>
#include <numeric>

namespace
{

using namespace kdstream;
using namespace kdstream::testing;
using kdstream::fixtures::TemporaryFolder;

// Each triangle by the positions of its corners, the lowest first; sorted. So the numbering of
// points does not matter.
std::vector<std::array<Vec3, 3>> Shape(const Mesh& mesh)
{
  std::vector<std::array<Vec3, 3>> shape;
  for (const Triangle& t : mesh.triangles)
  {
    std::array<Vec3, 3> corners{ mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]] };
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    shape.push_back(corners);
  }
  std::sort(shape.begin(), shape.end());
  return shape;
}

class TestKdStoreWriter : public ::testing::Test
{
protected:
  void SetUp() override
  {
    this->Writer->SetFileName(this->File.c_str());
    this->Writer->SetGridBits(0);
    this->Writer->SetVerticesPerPartition(100);
  }
  std::shared_ptr<Store> Written()
  {
    EXPECT_EQ(this->Writer->Write(), 1);
    auto store = Store::Open(this->File);
    EXPECT_TRUE(store) << store.GetError().message;
    return store ? *store : nullptr;
  }
  static Mesh Whole(const Store& store)
  {
    std::vector<std::uint32_t> all(store.Info().partitions);
    std::iota(all.begin(), all.end(), 0u);
    return *GlueStoreMesh(store, all);
  }

  TemporaryFolder Folder;
  const std::filesystem::path File = this->Folder / "model.kds";
  vtkNew<vtkKdStoreWriter> Writer;
};

TEST_F(TestKdStoreWriter, AStoreHoldsTheMeshWithItsArrays)
{
  const PolyData sphere = MakeSphere(60);
  this->Writer->SetInputData(sphere);
  this->Writer->SetTitle("A sphere");
  this->Writer->SetUnit("mm");
  this->Writer->SetUp(0, 0, 2);
  const auto store = this->Written();
  ASSERT_TRUE(store);
  EXPECT_TRUE(store->Verify().empty());
  EXPECT_EQ(store->Info().title, "A sphere");
  EXPECT_EQ(store->Info().unit, "mm");
  EXPECT_EQ(store->Info().homeView->up, (Vec3{ 0, 0, 1 }));
  EXPECT_EQ(store->Info().triangles, static_cast<std::uint64_t>(sphere->GetNumberOfPolys()));
  EXPECT_TRUE(store->Info().HasLevels());
  ASSERT_EQ(store->Info().attributes.size(), 2u);
  EXPECT_EQ(store->Info().attributes[0].name, "Point");
  EXPECT_EQ(store->Info().attributes[1].name, "Cell");
  // The arrays give each point another number, so no points are welded.
  EXPECT_EQ(store->Info().vertices, static_cast<std::uint64_t>(sphere->GetNumberOfPoints()));
}

TEST_F(TestKdStoreWriter, PartitionsMakeTheStoreOfTheWholeMesh)
{
  const PolyData sphere = MakeSphere(60);
  sphere->GetPointData()->Initialize();
  sphere->GetCellData()->Initialize();
  this->Writer->SetInputData(sphere);
  const auto whole = this->Written();
  ASSERT_TRUE(whole);
  const auto shape = Shape(Whole(*whole));
  const auto vertices = whole->Info().vertices;

  vtkNew<vtkKdTreePartition> partition;
  partition->SetInputData(sphere);
  partition->SetVerticesPerPartition(200);
  this->Writer->SetInputConnection(partition->GetOutputPort());
  FilterObserver heard(this->Writer);
  const auto store = this->Written();
  ASSERT_TRUE(store);
  EXPECT_EQ(heard.warning, "") << "its own ghosts are no news";
  EXPECT_GT(partition->GetOutput()->GetNumberOfPartitions(), 8u);
  EXPECT_EQ(store->Info().vertices, vertices);
  EXPECT_EQ(store->Info().triangles, static_cast<std::uint64_t>(sphere->GetNumberOfPolys()));
  EXPECT_EQ(Shape(Whole(*store)), shape);
}

TEST_F(TestKdStoreWriter, ArraysThatSomePartsLackAreLeftOutWithAWarning)
{
  vtkNew<vtkPartitionedDataSet> parts;
  parts->SetNumberOfPartitions(3); // the first is null
  const PolyData first = MakePlate(5), second = MakePlate(6);
  second->GetPointData()->RemoveArray("Point");
  vtkNew<vtkStringArray> words;
  words->SetName("Words");
  words->SetNumberOfValues(first->GetNumberOfCells());
  first->GetCellData()->AddArray(words);
  parts->SetPartition(1, first);
  parts->SetPartition(2, second);
  this->Writer->SetInputData(parts);
  this->Writer->WeldOff();
  FilterObserver heard(this->Writer);
  const auto store = this->Written();
  ASSERT_TRUE(store);
  EXPECT_EQ(store->Info().vertices, 25u + 36u);
  ASSERT_EQ(store->Info().attributes.size(), 1u);
  EXPECT_EQ(store->Info().attributes[0].name, "Cell");
  EXPECT_NE(heard.warning.find("\"Point\": not all parts have it"), std::string::npos)
    << heard.warning;
  EXPECT_NE(heard.warning.find("\"Words\": not all parts have it"), std::string::npos)
    << heard.warning;
}

TEST_F(TestKdStoreWriter, OnePointIsAModel)
{
  this->Writer->SetInputData(MakePoints({ { 1, 2, 3 } }));
  const auto store = this->Written();
  ASSERT_TRUE(store);
  EXPECT_EQ(store->Info().vertices, 1u);
  EXPECT_EQ(store->Info().primitive, PrimitiveType::Points);
}

TEST_F(TestKdStoreWriter, WhatCannotBeWrittenIsAnErrorAndNoFile)
{
  const double nan = std::numeric_limits<double>::quiet_NaN();
  vtkNew<vtkPartitionedDataSet> images;
  images->SetNumberOfPartitions(1);
  vtkNew<vtkImageData> image;
  image->SetDimensions(2, 2, 2);
  images->SetPartition(0, image);
  const PolyData offsets = MakePlate(3);
  offsets->SetPolys(MakeCells({ 0, 1000000 }, { 0, 1, 2 }));
  const std::vector<std::pair<vtkSmartPointer<vtkDataObject>, std::string>> cases{
    { MakePoints({}), "no vertices" },
    { MakePoints({ { 0, 0, 0 }, { nan, 0, 0 } }), "point 1: a coordinate is not finite" },
    { offsets, "cell 0 uses corners 0 to 1000000 of a list of 3" },
    { images.Get(), "partition 0 is a vtkImageData" },
  };
  for (const auto& [input, what] : cases)
  {
    FilterObserver heard(this->Writer);
    this->Writer->SetInputData(input);
    EXPECT_EQ(this->Writer->Write(), 0);
    EXPECT_NE(heard.error.find("model.kds: "), std::string::npos) << heard.error;
    EXPECT_NE(heard.error.find(what), std::string::npos) << heard.error;
    EXPECT_FALSE(std::filesystem::exists(this->File));
    EXPECT_EQ(this->Writer->GetErrorCode(), static_cast<unsigned long>(vtkErrorCode::UnknownError));
  }
  FilterObserver heard(this->Writer);
  this->Writer->SetInputData(MakePlate(4));
  this->Writer->SetFileName("/nonexistent/model.kds");
  EXPECT_EQ(this->Writer->Write(), 0);
  EXPECT_NE(heard.error.find("/nonexistent/model.kds"), std::string::npos) << heard.error;
  EXPECT_EQ(
    this->Writer->GetErrorCode(), static_cast<unsigned long>(vtkErrorCode::CannotOpenFileError));
  heard.error.clear();
  this->Writer->SetFileName(nullptr);
  EXPECT_EQ(this->Writer->Write(), 0);
  EXPECT_NE(heard.error.find("no FileName is set"), std::string::npos) << heard.error;
  EXPECT_EQ(
    this->Writer->GetErrorCode(), static_cast<unsigned long>(vtkErrorCode::NoFileNameError));
  this->Writer->SetFileName(this->File.c_str());
  EXPECT_TRUE(this->Written());
  EXPECT_EQ(this->Writer->GetErrorCode(), static_cast<unsigned long>(vtkErrorCode::NoError));
}

// The algorithm before the writer has failed, so Write must not return success.
TEST_F(TestKdStoreWriter, AnInputThatCouldNotBeMadeIsAnError)
{
  vtkNew<vtkKdMeshReader> reader;
  reader->SetFileName("/nonexistent/mesh.ply");
  FilterObserver unheard(reader);
  this->Writer->SetInputConnection(reader->GetOutputPort());
  for (int time = 0; time < 2; ++time)
  {
    FilterObserver heard(this->Writer);
    EXPECT_EQ(this->Writer->Write(), 0);
    EXPECT_NE(heard.error.find("model.kds: "), std::string::npos) << heard.error;
    EXPECT_NE(this->Writer->GetErrorCode(), static_cast<unsigned long>(vtkErrorCode::NoError));
    EXPECT_FALSE(std::filesystem::exists(this->File));
  }
  this->Writer->SetInputData(MakePlate(4));
  EXPECT_TRUE(this->Written());
}

TEST_F(TestKdStoreWriter, AFullDiskIsReportedByItsCode)
{
  this->Writer->SetInputData(MakeSphere(100));
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto oldHandler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{ 50000, before.rlim_max };
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  FilterObserver heard(this->Writer);
  EXPECT_EQ(this->Writer->Write(), 0);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, oldHandler);
  EXPECT_EQ(
    this->Writer->GetErrorCode(), static_cast<unsigned long>(vtkErrorCode::OutOfDiskSpaceError));
  EXPECT_NE(heard.error.find("files cannot grow this large here"), std::string::npos)
    << heard.error;
  EXPECT_TRUE(std::filesystem::is_empty(this->Folder.Path));
}

TEST_F(TestKdStoreWriter, SizesBelowZeroAreRefused)
{
  EXPECT_EQ(this->Writer->GetMaker(), vtkKdStoreWriter::Collapse);
  EXPECT_STREQ(this->Writer->GetMakerAsString(), "Collapse");
  FilterObserver heard(this->Writer);
  this->Writer->SetGridBits(-1);
  this->Writer->SetCellVertices(-8);
  EXPECT_NE(heard.error.find("GridBits must be 0 or from 8 to 24"), std::string::npos);
  EXPECT_NE(heard.error.find("CellVertices must be from 1 to 1024"), std::string::npos);
  EXPECT_EQ(this->Writer->GetGridBits(), 0);
  EXPECT_EQ(this->Writer->GetCellVertices(), 8);
}

TEST_F(TestKdStoreWriter, DirectionsThatAreNotFiniteAreRefused)
{
  using Class = vtkKdStoreWriter;
  EXPECT_EQ(NotFiniteTakenBy<Class>(*this->Writer, "Up", &Class::SetUp, &Class::GetUp), "");
  EXPECT_EQ(NotFiniteTakenBy<Class>(*this->Writer, "View", &Class::SetView, &Class::GetView), "");
}

TEST_F(TestKdStoreWriter, ReportsProgressAndStopsWhenAborted)
{
  this->Writer->SetInputData(MakeSphere(150));
  {
    FilterObserver heard(this->Writer);
    ASSERT_TRUE(this->Written());
    EXPECT_GT(heard.progress.size(), 4u);
  }
  std::filesystem::remove(this->File);
  FilterObserver heard(this->Writer);
  heard.abortAt = 0.3;
  EXPECT_EQ(this->Writer->Write(), 0);
  EXPECT_EQ(heard.error, "");
  EXPECT_TRUE(std::filesystem::is_empty(this->Folder.Path));
}

}
