// SPDX-License-Identifier: BSD-3-Clause
// Shared by the tests of foreign formats: a folder, the programs that run in it, and files of each
// format.
#pragma once

#include "Testing/EndToEnd/ProgramsTest.h"
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

class ConvertTest : public ProgramsTest
{
protected:
  Outcome Convert(const std::string& input, std::vector<std::string> more = {})
  {
    more.insert(more.end(), { "--quiet", "-o", "out.ply", "--", input });
    return RunTool(this->Folder, "convert", more);
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

  // Expects exit code 1 with one line that names the file, or 0 if the file may be read.
  void ExpectRefusedOrRead(const std::string& input, bool mayBeRead, const std::string& what)
  {
    SCOPED_TRACE(what);
    std::filesystem::remove(this->Folder / "out.ply");
    const Outcome outcome = this->Convert(input);
    EXPECT_TRUE(outcome.exitCode == 1 || (mayBeRead && outcome.exitCode == 0))
      << outcome.exitCode << " " << outcome.err;
    EXPECT_LE(outcome.peakBytes, std::uint64_t{ 200 } << 20);
    if (outcome.exitCode == 1)
    {
      EXPECT_EQ(outcome.err.rfind("kdstream-convert: error: " + input + ": ", 0), 0U)
        << outcome.err;
      EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    }
  }
};

}
