// SPDX-License-Identifier: BSD-3-Clause
// kdstream-convert reports data that a file's reader has lost, left out, or interpreted: it neither
// invents nor drops anything silently.
#include "Testing/EndToEnd/ConvertTools.h"
#include "Testing/EndToEnd/GltfFile.h"
#include "Testing/Fixtures/Meshes.h"

#include <vtkPolyDataWriter.h>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

class TestConvertWarnings : public ConvertTest
{
protected:
  static std::string Warning(const std::string& file, const std::string& text)
  {
    return "kdstream-convert: warning: " + file + ": " + text + "\n";
  }
};

}

TEST_F(TestConvertWarnings, CutLegacyFilesAreErrors)
{
  for (const bool ascii : { true, false })
  {
    vtkNew<vtkPolyDataWriter> writer;
    writer->SetInputData(ToPolyData(AsFloats(DisplacedSphere(3))));
    writer->SetFileName((this->Folder / "whole.vtk").c_str());
    writer->SetFileType(ascii ? VTK_ASCII : VTK_BINARY);
    writer->Write();
    const std::string whole = ReadWhole(this->Folder / "whole.vtk");
    for (const std::size_t percent : { 20, 40, 60, 80, 95 })
    {
      SCOPED_TRACE(std::string(ascii ? "ascii " : "binary ") + std::to_string(percent));
      this->WriteText("in.vtk", whole.substr(0, whole.size() * percent / 100));
      this->ExpectError("in.vtk", " numbers, then "); // the message names the part and the number
    }
  }
}

TEST_F(TestConvertWarnings, HarmlessWarningsOfVtkStayWarnings)
{
  this->WriteText("in.vtk",
    "# vtk DataFile Version 9.9\nt\nASCII\nDATASET POLYDATA\n"
    "POINTS 3 float\n0 0 0 1 0 0 0 1 0\nPOLYGONS 2 3\nOFFSETS vtktypeint64\n0 3\n"
    "CONNECTIVITY vtktypeint64\n0 1 2\n");
  const Outcome outcome = this->Convert("in.vtk");
  EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
  EXPECT_EQ(outcome.err.rfind("kdstream-convert: warning: in.vtk: ", 0), 0U) << outcome.err;
  EXPECT_EQ(this->Read("out.ply").triangles.size(), 1U);
}

TEST_F(TestConvertWarnings, CoarseFloatsAreSaid)
{
  // Readers of other formats keep doubles.
  this->WriteText("far.stl", "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 4000000.4565 0\n"
                             "vertex 10 4000000 0\nvertex 0 4000010 0\nendloop\nendfacet\n"
                             "endsolid s\n");
  EXPECT_EQ(this->Converted("far.stl").points[0][1], 4000000.4565);
  this->WriteText("far.obj", "v 0 4000000.4565 0\nv 10 4000000 0\nv 0 4000010 0\nf 1 2 3\n");
  EXPECT_EQ(this->Converted("far.obj").points[0][1], 4000000.4565);
}

TEST_F(TestConvertWarnings, StlOfACloudIsRefused)
{
  this->WriteText("in.xyz", "0 0 0.123456789 7\n1 0 0 8\n0 1 0 9\n");
  const Outcome outcome =
    RunTool(this->Folder, "convert", { "--quiet", "in.xyz", "-o", "out.stl" });
  EXPECT_EQ(outcome.exitCode, 2);
  EXPECT_EQ(outcome.err.rfind("kdstream-convert: error: out.stl: ", 0), 0U) << outcome.err;
  EXPECT_EQ(this->Files(), (std::set<std::string>{ "in.xyz" }));
  this->WriteText("in.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_EQ(RunTool(this->Folder, "convert", { "--quiet", "in.obj", "-o", "out.stl" }).err, "");
}

TEST_F(TestConvertWarnings, LinesAndVerticesThatAreLeftOutAreSaid)
{
  const std::string points = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\n"
                             "POINTS 4 float\n0 0 0 1 0 0 0 1 0 1 1 0\n";
  const std::string vertices = "VERTICES 3 6\n1 0\n1 1\n1 2\n",
                    lines = "LINES 2 7\n3 0 1 2\n2 2 3\n", polygons = "POLYGONS 1 4\n3 0 1 2\n";
  const struct
  {
    std::string cells, warning;
    std::size_t triangles;
  } cases[] = {
    { vertices, "", 0 },
    { polygons, "", 1 },
    { lines, "left out: 2 line cells; their points stay", 0 },
    { vertices + lines, "left out: 2 line cells; their points stay", 0 },
    { lines + polygons, "left out: 2 line cells; their points stay", 1 },
    { "VERTICES 1 2\n1 3\n" + polygons, "left out: 1 vertex cell; their points stay", 1 },
    { vertices + lines + polygons, "left out: 2 line cells and 3 vertex cells; their points stay",
      1 },
  };
  for (const auto& c : cases)
  {
    SCOPED_TRACE(c.cells);
    this->WriteText("in.vtk", points + c.cells);
    const Mesh read =
      this->Converted("in.vtk", c.warning.empty() ? "" : Warning("in.vtk", c.warning));
    EXPECT_EQ(read.points.size(), 4U);
    EXPECT_EQ(read.triangles.size(), c.triangles);
  }
}

TEST_F(TestConvertWarnings, MissingBuffersOfGltfAreNamed)
{
  GltfBuffer buffer;
  buffer.Add(std::vector<float>{ 0, 0, 0, 1, 0, 0, 0, 1, 0 }, "VEC3", gltfFloat,
    ",\"min\":[0,0,0],\"max\":[1,1,0]");
  const std::string scene =
    buffer.Json("\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],"
                "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]",
      "buffer.bin");
  std::filesystem::create_directory(this->Folder / "sub");
  for (const char* file : { "in.gltf", "sub/in.gltf" })
  {
    this->WriteText(file, scene);
    this->ExpectError(file, "the file 'buffer.bin', in which its geometry is, is not there");
  }
  this->WriteText("buffer.bin", buffer.Bytes.substr(0, 20));
  this->ExpectError("in.gltf", "bytes of the file 'buffer.bin'; it has 20");
  this->WriteText("buffer.bin", buffer.Bytes);
  EXPECT_EQ(this->Converted("in.gltf").points.size(), 3U);
  this->ExpectError("sub/in.gltf", "is not there");
  std::string escaped = scene;
  escaped.replace(escaped.find("buffer.bin"), 10, "a%20b.bin");
  this->WriteText("in.gltf", escaped);
  this->ExpectError("in.gltf", "the file 'a%20b.bin', in which its geometry is, is not there: put "
                               "it into the folder of the glTF, under this name\n");
  this->WriteText("a b.bin", buffer.Bytes);
  EXPECT_EQ(this->Converted("in.gltf").points.size(), 3U);
  escaped.replace(escaped.find("a%20b.bin"), 9, "%2e%2e/a%20b.bin");
  this->WriteText("sub/in.gltf", escaped);
  this->ExpectError("sub/in.gltf", "lies outside the mesh's folder, and nothing is read there");
}

TEST_F(TestConvertWarnings, ColumnsOfXyzAreTakenForWhatTheyAre)
{
  const auto read = [&](const std::string& text, const std::string& warning = "")
  {
    this->WriteText("in.xyz", text);
    return this->Converted("in.xyz", warning.empty() ? "" : Warning("in.xyz", warning));
  };
  const Mesh plain = read("0 0 0 300.5 12 7\n1 0 0 1 2 -3\n",
    "not all columns are colours or normals: kept as numbers are column4, column5, column6 "
    "(--columns names them)");
  EXPECT_EQ(ValuesOf(plain, "column4"), (std::vector{ 300.5, 1.0 }));
  EXPECT_EQ(ValuesOf(plain, "column5"), (std::vector{ 12.0, 2.0 }));
  EXPECT_EQ(ValuesOf(plain, "column6"), (std::vector{ 7.0, -3.0 }));
  EXPECT_EQ(plain.attributes.size(), 3U);
  const Mesh behindColors = read("0 0 0 255 0 7 30 0 1\n",
    "the columns are read as \"x y z r g b column7 column8 column9\"; they could be \"x y z "
    "column4 column5 column6 r g b\" too (--columns decides)");
  EXPECT_EQ(ValuesOf(behindColors, "RGB"), (std::vector<double>{ 255, 0, 7 }));
  EXPECT_EQ(ValuesOf(behindColors, "column7"), (std::vector{ 30.0 }));
  // At some points a scan has no normal. The colour black must not be taken for a normal.
  EXPECT_EQ(ValuesOf(read("0 0 0 0 0.6 0.8\n1 0 0 0 0 0\n"), "Normals"),
    (std::vector<double>{ 0, double(0.6F), double(0.8F), 0, 0, 0 }));
  EXPECT_EQ(ValuesOf(read("0 0 0 0 0 0\n"), "RGB"), (std::vector<double>{ 0, 0, 0 }));
  const Mesh either =
    read("0 0 0 0 0 1\n", "the columns are read as \"x y z nx ny nz\"; they could be \"x y z r g "
                          "b\" too (--columns decides)");
  EXPECT_EQ(ValuesOf(either, "Normals"), (std::vector<double>{ 0, 0, 1 }));
}
