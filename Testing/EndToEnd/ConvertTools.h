// SPDX-License-Identifier: BSD-3-Clause
// Shared by the tests of foreign formats: a folder, the programs that run in it, and files of each
// format.
#pragma once

#include "Testing/EndToEnd/Process.h"
#include "Testing/Fixtures/Invariants.h"
#include "filters/adapter/PolyDataAttributes.h"
#include "filters/meshio/MeshReader.h"
#include "filters/meshio/MeshWriter.h"

#include <gtest/gtest.h>

#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <algorithm>
#include <cstring>
#include <set>
#include <string>
#include <vector>

namespace kdstream::fixtures
{

inline vtkSmartPointer<vtkPolyData> ToPolyData(const Mesh& mesh)
{
  auto output = vtkSmartPointer<vtkPolyData>::New();
  vtkNew<vtkPoints> points;
  points->SetDataType(mesh.scalarType == ScalarType::Float32 ? VTK_FLOAT : VTK_DOUBLE);
  for (const Vec3& p : mesh.points)
  {
    points->InsertNextPoint(p.data());
  }
  output->SetPoints(points);
  vtkNew<vtkCellArray> cells;
  for (const Triangle& t : mesh.triangles)
  {
    const vtkIdType ids[] = { t[0], t[1], t[2] };
    cells->InsertNextCell(3, ids);
  }
  output->SetPolys(cells);
  EXPECT_TRUE(WriteAttributes(mesh.attributes, *output));
  return output;
}

// The mesh with its coordinates rounded to floats, as PLY, STL, VRML and others store them.
inline Mesh AsFloats(Mesh mesh)
{
  for (Vec3& p : mesh.points)
  {
    for (double& v : p)
    {
      v = double(float(v));
    }
  }
  mesh.scalarType = ScalarType::Float32;
  return mesh;
}

// The places of the corners, triangle by triangle.
inline std::vector<std::array<Vec3, 3>> Soup(const Mesh& mesh)
{
  std::vector<std::array<Vec3, 3>> soup;
  for (const Triangle& t : mesh.triangles)
  {
    soup.push_back({ mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]] });
  }
  return soup;
}

inline const Attribute* Find(const Mesh& mesh, const std::string& name)
{
  const auto found = std::find_if(mesh.attributes.begin(), mesh.attributes.end(),
    [&](const Attribute& attribute) { return attribute.name == name; });
  return found == mesh.attributes.end() ? nullptr : &*found;
}

inline std::vector<double> ValuesOf(const Mesh& mesh, const std::string& name)
{
  std::vector<double> values;
  if (const Attribute* const attribute = Find(mesh, name))
  {
    for (std::size_t i = 0; i < attribute->TupleCount() * attribute->components; ++i)
    {
      values.push_back(attribute->Get(i / attribute->components, i % attribute->components));
    }
  }
  return values;
}

// Whether kdstream-convert reads VRML, which requires Coin in the build.
#ifdef KDSTREAM_HAS_COIN
inline constexpr bool hasVrml = true;
#else
inline constexpr bool hasVrml = false;
#endif

class ConvertTest : public ::testing::Test
{
protected:
  Outcome Convert(const std::string& input, std::vector<std::string> more = {})
  {
    more.insert(more.end(), { "--quiet", "-o", "out.ply", "--", input });
    return RunTool(this->Folder, "convert", more);
  }
  Outcome Build(std::vector<std::string> arguments)
  {
    return RunTool(this->Folder, "build", arguments);
  }

  void WriteText(const std::string& name, const std::string& text)
  {
    std::ofstream(this->Folder / name, std::ios::binary) << text;
  }

  Mesh Read(const std::string& name)
  {
    auto reader = MeshReader::Open(this->Folder / name);
    Mesh mesh;
    EXPECT_TRUE(reader) << reader.GetError().message;
    if (reader)
    {
      EXPECT_TRUE((*reader)->ReadVertices(mesh, ~std::size_t{ 0 }));
      EXPECT_TRUE((*reader)->ReadTriangles(mesh, ~std::size_t{ 0 }));
      mesh.scalarType = (*reader)->Info().scalarType;
    }
    return mesh;
  }

  // Converts a file with kdstream-convert, which must succeed and print exactly these warnings
  // (whole lines). Returns the resulting mesh.
  Mesh Converted(const std::string& input, const std::string& warnings = "")
  {
    std::filesystem::remove(this->Folder / "out.ply");
    const Outcome outcome = this->Convert(input);
    EXPECT_EQ(outcome.exitCode, 0) << input;
    EXPECT_EQ(outcome.err, warnings) << input;
    return outcome.exitCode == 0 ? this->Read("out.ply") : Mesh{};
  }

  // Expects exit code 1, one line that names the file and contains `what`, and no output.
  void ExpectError(const std::string& input, const std::string& what)
  {
    std::filesystem::remove(this->Folder / "out.ply");
    const Outcome outcome = this->Convert(input);
    EXPECT_EQ(outcome.exitCode, 1) << input;
    EXPECT_EQ(outcome.err.rfind("kdstream-convert: error: " + input + ": ", 0), 0U) << outcome.err;
    EXPECT_NE(outcome.err.find(what), std::string::npos) << outcome.err << "lacks: " << what;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(this->Folder / "out.ply"));
  }

  std::set<std::string> Files() const
  {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(this->Folder.Path))
    {
      names.insert(entry.path().filename().string());
    }
    return names;
  }

  TemporaryFolder Folder;
};

}
