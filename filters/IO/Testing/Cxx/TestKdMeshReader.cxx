// SPDX-License-Identifier: BSD-3-Clause
// Files as VTK gets them: strips, selected arrays, clouds, soups, and errors with their place.
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/adapter/Testing/FilterTools.h"

#include <gtest/gtest.h>
#include <vtkDataArraySelection.h>
#include <vtkErrorCode.h>
#include <vtkInformation.h>
#include <vtkInformationIdTypeKey.h>
#include <vtkInformationInformationVectorKey.h>
#include <vtkInformationIntegerKey.h>
#include <vtkInformationStringKey.h>
#include <vtkInformationVector.h>
#include <vtkKdMeshReader.h>
#include <vtkSTLWriter.h>

#include <filesystem>
#include <fstream>
#include <sstream>

namespace
{

using namespace kdstream::testing;
using kdstream::fixtures::TemporaryFolder;

class TestKdMeshReader : public ::testing::Test
{
protected:
  void Write(const std::string& name, const std::string& text)
  {
    this->File = this->Folder / name;
    std::ofstream(this->File, std::ios::binary) << text;
    this->Reader->SetFileName(this->File.c_str());
  }
  vtkPolyData& Read()
  {
    this->Reader->Update();
    return *this->Reader->GetOutput();
  }

  TemporaryFolder Folder;
  std::filesystem::path File;
  vtkNew<vtkKdMeshReader> Reader;
};

// VTK 9.1's own reader returns an empty mesh for such files.
TEST_F(TestKdMeshReader, StripsBecomeTriangles)
{
  this->Write("strip.ply",
    "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n"
    "property float z\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n"
    "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n5 0 1 2 3 4\n");
  vtkPolyData& mesh = this->Read();
  ASSERT_EQ(mesh.GetNumberOfPolys(), 3);
  EXPECT_EQ(CellPoints(mesh, 0), (Ids{ 0, 1, 2 }));
  EXPECT_EQ(CellPoints(mesh, 1), (Ids{ 2, 1, 3 }));
  EXPECT_EQ(mesh.GetPoints()->GetDataType(), VTK_FLOAT);
}

TEST_F(TestKdMeshReader, ArraysCanBeChosen)
{
  this->Write("arrays.ply",
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\n"
    "property double z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
    "property float quality\nelement face 1\nproperty list uchar int vertex_indices\n"
    "property int label\nend_header\n0 0 0 1 2 3 0.5\n1 0 0 4 5 6 1.5\n1 1 0 7 8 9 2.5\n"
    "0 1 0 10 11 12 3.5\n4 0 1 2 3 77\n");
  this->Reader->UpdateInformation();
  vtkDataArraySelection* const points = this->Reader->GetPointDataArraySelection();
  EXPECT_EQ(points->GetNumberOfArrays(), 2);
  EXPECT_EQ(this->Reader->GetCellDataArraySelection()->GetNumberOfArrays(), 1);
  vtkPolyData& mesh = this->Read();
  EXPECT_EQ(mesh.GetPoints()->GetDataType(), VTK_DOUBLE);
  ASSERT_EQ(mesh.GetNumberOfPolys(), 2);
  ASSERT_NE(mesh.GetPointData()->GetScalars(), nullptr);
  EXPECT_STREQ(mesh.GetPointData()->GetScalars()->GetName(), "RGB");
  EXPECT_EQ(mesh.GetPointData()->GetScalars()->GetComponent(3, 2), 12);
  EXPECT_EQ(mesh.GetPointData()->GetArray("quality")->GetComponent(2, 0), 2.5);
  ASSERT_NE(mesh.GetCellData()->GetArray("label"), nullptr);
  EXPECT_EQ(mesh.GetCellData()->GetArray("label")->GetComponent(1, 0), 77);
  points->DisableArray("RGB");
  this->Reader->GetCellDataArraySelection()->DisableAllArrays();
  vtkPolyData& fewer = this->Read();
  EXPECT_EQ(fewer.GetPointData()->GetNumberOfArrays(), 1);
  EXPECT_EQ(fewer.GetCellData()->GetNumberOfArrays(), 0);
  EXPECT_EQ(fewer.GetNumberOfPolys(), 2);
}

TEST_F(TestKdMeshReader, TheHeaderIsReportedBeforeFacesAreRead)
{
  this->Write("arrays.ply",
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
    "property double heat\nelement face 2\nproperty list uchar int vertex_indices\n"
    "property int label\nend_header\n0 0 0 1 2 3 0\n1 0 0 4 5 6 0\n1 1 0 7 8 9 0\n0 1 0 1 1 1 0\n"
    "faces are not looked at"); // colours are needed, to find out what is white
  this->Reader->UpdateInformation();
  EXPECT_EQ(this->Reader->GetErrorCode(), vtkErrorCode::NoError);
  vtkInformation* const info = this->Reader->GetOutputInformation(0);
  EXPECT_EQ(info->Get(vtkKdMeshReader::NUMBER_OF_POINTS()), 4);
  EXPECT_EQ(info->Get(vtkKdMeshReader::NUMBER_OF_CELLS()), 2);
  const auto reported = [info](vtkInformationInformationVectorKey* key)
  {
    std::ostringstream text;
    vtkInformationVector* const arrays = info->Get(key);
    for (int i = 0; arrays && i < arrays->GetNumberOfInformationObjects(); ++i)
    {
      vtkInformation* const array = arrays->GetInformationObject(i);
      text << array->Get(vtkDataObject::FIELD_NAME()) << " "
           << array->Get(vtkDataObject::FIELD_ARRAY_TYPE()) << " "
           << array->Get(vtkDataObject::FIELD_NUMBER_OF_COMPONENTS()) << " "
           << array->Get(vtkDataObject::FIELD_NUMBER_OF_TUPLES()) << "; ";
    }
    return text.str();
  };
  EXPECT_EQ(reported(vtkDataObject::POINT_DATA_VECTOR()), "RGB 3 3 4; heat 11 1 4; ");
  EXPECT_EQ(reported(vtkDataObject::CELL_DATA_VECTOR()), "label 6 1 0; ");
  this->Reader->GetPointDataArraySelection()->DisableArray("RGB");
  this->Reader->UpdateInformation();
  EXPECT_EQ(reported(vtkDataObject::POINT_DATA_VECTOR()), "heat 11 1 4; ");

  // After a change of the file, the old file's arrays and numbers of merged points are not
  // reported.
  this->Write("triangle.stl",
    "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
    "endloop\nendfacet\nendsolid\n");
  this->Reader->UpdateInformation();
  EXPECT_FALSE(info->Has(vtkKdMeshReader::NUMBER_OF_POINTS()));
  EXPECT_EQ(info->Get(vtkKdMeshReader::NUMBER_OF_CELLS()), 1);
  EXPECT_EQ(reported(vtkDataObject::POINT_DATA_VECTOR()), "");
  this->Reader->MergingOff();
  this->Reader->UpdateInformation();
  EXPECT_EQ(info->Get(vtkKdMeshReader::NUMBER_OF_POINTS()), 3);
  this->Write("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 2 2 2\n");
  this->Reader->UpdateInformation();
  EXPECT_EQ(info->Get(vtkKdMeshReader::NUMBER_OF_POINTS()), 5);
  EXPECT_EQ(info->Get(vtkKdMeshReader::NUMBER_OF_CELLS()), 5) << "of a cloud, its points";
  this->Reader->SetFileName((this->Folder / "none.ply").c_str());
  FilterObserver heard(this->Reader);
  this->Reader->UpdateInformation();
  EXPECT_FALSE(info->Has(vtkKdMeshReader::NUMBER_OF_CELLS()));
}

TEST_F(TestKdMeshReader, SelectionsFollowTheFile)
{
  const auto write = [this](const std::string& name, const std::string& properties)
  {
    this->Write(
      name, "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
            "property float z\n" +
              properties + "end_header\n0 0 0 1 2\n");
  };
  write("first.ply", "property float heat\nproperty float age\n");
  this->Reader->UpdateInformation();
  vtkDataArraySelection* const points = this->Reader->GetPointDataArraySelection();
  points->DisableArray("heat");
  write("second.ply", "property float heat\nproperty float depth\n");
  vtkPolyData& mesh = this->Read();
  EXPECT_EQ(points->GetNumberOfArrays(), 2);
  EXPECT_FALSE(points->ArrayExists("age"));
  EXPECT_FALSE(points->ArrayIsEnabled("heat")) << "what was chosen stays";
  EXPECT_TRUE(points->ArrayIsEnabled("depth"));
  EXPECT_EQ(mesh.GetPointData()->GetNumberOfArrays(), 1);
  EXPECT_TRUE(mesh.GetPointData()->HasArray("depth"));
}

TEST_F(TestKdMeshReader, ReportsWhatItCanRead)
{
  FilterObserver heard(this->Reader);
  this->Write("cloud.ply",
    "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
    "property float z\nend_header\n0 0 0\n");
  EXPECT_EQ(this->Reader->CanReadFile(this->File.c_str()), 1);
  this->Write("words.ply", "no mesh");
  EXPECT_EQ(this->Reader->CanReadFile(this->File.c_str()), 0);
  this->Write("picture.png", "no mesh");
  EXPECT_EQ(this->Reader->CanReadFile(this->File.c_str()), 0);
  EXPECT_EQ(this->Reader->CanReadFile("/nonexistent.ply"), 0);
  EXPECT_EQ(this->Reader->CanReadFile(nullptr), 0);
  EXPECT_EQ(heard.error + heard.warning, "");
}

TEST_F(TestKdMeshReader, PointsWithoutCellsBecomeCells)
{
  this->Write("cloud.ply",
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
    "property float z\nend_header\n0 0 0\n1 0 0\n0 1 0\n");
  vtkPolyData& cloud = this->Read();
  EXPECT_EQ(cloud.GetNumberOfVerts(), 3);
  EXPECT_EQ(cloud.GetNumberOfCells(), 3);
  EXPECT_EQ(CellPoints(cloud, 2), Ids{ 2 });
}

TEST_F(TestKdMeshReader, PointsOfSoupsAreMerged)
{
  const PolyData sphere = MakePlate(9);
  vtkNew<vtkSTLWriter> writer;
  this->File = this->Folder / "plate.stl";
  writer->SetInputData(sphere);
  writer->SetFileTypeToBinary();
  writer->SetFileName(this->File.c_str());
  writer->Write();
  this->Reader->SetFileName(this->File.c_str());
  EXPECT_EQ(this->Read().GetNumberOfPoints(), 81);
  EXPECT_EQ(this->Reader->GetOutput()->GetNumberOfPolys(), 128);
  this->Reader->MergingOff();
  EXPECT_EQ(this->Read().GetNumberOfPoints(), 3 * 128);
}

TEST_F(TestKdMeshReader, WhatIsDroppedIsAWarning)
{
  this->Write("nan.ply",
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    "property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 nan\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2\n3 1 3 2\n");
  FilterObserver heard(this->Reader);
  EXPECT_EQ(this->Read().GetNumberOfPoints(), 3);
  EXPECT_EQ(this->Reader->GetOutput()->GetNumberOfPolys(), 1);
  EXPECT_EQ(heard.error, "");
  EXPECT_NE(heard.warning.find("nan.ply: 1 point is not finite and is dropped: vertex 0"),
    std::string::npos)
    << heard.warning;
}

TEST_F(TestKdMeshReader, ErrorsNameFileAndPlace)
{
  const std::string head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                           "property float y\nproperty float z\nelement face 1\n"
                           "property list uchar int vertex_indices\nend_header\n";
  const std::vector<std::pair<std::string, std::string>> cases{
    { head + "0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n", "face 0" },
    { head + "0 0 0\n1 0 0\n", "vertex 2" },
    { "nonsense", "ply" },
  };
  for (const auto& [text, what] : cases)
  {
    this->Write("bad.ply", text);
    FilterObserver heard(this->Reader);
    EXPECT_EQ(this->Read().GetNumberOfPoints(), 0);
    EXPECT_NE(heard.error.find("bad.ply: "), std::string::npos) << heard.error;
    EXPECT_NE(heard.error.find(what), std::string::npos) << heard.error;
    EXPECT_EQ(this->Reader->GetErrorCode(), vtkErrorCode::FileFormatError);
    this->Reader->Modified();
  }
  this->Reader->SetFileName((this->Folder / "none.ply").c_str());
  FilterObserver heard(this->Reader);
  this->Reader->Update();
  EXPECT_NE(heard.error.find("none.ply: "), std::string::npos) << heard.error;
  EXPECT_EQ(this->Reader->GetErrorCode(), vtkErrorCode::FileNotFoundError);
  heard.error.clear();
  this->Reader->SetFileName(nullptr);
  this->Reader->UpdateInformation();
  EXPECT_EQ(heard.error, "") << "before a file is chosen";
  this->Reader->Update();
  EXPECT_NE(heard.error.find("): no FileName is set"), std::string::npos) << heard.error;
  EXPECT_EQ(this->Reader->GetErrorCode(), vtkErrorCode::NoFileNameError);
}

TEST_F(TestKdMeshReader, ReportsProgressAndStopsWhenAborted)
{
  std::string text = "ply\nformat ascii 1.0\nelement vertex 300000\nproperty float x\n"
                     "property float y\nproperty float z\nend_header\n";
  for (int i = 0; i < 300000; ++i)
  {
    text += std::to_string(i) + " 0 0\n";
  }
  this->Write("long.ply", text);
  {
    FilterObserver heard(this->Reader);
    EXPECT_EQ(this->Read().GetNumberOfPoints(), 300000);
    EXPECT_GT(heard.progress.size(), 2u);
    EXPECT_TRUE(std::is_sorted(heard.progress.begin(), heard.progress.end()));
  }
  FilterObserver heard(this->Reader);
  heard.abortAt = 0.1;
  this->Reader->Modified();
  EXPECT_EQ(this->Read().GetNumberOfPoints(), 0);
  EXPECT_EQ(heard.error, "");
}

}
