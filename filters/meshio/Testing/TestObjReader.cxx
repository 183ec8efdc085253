// SPDX-License-Identifier: BSD-3-Clause
// The OBJ reader: random meshes in every notation are read back exactly, with any chunk size.
// Handwritten files test what random ones do not reach. Every error names its place.
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/meshio/MeshWriter.h"
#include "filters/meshio/ObjStatements.h"
#include "filters/meshio/Testing/RandomObj.h"
#include "filters/meshio/Testing/ReadAll.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kdstream::test
{

namespace
{

Contents ReadBytes(std::string_view bytes)
{
  const fixtures::TemporaryFolder folder;
  return ReadAll(folder.Write("bytes.obj", bytes), [] { return everything; });
}

void ExpectError(
  std::string_view bytes, std::string_view place = {}, ErrorCode code = ErrorCode::InvalidInput)
{
  EXPECT_TRUE(fixtures::FailsAt(ReadBytes(bytes).status, code, place));
}

const std::string threePlaces = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

}

TEST(ObjReader, ReadsRandomFilesBack)
{
  for (unsigned seed = 0; seed < 600; ++seed)
  {
    ExpectReadBack<RandomObjMaker>("random.obj", seed, 12, 7);
  }
}

// The file has several blocks, and more further vertices and tables than fit into memory.
TEST(ObjReader, ReadsLargeFilesBack)
{
  for (unsigned seed = 600; seed < 612; ++seed)
  {
    ExpectReadBack<RandomObjMaker>("random.obj", seed, 60000, 9000);
  }
}

TEST(ObjReader, ReadsWhatTheWriterWrites)
{
  for (const ScalarType type : { ScalarType::Float32, ScalarType::Float64 })
  {
    Mesh mesh;
    mesh.scalarType = type;
    RandomGenerator generator(5);
    for (int i = 0; i < 1000; ++i)
    {
      Vec3 point{};
      for (double& value : point)
      {
        value = type == ScalarType::Float32 ? double(generator.AnyReal<float>())
                                            : generator.AnyReal<double>();
      }
      mesh.points.push_back(point);
      mesh.triangles.push_back(
        { VertexId(generator.Pick(1000)), VertexId(generator.Pick(1000)), 7 });
    }
    const fixtures::TemporaryFolder folder;
    ASSERT_TRUE(WriteMesh(folder / "m.obj", mesh));
    const Contents read = ReadAll(folder / "m.obj", [] { return std::size_t{ 17 }; });
    ASSERT_TRUE(read.status);
    EXPECT_EQ(read.info.scalarType, type);
    EXPECT_TRUE(SameBits(read.mesh.points, mesh.points));
    EXPECT_EQ(read.mesh.triangles, mesh.triangles);
  }
}

TEST(ObjReader, FacesMayComeFirst)
{
  const Contents read = ReadBytes("f 1 2 3\nf 3 2 1\n" + threePlaces);
  ASSERT_TRUE(read.status);
  EXPECT_EQ(read.mesh.triangles, (std::vector<Triangle>{ { 0, 1, 2 }, { 2, 1, 0 } }));
  ExpectError("f -1 2 3\n" + threePlaces, "face 0 (line 1)");
}

TEST(ObjReader, CommentsDoNotGoOnInTheNextLine)
{
  const Contents read = ReadBytes("# C:\\models\\\n" + threePlaces + "f 1 2 \\\n  3 # \\\n");
  ASSERT_TRUE(read.status);
  EXPECT_EQ(read.mesh.points.size(), 3U);
  EXPECT_EQ(read.mesh.triangles.size(), 1U);
}

TEST(ObjReader, BackslashesOfNamesAndCommentsDoNotGoOn)
{
  for (const std::string between : { "v 7 7 7 # C:\\tmp\\\n", "g C:\\tmp\\\n", "o a\\\n",
         "usemtl C:\\m\\\n", "g a \\\n b\n", "f 1 2 \\  \n 3\n" })
  {
    SCOPED_TRACE(between);
    const Contents read = ReadBytes(threePlaces + between + "f 1 2 3\n");
    ASSERT_TRUE(read.status) << read.status.GetError().message;
    EXPECT_EQ(read.mesh.triangles.size(), between[0] == 'f' ? 2U : 1U);
  }
}

TEST(ObjReader, StatementsInCapitalsAndOldOnesCount)
{
  const Contents read =
    ReadBytes("V 0 0 0\nV 1 0 0\nv 0 1 0\nVN 0 0 1\nF 1//1 2//1 3//1\nfo 1//1 3//1 2//1\n");
  ASSERT_TRUE(read.status) << read.status.GetError().message;
  EXPECT_EQ(read.mesh.triangles.size(), 2U);
  EXPECT_TRUE(read.info.ignoredAttributes.empty());
}

TEST(ObjReader, WhatIsNotReadIsNamed)
{
  const auto ignored = [](const std::string& more)
  { return ReadBytes(threePlaces + "f 1 2 3\n" + more).info.ignoredAttributes; };
  using Names = std::vector<std::string>;
  EXPECT_EQ(ignored("s off\nG a\nmg 1 2\np 1\n"), Names());
  EXPECT_EQ(ignored("face 1 2 3\nvc 1 0 0\n"),
    Names{ "2 lines that are not statements of OBJ: the first is 'face' in line 5" });
  EXPECT_EQ(ignored("vc 1\n"), Names{ "1 line that is not a statement of OBJ: 'vc' in line 5" });
  EXPECT_EQ(ignored("vn 0 0 1\nvt 0 0\n"),
    (Names{ "texture coordinates, which no face names", "normals, which no face names" }));
}

TEST(ObjReader, NumbersAfterTheCoordinatesAreTakenForWhatTheyAre)
{
  struct Case
  {
    std::array<std::string, 3> after;
    std::string array;
    std::array<double, 3> first;
    std::string reading;
  };
  const Case cases[] = {
    { { "1.001 0.5 0.25", "0.9 0.5 0.25", "0.9 0.5 0.25" }, "RGB", { 255, 128, 64 },
      "colours of vertices are read as from 0 to 1, as most of their values are: 1 of 9 is above "
      "it and counts as white" },
    { { "255 0 1", "3 4 255", "0 0 0" }, "RGB", { 255, 0, 1 }, "" },
    { { "200 100 50", "200 100 50", "256 100 50" }, "RGB", { 200, 100, 50 },
      "colours of vertices are read as from 0 to 255, as most of their values are: 1 of 9 is above "
      "it and counts as white" },
    { { "65535 32768 0", "60000 30000 10000", "60000 30000 10000" }, "RGB", { 255, 128, 0 },
      "colours of vertices are read as from 0 to 65535" },
    { { "0.5 0.25 1", "0.9 -0.001 0.25", "inf 0.5 0.25" }, "RGB", { 128, 64, 255 },
      "colours of vertices are read as from 0 to 1, 1 of 8 is below 0 and counts as 0" },
    { { "0 0 -1", "0.6 0 0.8", "0.5774 0.5774 -0.5774" }, "Normals", { 0, 0, -1 },
      "the numbers after x y z are read as normals, not as colours: most have length 1, and some "
      "are negative" },
    { { "1 0.8 0.4 0.2", "1.0 0.5 0.5 0.5", "1 0 0 0" }, "RGB", { 204, 102, 51 },
      "vertices of seven numbers are read as x y z w r g b, as the fourth is always 1" },
    { { "0.8 0.4 0.2 1", "0.5 0.5 0.5 1", "0 0 0 1" }, "RGB", { 204, 102, 51 }, "" },
  };
  for (const Case& c : cases)
  {
    for (const std::string corner : { "", "/1" }) // second: with tables
    {
      SCOPED_TRACE(c.after[0] + corner);
      const Contents read = ReadBytes(
        "v 0 0 0 " + c.after[0] + "\nv 1 0 0 " + c.after[1] + "\nv 0 1 0 " + c.after[2] + "\n" +
        (corner.empty() ? "" : "vt 0 0\n") + "f 1" + corner + " 2" + corner + " 3" + corner + "\n");
      ASSERT_TRUE(read.status) << read.status.GetError().message;
      EXPECT_EQ(read.info.tolerance.Warnings(),
        c.reading.empty() ? std::vector<std::string>() : std::vector{ c.reading });
      ASSERT_EQ(read.mesh.attributes.size(), corner.empty() ? 1U : 2U);
      EXPECT_EQ(read.mesh.attributes[0].name, c.array);
      for (std::size_t k = 0; k < 3; ++k)
      {
        EXPECT_EQ(read.mesh.attributes[0].Get(0, k), c.first[k]) << k;
      }
    }
  }
}

// The message names the numbers that are not read.
TEST(ObjReader, NumbersThatMeanNothingAreNamed)
{
  const auto ignored = [](const std::string& words)
  {
    return ReadBytes("v 0 0 0" + words + "\nv 1 0 0" + words + "\nv 0 1 0" + words + "\nf 1 2 3\n")
      .info.ignoredAttributes;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(ignored(" 1"), Names{});
  EXPECT_EQ(ignored(" 0.5 0.5"), Names{ "two numbers after the coordinates of vertices" });
  EXPECT_EQ(ignored(" 0.5 0.5 0.5 1"), Names{});
  EXPECT_EQ(ignored(" 0.5 0.5 0.5 0.25"),
    Names{ "the numbers after the colours of vertices (transparency, mostly)" });
}

TEST(ObjReader, PointsOfACloudHaveTheirNormals)
{
  const Contents read =
    ReadBytes("vn 0 0 1\nv 0 0 0\nvn 0 1 0\nv 1 0 0\nvt 0.25 0.5\nvt 1 1\nvn 1 0 0\nv 2 0 0\n");
  ASSERT_TRUE(read.status);
  ASSERT_EQ(read.mesh.attributes.size(), 1U);
  const Attribute& normals = read.mesh.attributes[0];
  EXPECT_EQ(normals.name, "Normals");
  for (std::size_t i = 0; i < 3; ++i)
  {
    EXPECT_EQ(normals.Get(i, 2 - i), 1) << i;
  }
  EXPECT_EQ(read.info.ignoredAttributes,
    std::vector<std::string>{ "texture coordinates, which no face names" });
}

TEST(ObjReader, APlaceOfVeryManyNormalsStaysCorrect)
{
  std::string text = threePlaces;
  for (int i = 0; i < 3000; ++i)
  {
    text += "vn " + std::to_string(i) + " 0 1\n";
  }
  for (int round = 0; round < 2; ++round)
  {
    for (int i = 1; i <= 3000; ++i)
    {
      text += "f 1//" + std::to_string(i) + " 2//1 3//1\n";
    }
  }
  const Contents read = ReadBytes(text);
  ASSERT_TRUE(read.status);
  ASSERT_EQ(read.mesh.triangles.size(), 6000U);
  EXPECT_LE(read.mesh.points.size(), 6003U);
  for (std::size_t i = 0; i < 6000; ++i)
  {
    const Triangle& triangle = read.mesh.triangles[i];
    ASSERT_EQ(read.mesh.attributes[0].Get(triangle[0], 0), double(i % 3000));
    ASSERT_EQ(read.mesh.points[triangle[0]], (Vec3{ 0, 0, 0 }));
    ASSERT_EQ(triangle[1], 1U);
  }
}

TEST(ObjReader, SaysWhatIsWrongAndWhere)
{
  ExpectError("");
  ExpectError("hello\nworld\n");
  ExpectError("v 1 2\n", "vertex 0 (line 1)");
  ExpectError("\nv 1 2 3\nv 1 2 3 4 5 6 7 8 9\n", "vertex 1 (line 3)");
  ExpectError("v 1 2 1.5x\n", "vertex 0 (line 1): '1.5x'");
  ExpectError("v 1 2 3 0 0 red\n", "vertex 0 (line 1): 'red'");
  ExpectError("v 1e999 2 1\n", "vertex 0 (line 1): '1e999'");
  ExpectError(threePlaces + "f 1 2 4\n", "face 0 (line 4)");
  ExpectError(threePlaces + "f 1 2 -4\nv 9 9 9\n", "face 0 (line 4)");
  ExpectError(threePlaces + "f 1 2 0\n", "face 0 (line 4): '0'");
  ExpectError(threePlaces + "f 1 2 x\n", "face 0 (line 4): 'x'");
  ExpectError(
    threePlaces + "f 1 2 99999999999999999999\n", "face 0 (line 4): '99999999999999999999'");
  ExpectError(threePlaces + "f 1/1/1/1 2 3\n", "face 0 (line 4)");
  ExpectError(threePlaces + "vn 1 0\nf 1//1 2//1 3//1\n", "normal 0 (line 4)");
  ExpectError(threePlaces + "vt a\nf 1/1 2/1 3/1\n", "texture coordinate 0 (line 4): 'a'");
  ExpectError(threePlaces + "f" + std::string(17 << 20, ' '), "line 4");
}

TEST(ObjReader, DropsWhatItCanDoWithoutAndCountsIt)
{
  struct Case
  {
    std::string text;
    std::vector<std::string> warnings;
    std::size_t points, triangles;
    std::vector<std::string> arrays;
  };
  const std::string missing = "1 face names a texture coordinate, normal or colour that does not "
                              "exist: it is read without it: face ";
  const std::string small = " and is dropped: face ";
  const Case cases[] = {
    { threePlaces + "v nan 1 1\nf 1 2 3\nf 1 2 4\nf 1 2 3 4\n",
      { "1 point is not finite and is dropped: vertex 3 (line 4), whose x is nan",
        "2 faces are dropped with the points that are not finite; the first: face 1 (line 6)" },
      3, 1, {} },
    { "v 1.#QNAN 0 0 # none\n" + threePlaces + "v 0 0 -1.#INF\nf 2 3 4\n",
      { "2 points are not finite and are dropped; the first: vertex 0 (line 1), whose x is nan" },
      3, 1, {} },
    // counts as one point, although it has two normals
    { threePlaces + "v 0 nan 0\nvn 0 0 1\nvn 1 0 0\nf 1//1 2//1 3//1\nf 1//1 2//1 4//1\n"
                    "f 1//1 2//1 4//2\n",
      { "1 point is not finite and is dropped: vertex 3, whose y is nan",
        "2 faces are dropped with the points that are not finite; the first: face 1" },
      3, 1, { "Normals" } },
    { threePlaces + "f 1 2\nf 1 2 3\nf\n",
      { "2 faces have fewer than three corners and are dropped; the first: face 0 (line 4)" }, 3, 1,
      {} },
    { threePlaces + "vt 0 0\nf 1/1 2/1\nf 1/1 2/1 3/1\n",
      { "1 face has fewer than three corners" + small + "0" }, 3, 1, { "TCoords" } },
    { threePlaces + "vt 0 0\nvn 0 0 1\nf 1/0/1 2/0/1 3/0/1\n", { missing + "0 (line 6)" }, 3, 1,
      { "Normals", "TCoords" } },
    { threePlaces + "vt 0 0\nf 1/1 2/1 3/1\nf 1/1 2/1 3/2\n", { missing + "1 (line 6)" }, 6, 2,
      { "TCoords" } },
    { threePlaces + "f 1/1 2/1 3/1\n", { missing + "0 (line 4)" }, 3, 1, {} },
    { threePlaces + "vn 1 0 0\nf 1//1 2//-2 3//1\n", { missing + "0 (line 5)" }, 3, 1,
      { "Normals" } },
    { threePlaces + "vt 0 0\nf 1/99999999999999999999 2/1 3/1\n", { missing + "0 (line 5)" }, 3, 1,
      { "TCoords" } },
  };
  for (const Case& c : cases)
  {
    SCOPED_TRACE(c.text);
    const fixtures::TemporaryFolder folder;
    const std::filesystem::path file = folder.Write("m.obj", c.text);
    for (const std::size_t limit : { everything, std::size_t{ 1 }, std::size_t{ 2 } })
    {
      const Contents read = ReadAll(file, [&] { return limit; });
      ASSERT_TRUE(read.status) << read.status.GetError().message;
      EXPECT_EQ(read.info.tolerance.Warnings(), c.warnings);
      EXPECT_EQ(read.mesh.points.size(), c.points);
      EXPECT_EQ(read.mesh.triangles.size(), c.triangles);
      std::vector<std::string> arrays;
      for (const Attribute& attribute : read.mesh.attributes)
      {
        arrays.push_back(attribute.name);
        EXPECT_EQ(attribute.TupleCount(), c.points);
      }
      EXPECT_EQ(arrays, c.arrays);
      for (const Triangle& t : read.mesh.triangles)
      {
        EXPECT_LT(std::max({ t[0], t[1], t[2] }), c.points);
      }
    }
  }
}

// One place has several vertices, by normal. Those of a place that is not finite are dropped, and
// the others keep their normals.
TEST(ObjReader, AttributesStayWithTheirVertices)
{
  const Contents read = ReadBytes("v 0 0 0\nv inf 0 0\nv 2 0 0\nv 3 0 0\nvn 0 0 0\nvn 2 0 0\n"
                                  "vn 3 0 0\nvn 9 0 0\nf 1//1 3//2 4//3\nf 1//4 3//2 4//3\n"
                                  "f 1//1 2//4 4//3\n");
  ASSERT_TRUE(read.status);
  ASSERT_EQ(read.mesh.triangles.size(), 2U);
  const Attribute& normals = read.mesh.attributes[0];
  for (const Triangle& t : read.mesh.triangles)
  {
    for (const VertexId corner : { t[1], t[2] })
    {
      EXPECT_EQ(normals.Get(corner, 0), read.mesh.points[corner][0]);
    }
  }
  EXPECT_EQ(normals.Get(read.mesh.triangles[0][0], 0), 0);
  EXPECT_EQ(normals.Get(read.mesh.triangles[1][0], 0), 9);
}

TEST(ObjReader, NamesKeepTheirHash)
{
  const fixtures::TemporaryFolder folder;
  Result<ByteSource> source = ByteSource::Open(folder.Write("m.obj",
    "#c\nusemtl paint#1\nusemtl paint #2\nv 1 2 3 #c\nv 1 2 4#c\nmap_Kd a#b.png\nf 1 1 2 # c\n"));
  ASSERT_TRUE(source);
  ObjStatements statements(std::move(*source));
  std::vector<std::string> rests;
  for (Result<bool> more = statements.Next(); more && *more; more = statements.Next())
  {
    rests.emplace_back(statements.Rest());
  }
  EXPECT_EQ(rests, (std::vector<std::string>{
                     " paint#1", " paint #2", " 1 2 3 ", " 1 2 4", " a#b.png", " 1 1 2 " }));
}

TEST(ObjReader, PolygonsOfManyCorners)
{
  std::string face = "f";
  for (int i = 0; i < 100000; ++i)
  {
    face += i % 1000 == 999 ? " 3 \\\n" : " 2";
  }
  const Contents read = ReadBytes(threePlaces + face + "\n");
  ASSERT_TRUE(read.status) << read.status.GetError().message;
  EXPECT_EQ(read.mesh.triangles.size(), 99998U);
  EXPECT_EQ(read.mesh.triangles[997], (Triangle{ 1, 1, 2 }));
  std::string many = threePlaces + face;
  for (int i = 0; i < 100; ++i)
  {
    many += face.substr(1);
  }
  ExpectError(many, "line 8384");
}

TEST(ObjReader, TextureCoordinatesThatAreTooLargeAreNotNumbers)
{
  const Contents read =
    ReadBytes(threePlaces + "vt 1e40 0.5\nvt 0.25\nvt 1 2 3 4 5\nf 1/1 2/2 3/3\n");
  ASSERT_TRUE(read.status) << read.status.GetError().message;
  ASSERT_EQ(read.mesh.attributes.size(), 1U);
  const Attribute& coordinates = read.mesh.attributes[0];
  EXPECT_TRUE(std::isnan(coordinates.Get(0, 0)));
  EXPECT_EQ(coordinates.Get(0, 1), 0.5);
  EXPECT_EQ(coordinates.Get(1, 0), 0.25);
  EXPECT_EQ(coordinates.Get(1, 1), 0);
  EXPECT_EQ(coordinates.Get(2, 1), 2);
}

// The polygon is on one line that is longer than a block; later lines still have the right numbers.
TEST(ObjReader, PolygonsInLongLines)
{
  for (const std::string end : { "\n", "\r\n", "\r" })
  {
    std::string text = threePlaces + "f";
    for (int i = 0; i < 600000; ++i)
    {
      text += i % 3 == 0 ? " 1" : i % 3 == 1 ? " 2/1/1" : " 3";
    }
    text += "\nf 1 2 3\n";
    std::string ended;
    for (const char c : text)
    {
      ended += c == '\n' ? end : std::string(1, c);
    }
    const Contents read = ReadBytes(ended);
    ASSERT_TRUE(read.status) << read.status.GetError().message;
    EXPECT_EQ(read.mesh.triangles.size(), 599999U);
    ExpectError(ended + "f 1 2 9\n", "face 2 (line 6)");
  }
}

TEST(ObjReader, TablesNeedAFolder)
{
  const fixtures::TemporaryFolder folder;
  // More records than stay in memory.
  std::string text = threePlaces + "vn 0 0 1\n";
  for (int i = 0; i < 100000; ++i)
  {
    text += "v 1 2 3\n";
  }
  text += "f 1//1 2//1 3//1\n";
  const auto file = folder.Write("m.obj", text);
  const auto reader = MeshReader::Open(file, {}, folder / "missing");
  EXPECT_TRUE(
    fixtures::FailsAt(reader, ErrorCode::InputOutput, (folder / "missing").string() + " "));
  EXPECT_TRUE(MeshReader::Open(file, {}, folder / ""));
}

TEST(ObjReader, CanBeCancelledWhileItIsOpened)
{
  const fixtures::TemporaryFolder folder;
  Execution execution;
  int reports = 0;
  execution.progress = [&](std::string_view step, double)
  { return step != "read" || ++reports < 3; };
  const std::string text = threePlaces + "vn 1 0 0\nf 1//1 2//1 3//1\n";
  const auto reader = MeshReader::Open(folder.Write("a.obj", text), execution);
  ASSERT_FALSE(reader);
  EXPECT_EQ(reader.GetError().code, ErrorCode::Cancelled);
}

}
