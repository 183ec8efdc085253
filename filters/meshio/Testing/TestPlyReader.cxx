// SPDX-License-Identifier: BSD-3-Clause
// PlyReader: random files of every shape are read back exactly. Handwritten files test what random
// ones do not reach. Every error names its place.
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/meshio/Testing/RandomPly.h"
#include "filters/meshio/Testing/ReadAll.h"

#include <gtest/gtest.h>

#include <clocale>
#include <locale>

namespace kdstream::test
{

namespace
{

Contents ReadBytes(std::string_view bytes)
{
  const fixtures::TemporaryFolder folder;
  return ReadAll(folder.Write("bytes.ply", bytes), [] { return everything; });
}

void ExpectError(
  std::string_view bytes, std::string_view place = {}, ErrorCode code = ErrorCode::InvalidInput)
{
  EXPECT_TRUE(fixtures::FailsAt(ReadBytes(bytes).status, code, place));
}

const std::string asciiVertices = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"
                                  "property float y\nproperty float z\n";
const std::string fourPoints = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";

// An ASCII file with four points, and with these lines of faces.
std::string WithFaces(std::size_t count, const std::string& faces,
  const std::string& list = "property list uchar int vertex_indices\n")
{
  return asciiVertices + "element face " + std::to_string(count) + "\n" + list + "end_header\n" +
         fourPoints + faces;
}

// A binary file with two points and one face, whose list begins with `faceBytes`.
std::string BinaryWithFace(
  const std::string& list, const std::string& faceBytes, bool bigEndian = false)
{
  return std::string("ply\nformat binary_") + (bigEndian ? "big" : "little") +
         "_endian 1.0\nelement vertex 2\nproperty uchar x\nproperty uchar y\nproperty uchar "
         "z\nelement face 1\n" +
         list + "end_header\n" + std::string("\1\2\3\4\5\6", 6) + faceBytes;
}

// A binary PLY file with these points; x and z are floats, y is a double.
std::string BinaryPoints(const std::vector<std::vector<double>>& points, EmitEncoding encoding)
{
  EmitElement element{ "vertex",
    { { "x", "float", "" }, { "y", "double", "" }, { "z", "float", "" } }, {} };
  for (const std::vector<double>& point : points)
  {
    element.records.push_back({ { point[0] }, { point[1] }, { point[2] } });
  }
  EmitStyle style;
  style.encoding = encoding;
  return PlyEmitter(style).Emit({ element });
}

}

TEST(PlyReader, ReadsRandomFilesBack)
{
  for (unsigned seed = 0; seed < 600; ++seed)
  {
    ExpectReadBack<RandomPlyMaker>(
      "random.ply", seed, seed % 5 == 0 ? 3 : 300, seed % 3 == 0 ? 4 : 1000);
  }
}

// Files of several blocks, in which records and lists cross the borders of blocks.
TEST(PlyReader, ReadsRandomLargeFilesBack)
{
  for (unsigned seed = 1000; seed < 1015; ++seed)
  {
    ExpectReadBack<RandomPlyMaker>("random.ply", seed, 60000, 50000);
  }
}

TEST(PlyReader, ReadsPolygonsAndStripsInTheOrderOfTheFile)
{
  const Contents read =
    ReadBytes(asciiVertices +
              "element tristrips 1\nproperty list int int vertex_index\n"
              "element face 2\nproperty list uchar int vertex_indices\nend_header\n" +
              fourPoints + "11 0 1 2 3 3 -1 2 1 -1 0 3\n4 0 1 2 3\n3 3 3 1\n");
  ASSERT_TRUE(read.status) << read.status.GetError().message;
  EXPECT_EQ(read.info.faces, 3U);
  EXPECT_EQ(read.mesh.triangles, (std::vector<Triangle>{ { 0, 1, 2 }, { 2, 1, 3 }, { 2, 3, 3 },
                                   { 0, 1, 2 }, { 0, 2, 3 }, { 3, 3, 1 } }));
}

// If a header counts too few faces, the others are not read, but reported.
TEST(PlyReader, ReportsBytesAfterTheEnd)
{
  const auto reported = [](const std::string& bytes)
  {
    const Contents read = ReadBytes(bytes);
    EXPECT_TRUE(read.status) << read.status.GetError().message;
    EXPECT_TRUE(read.info.ignoredAttributes.empty());
    return read.info.tolerance.Warnings();
  };
  const auto after = [](std::size_t bytes, const std::string& file, const std::string& what)
  {
    return std::vector<std::string>{ std::to_string(bytes) + what + "; the first: byte " +
                                     std::to_string(file.size() - bytes) +
                                     ", after the last face that the header counts" };
  };
  const std::string unread = " bytes after the end are not read";
  const std::vector<std::string> none;
  const std::string more = WithFaces(1, "3 0 1 2\n3 1 2 3\n");
  EXPECT_EQ(reported(more), after(9, more, unread)); // with the line break of the face
  EXPECT_EQ(reported(WithFaces(1, "3 0 1 2\n \r\n\n")), none);
  EXPECT_EQ(reported(WithFaces(1, "3 0 1 2\n\x1A")), none);
  const std::string blank = WithFaces(1, "3 0 1 2\n" + std::string(5000, '\n'));
  EXPECT_EQ(reported(blank), after(5001, blank, unread));
  const std::string list = "property list uchar uchar vertex_indices\n";
  const std::string face("\3\0\1\0", 4);
  EXPECT_EQ(reported(BinaryWithFace(list, face)), none);
  const std::string twice = BinaryWithFace(list, face + face);
  EXPECT_EQ(reported(twice), after(4, twice, unread));
  const std::string padded = BinaryWithFace(list, face + std::string(100, '\0'));
  EXPECT_EQ(reported(padded), after(100, padded, " zeros after the end are padding"));
  // Bytes after the end of a cloud are reported, too.
  EXPECT_EQ(reported(asciiVertices + "end_header\n" + fourPoints + "left over\n").size(), 1U);
  // Elements that the header declares after the faces are accepted.
  std::string edges = WithFaces(1, "3 0 1 2\n0 1\n");
  edges.insert(
    edges.find("end_header"), "element edge 1\nproperty int vertex1\nproperty int vertex2\n");
  EXPECT_EQ(ReadBytes(edges).info.ignoredAttributes.size(), 1U);
  EXPECT_TRUE(ReadBytes(edges).info.tolerance.Check(true));
}

TEST(PlyReader, ReadsAListLongerThanABlock)
{
  for (const EmitEncoding encoding :
    { EmitEncoding::Ascii, EmitEncoding::LittleEndian, EmitEncoding::BigEndian })
  {
    EmitElement vertices{ "vertex",
      { { "x", "float", "" }, { "junk", "double", "uint" }, { "y", "float", "" },
        { "z", "float", "" } },
      {} };
    EmitElement strip{ "tristrips", { { "vertex_indices", "int", "int" } }, { { {} } } };
    vertices.records.push_back({ { 1 }, std::vector<double>(400000, 0.25), { 2 }, { 3 } });
    for (std::size_t i = 0; i < 700000; ++i)
    {
      strip.records[0][0].push_back(0);
    }
    EmitStyle style;
    style.encoding = encoding;
    const Contents read = ReadBytes(PlyEmitter(style).Emit({ strip, vertices }));
    ASSERT_TRUE(read.status) << read.status.GetError().message;
    EXPECT_EQ(read.mesh.points, (std::vector<Vec3>{ { 1, 2, 3 } }));
    EXPECT_EQ(read.mesh.triangles.size(), 699998U);
  }
}

TEST(PlyReader, ReadsARecordLargerThanABlock)
{
  EmitElement vertices{ "vertex", {}, { {}, {} } };
  EmitElement faces{ "face", {}, { {} } };
  for (int i = 0; i < 20000; ++i)
  {
    const std::string name = std::to_string(i);
    vertices.properties.push_back({ i == 0       ? "x"
                                    : i == 9999  ? "y"
                                    : i == 19999 ? "z"
                                                 : name,
      "double", "" });
    vertices.records[0].push_back({ i * 1.0 });
    vertices.records[1].push_back({ i * 2.0 });
    faces.properties.push_back(i == 500 ? EmitProperty{ "vertex_indices", "int", "uchar" }
                                        : EmitProperty{ name, "double", "" });
    faces.records[0].push_back(
      i == 500 ? std::vector<double>{ 1, 0, 1 } : std::vector<double>{ 7 });
  }
  EmitStyle style;
  style.encoding = EmitEncoding::BigEndian;
  const Contents read = ReadBytes(PlyEmitter(style).Emit({ vertices, faces }));
  ASSERT_TRUE(read.status) << read.status.GetError().message;
  EXPECT_EQ(read.mesh.points, (std::vector<Vec3>{ { 0, 9999, 19999 }, { 0, 19998, 39998 } }));
  EXPECT_EQ(read.mesh.triangles, (std::vector<Triangle>{ { 1, 0, 1 } }));
}

TEST(PlyReader, RoundsTextOnceToTheTypeOfTheProperty)
{
  // 1 + 2^-24 + 2^-60 is just above the middle between two floats; rounded to double, it is exactly
  // the middle.
  const std::string tie =
    "1.000000059604644775390625000000867361737988403547205962240695953369140625";
  const std::string header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                             "property double y\nproperty short z\nend_header\n";
  const Contents read =
    ReadBytes(header + tie + " " + tie + " -32768\n+1e-46 -1e-400 +7\n-7.1e-46 .5 -0\n");
  ASSERT_TRUE(read.status) << read.status.GetError().message;
  EXPECT_EQ(read.info.scalarType, ScalarType::Float64);
  const double above = 1.00000011920928955078125;
  EXPECT_EQ(read.mesh.points[0], (Vec3{ above, 1.000000059604644775390625, -32768 }));
  EXPECT_TRUE(SameBits({ read.mesh.points[1] }, { { 0, -0.0, 7 } }));
  EXPECT_EQ(read.mesh.points[2],
    (Vec3{ -static_cast<double>(std::numeric_limits<float>::denorm_min()), 0.5, 0 }));
}

TEST(PlyReader, ReadsTheSameInEveryLocale)
{
  struct Comma : std::numpunct<char>
  {
    char do_decimal_point() const override { return ','; }
  };
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new Comma));
  std::setlocale(LC_NUMERIC, "de_DE.UTF-8");
  const Contents read =
    ReadBytes(asciiVertices + "end_header\n0.5 1.5 2.5\n" + fourPoints.substr(6));
  std::setlocale(LC_NUMERIC, "C");
  std::locale::global(before);
  ASSERT_TRUE(read.status) << read.status.GetError().message;
  EXPECT_EQ(read.mesh.points[0], (Vec3{ 0.5, 1.5, 2.5 }));
}

TEST(PlyReader, ReadsRecordsOverSeveralLinesAndWithoutALastLineEnd)
{
  const Contents read =
    ReadBytes(asciiVertices + "end_header\n\n0 0\n 0\n1\n0\n0\n\n\n 0 1 0 \r\n0 0 1");
  ASSERT_TRUE(read.status) << read.status.GetError().message;
  EXPECT_EQ(read.mesh.points.size(), 4U);
  EXPECT_EQ(read.mesh.points[3], (Vec3{ 0, 0, 1 }));
}

TEST(PlyReader, ReadsCloudsAndEmptyMeshes)
{
  EXPECT_TRUE(ReadBytes(asciiVertices + "end_header\n" + fourPoints).status);
  EXPECT_TRUE(ReadBytes(asciiVertices + "element face 0\nend_header\n" + fourPoints).status);
  const Contents none =
    ReadBytes("ply\nformat binary_big_endian 1.0\nelement vertex 0\n"
              "property float x\nproperty float y\nproperty float z\nend_header\n");
  ASSERT_TRUE(none.status);
  EXPECT_TRUE(none.mesh.points.empty());
}

TEST(PlyReader, GoesOnWhereItLeftOffWhateverTheCallsAre)
{
  const fixtures::TemporaryFolder folder;
  const auto file = folder.Write("order.ply",
    "ply\nformat ascii 1.0\nelement face 2\nproperty list uchar int vertex_indices\n"
    "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
    "3 0 1 2\n4 2 1 0 0\n0 0 0\n1 0 0\n2 0 0\n");
  Result<std::unique_ptr<MeshReader>> reader = MeshReader::Open(file);
  ASSERT_TRUE(reader);
  Mesh mesh;
  EXPECT_EQ(*(*reader)->ReadTriangles(mesh, 1), 1U);
  EXPECT_EQ(*(*reader)->ReadVertices(mesh, 2), 2U);
  EXPECT_EQ(*(*reader)->ReadTriangles(mesh, 0), 0U);
  EXPECT_EQ(*(*reader)->ReadTriangles(mesh, 5), 1U);
  EXPECT_EQ(*(*reader)->ReadVertices(mesh, 2), 1U);
  EXPECT_EQ(*(*reader)->ReadVertices(mesh, 2), 0U);
  EXPECT_EQ(*(*reader)->ReadTriangles(mesh, 5), 0U);
  EXPECT_EQ(mesh.points, (std::vector<Vec3>{ { 0, 0, 0 }, { 1, 0, 0 }, { 2, 0, 0 } }));
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{ { 0, 1, 2 }, { 2, 1, 0 }, { 2, 0, 0 } }));
}

TEST(PlyReader, DropsCoordinatesThatAreNotFinite)
{
  for (const char* value : { "nan", "NaN", "-nan", "1.#QNAN" })
  {
    const Contents read =
      ReadBytes(asciiVertices + "end_header\n0 0 0\n1 " + value + " 0\n2 0 0\n3 0 0\n");
    ASSERT_TRUE(read.status);
    EXPECT_EQ(read.mesh.points, (std::vector<Vec3>{ { 0, 0, 0 }, { 2, 0, 0 }, { 3, 0, 0 } }));
    EXPECT_EQ(read.info.tolerance.Warnings(),
      (std::vector<std::string>{
        "1 point is not finite and is dropped: vertex 1, whose y is nan" }));
  }
  ExpectError(asciiVertices + "end_header\n0 1e39 0\n", "vertex 0 (line 8): y '1e39'");
  const double infinity = std::numeric_limits<double>::infinity();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const EmitEncoding encoding : { EmitEncoding::LittleEndian, EmitEncoding::BigEndian })
  {
    std::vector<std::vector<double>> points(3000, { 1, 2, 3 });
    points[2500] = { 1, infinity, nan };
    points[17] = { nan, 0, -infinity };
    const Contents read = ReadBytes(BinaryPoints(points, encoding));
    ASSERT_TRUE(read.status);
    EXPECT_EQ(read.mesh.points.size(), 2998U);
    EXPECT_EQ(read.info.tolerance.Of(Lapse::PointNotFinite), 2U);
  }
}

// With chunks of any size: faces of dropped vertices are dropped, the other faces get the new
// numbers, and tuples stay with their vertices and triangles.
TEST(PlyReader, FacesAndArraysFollowDroppedVertices)
{
  const std::string header =
    "ply\nformat ascii 1.0\nelement vertex 200\nproperty float x\nproperty float y\n"
    "property float z\nproperty int number\nelement face 198\n"
    "property list uchar int vertex_indices\nproperty int face\nend_header\n";
  const auto isBad = [](int v) { return v % 67 == 3 || (v >= 60 && v < 131); };
  std::string body;
  for (int v = 0; v < 200; ++v)
  {
    body += std::to_string(v) + (isBad(v) ? " inf 0 " : " 0 0 ") + std::to_string(v) + "\n";
  }
  std::vector<std::array<int, 3>> expected;
  std::vector<int> faces;
  for (int f = 0; f < 198; ++f)
  {
    // A triangle, or a quad whose last corner repeats the first.
    const bool quad = f % 5 == 0;
    body += (quad ? "4 " : "3 ") + std::to_string(f) + " " + std::to_string(f + 1) + " " +
            std::to_string(f + 2) + (quad ? " " + std::to_string((f * 31) % 200) : "") + " " +
            std::to_string(f) + "\n";
    if (isBad(f) || isBad(f + 1) || isBad(f + 2) || (quad && isBad((f * 31) % 200)))
    {
      continue;
    }
    expected.push_back({ f, f + 1, f + 2 });
    faces.push_back(f);
    if (quad)
    {
      expected.push_back({ f, f + 2, (f * 31) % 200 });
      faces.push_back(f);
    }
  }
  const fixtures::TemporaryFolder folder;
  const auto file = folder.Write("m.ply", header + body);
  for (const std::size_t limit :
    { everything, std::size_t{ 1 }, std::size_t{ 7 }, std::size_t{ 64 } })
  {
    const Contents read = ReadAll(file, [&] { return limit; });
    ASSERT_TRUE(read.status) << read.status.GetError().message;
    ASSERT_EQ(read.mesh.attributes.size(), 2U);
    EXPECT_EQ(read.mesh.points.size(), 200 - read.info.tolerance.Of(Lapse::PointNotFinite));
    EXPECT_EQ(read.faces, 198U);
    std::vector<std::array<int, 3>> corners;
    for (const Triangle& t : read.mesh.triangles)
    {
      corners.push_back({ int(read.mesh.points[t[0]][0]), int(read.mesh.points[t[1]][0]),
        int(read.mesh.points[t[2]][0]) });
    }
    EXPECT_EQ(corners, expected);
    for (std::size_t v = 0; v < read.mesh.points.size(); ++v)
    {
      ASSERT_EQ(read.mesh.attributes[0].Get(v, 0), read.mesh.points[v][0]);
    }
    ASSERT_EQ(read.mesh.attributes[1].TupleCount(), faces.size());
    for (std::size_t t = 0; t < faces.size(); ++t)
    {
      ASSERT_EQ(read.mesh.attributes[1].Get(t, 0), faces[t]);
    }
    EXPECT_GT(read.info.tolerance.Of(Lapse::FaceOfDroppedPoint), 70U);
  }
}

TEST(PlyReader, NamesIndicesOutOfRange)
{
  ExpectError(WithFaces(2, "3 0 1 2\n3 0 1 99\n"), "face 1 (line 15)");
  ExpectError(WithFaces(1, "4 0 1 2 4\n"), "face 0 (line 14)");
  ExpectError(WithFaces(1, "3 0 -1 2\n"), "face 0 (line 14)");
  ExpectError(
    WithFaces(1, "3 0 99999999999999999999 2\n"), "face 0 (line 14): index '99999999999999999999'");
  const std::string bytesList = "property list uchar int vertex_indices\n";
  const std::string minusOne(4, '\xff');
  const std::string zeros(8, '\0');
  ExpectError(BinaryWithFace(bytesList, "\3" + zeros + minusOne), "face 0");
  ExpectError(BinaryWithFace(bytesList, "\3" + zeros + minusOne, true), "face 0");
  ExpectError(
    BinaryWithFace("property list uchar uint vertex_indices\n", "\3" + minusOne + zeros), "face 0");
  ExpectError(BinaryWithFace(bytesList, "\3" + zeros + std::string("\2\0\0\0", 4)), "face 0");
  ExpectError(
    BinaryWithFace("property list uchar char vertex_indices\n", std::string("\4\0\1\0\x80", 5)),
    "face 0");
}

TEST(PlyReader, DropsPolygonsOfTooFewVertices)
{
  const auto small = [](const std::string& bytes, std::size_t triangles)
  {
    const Contents read = ReadBytes(bytes);
    EXPECT_TRUE(read.status) << read.status.GetError().message;
    EXPECT_EQ(read.mesh.triangles.size(), triangles);
    return read.info.tolerance.Of(Lapse::FaceTooSmall);
  };
  EXPECT_EQ(small(WithFaces(3, "2 0 1\n3 0 1 2\n0\n"), 1), 2U);
  EXPECT_EQ(
    small(BinaryWithFace("property list uchar uchar vertex_index\n", std::string("\1\0", 2)), 0),
    1U);
}

TEST(PlyReader, NamesListCountsThatLie)
{
  const std::string wide = "property list uint int vertex_indices\n";
  const std::string lying = WithFaces(1, "4294967295 0 1 2\n", wide);
  ExpectError(lying, "byte " + std::to_string(lying.rfind(" 0 1 2")));
  ExpectError(WithFaces(1, "-3 0 1 2\n", wide), "face 0 (line 14)");
  ExpectError(WithFaces(1, "3.5 0 1 2\n"), "face 0 (line 14): list count '3.5'");
  ExpectError(WithFaces(1, "99999999999999999999 0 1 2\n"),
    "face 0 (line 14): list count '99999999999999999999'");
  const std::string oneTooMany = WithFaces(1, "4 0 1 2\n", wide);
  ExpectError(oneTooMany, "byte " + std::to_string(oneTooMany.rfind(" 0 1 2")));
  const std::string maximum(4, '\xff');
  const std::string three(12, '\0');
  const std::string binary = BinaryWithFace(wide, maximum + three);
  ExpectError(binary, "byte " + std::to_string(binary.size() - 12));
  ExpectError(BinaryWithFace("property list int int vertex_indices\n", maximum + three), "face 0");
  const std::string other = BinaryWithFace(
    "property list uchar int other\nproperty list uchar int vertex_indices\n", "\x09" + three);
  ExpectError(other, "byte " + std::to_string(other.size() - 12));
}

TEST(PlyReader, NamesTextInPlaceOfNumbers)
{
  ExpectError(asciiVertices + "end_header\n0 0 0\n1 zero 0\n", "vertex 1 (line 9): y 'zero'");
  ExpectError(asciiVertices + "end_header\n0 0 0\n1 0,5 0\n", "vertex 1 (line 9): y '0,5'");
  ExpectError(asciiVertices + "end_header\n0 0 0x10\n", "vertex 0 (line 8): z '0x10'");
  ExpectError(asciiVertices + "end_header\n0 0 +-1\n", "vertex 0 (line 8): z '+-1'");
  ExpectError(asciiVertices + "end_header\n0 \x1b[31m 0\n", "vertex 0 (line 8): y '?[31m'");
  ExpectError(WithFaces(1, "3 0 1 two\n"), "face 0 (line 14): index 'two'");
  ExpectError(WithFaces(1, "3 0 1 1.5\n"), "face 0 (line 14): index '1.5'");
  ExpectError(
    asciiVertices + "end_header\n" + std::string(5000, '1') + " 0 0\n", "vertex 0 (line 8)");
  ExpectError("ply\nformat ascii 1.0\nelement vertex 1\nproperty uchar x\nproperty float y\n"
              "property float z\nend_header\n256 0 0\n",
    "vertex 0 (line 8): x '256'");
}

TEST(PlyReader, DropsWhatLinesHoldBeyondTheHeader)
{
  const Contents read =
    ReadBytes(asciiVertices + "element face 2\nproperty list uchar int vertex_indices\n"
                              "end_header\n0 0 0 255 7\n1 0 0\n0 1 0 255\n0 0 1\n3 0 1 2 9\n"
                              "3 1 2 3\n\n");
  ASSERT_TRUE(read.status) << read.status.GetError().message;
  EXPECT_EQ(read.mesh.points[1], (Vec3{ 1, 0, 0 }));
  EXPECT_EQ(read.mesh.triangles, (std::vector<Triangle>{ { 0, 1, 2 }, { 1, 2, 3 } }));
  EXPECT_EQ(read.info.tolerance.Warnings(),
    std::vector<std::string>{ "3 lines have more values than the header names: they are not read; "
                              "the first: vertex 0 (line 10)" });
  EXPECT_FALSE(read.info.tolerance.Check(true));
  // A record may take several lines, but none of these may hold part of the next record.
  ExpectError(asciiVertices + "end_header\n0 0 0\n0 0\n1 0 0\n0 1 0\n0 0 1\n", "vertex 1 (line 9)");
  const Contents spread =
    ReadBytes(asciiVertices + "end_header\n0\n0 0\n1 0 0 255\n0 1\n0\n0 0\n1\n");
  ASSERT_TRUE(spread.status) << spread.status.GetError().message;
  EXPECT_EQ(spread.mesh.points[3], (Vec3{ 0, 0, 1 }));
  EXPECT_EQ(spread.info.tolerance.Of(Lapse::ValuesNotNamed), 1U);
  // The file has neither a line for each record nor a line for each element.
  ExpectError(asciiVertices + "end_header\n0 0 0 1 0 0\n0 1 0\n0 0 1\n", "vertex 0 (line 8)");
}

// Line breaks do not matter in such a file.
TEST(PlyReader, ReadsElementsThatStandInOneLine)
{
  const std::string points = "0 0 0 1 0 0 0 1 0 0 0 1", faces = "3 0 1 2 4 0 1 2 3 3 1 2 3";
  for (const std::string between : { " ", "\n", "\r\n" })
  {
    std::string text = WithFaces(3, faces);
    text.replace(text.rfind(fourPoints), fourPoints.size(), points + between);
    const Contents read = ReadBytes(text);
    ASSERT_TRUE(read.status) << read.status.GetError().message;
    EXPECT_EQ(read.mesh.points[3], (Vec3{ 0, 0, 1 }));
    EXPECT_EQ(read.mesh.triangles.size(), 4U);
    EXPECT_EQ(read.mesh.triangles[3], (Triangle{ 1, 2, 3 }));
    EXPECT_TRUE(read.info.tolerance.Check(true));
  }
}

TEST(PlyReader, ReadsNamesAndNumbersAsOtherProgramsWriteThem)
{
  const Triangle first{ 0, 1, 2 };
  const std::string capitals = "ply\nformat ascii 1.0\nelement Vertex 4\nproperty float X\n"
                               "property float y\nproperty float z\nelement FACE 1\nproperty list "
                               "uchar int Vertex_Index\nend_header\n" +
                               fourPoints + "3 0 1 2\n";
  const std::string twice = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"
                            "property float y\nproperty float z\nproperty float x\nelement face 1\n"
                            "property list uchar int vertex_index\nend_header\n0 0 0 7\n1 0 0 7\n"
                            "0 1 0 7\n0 0 1 7\n3 0 1 2\n";
  for (const std::string& text :
    { WithFaces(1, "3 0 1 2\n", "property list uchar int vertex_indexes\n"),
      WithFaces(1, "3 0 1 2\n", "property list int64 uint64 vertex_indices\n"),
      WithFaces(1, "3 0 1.0 2e0\n", "property list uchar float vertex_indices\n"),
      WithFaces(1, "3.0 0 1 2.0\n", "property list double int vertex_indices\n"),
      WithFaces(
        1, "255.0 3 0 1 2\n", "property uchar grey\nproperty list uchar int vertex_indices\n"),
      WithFaces(1, "3 0 1 2\n", "property list uchar int corners\n"),
      WithFaces(1, "3 0 1 2 1 0.5\n",
        "property list uchar int corners\nproperty list uchar float texcoord\n"),
      WithFaces(1, "3 0 1 2 3 3 2 1\n",
        "property list uchar int vertex_index\nproperty list uchar int vertex_index\n"),
      capitals, twice })
  {
    SCOPED_TRACE(text);
    const Contents read = ReadBytes(text);
    ASSERT_TRUE(read.status) << read.status.GetError().message;
    EXPECT_EQ(read.mesh.triangles, std::vector<Triangle>{ first });
    EXPECT_EQ(read.mesh.points[1], (Vec3{ 1, 0, 0 }));
  }
  EXPECT_EQ(ReadBytes(twice).info.ignoredAttributes,
    std::vector<std::string>{ "vertex.x, which is named twice: the first counts" });
  EXPECT_EQ(ReadBytes(WithFaces(1, "3 0 1 2\n", "property list uchar int corners\n"))
              .info.tolerance.Warnings(),
    std::vector<std::string>{
      "element 'face': its only list of integers, 'corners', is taken for the corners" });
  ExpectError(
    WithFaces(1, "3 0 1 2\n", "property list uchar int corners\nproperty list uchar int others\n"),
    "element 'face'");
}

TEST(PlyReader, ReadsWholeNumbersOfAnyTypeInBinary)
{
  for (const EmitEncoding encoding : { EmitEncoding::LittleEndian, EmitEncoding::BigEndian })
  {
    for (const std::string type : { "float", "double", "int64", "uint64" })
    {
      for (const std::string count : { "uchar", "float", "int64" })
      {
        SCOPED_TRACE(type + " " + count);
        EmitStyle style;
        style.encoding = encoding;
        const auto emit = [&](double last)
        {
          return PlyEmitter(style).Emit(
            { { "vertex",
                { { "x", "int64", "" }, { "y", "float", "" }, { "z", "float", "" },
                  { "id", "uint64", "" } },
                { { { 4503599627370497.0 }, { 0 }, { 0 }, { 7 } }, { { 1 }, { 0 }, { 0 }, { 8 } },
                  { { 0 }, { 1 }, { 0 }, { 9 } } } },
              { "face", { { "vertex_indices", type, count } }, { { { 0, 1, last } } } } });
        };
        const Contents read = ReadBytes(emit(2));
        ASSERT_TRUE(read.status) << read.status.GetError().message;
        EXPECT_EQ(read.mesh.points[0][0], 4503599627370497.0);
        EXPECT_EQ(read.mesh.triangles, (std::vector<Triangle>{ { 0, 1, 2 } }));
        ASSERT_EQ(read.mesh.attributes.size(), 1U);
        EXPECT_EQ(read.mesh.attributes[0].type, AttributeType::UInt64);
        EXPECT_EQ(read.mesh.attributes[0].Get(2, 0), 9);
        if (type == "float" || type == "double")
        {
          ExpectError(emit(1.5), "face 0");
        }
      }
    }
  }
}

TEST(PlyReader, NamesWhereATruncatedFileEnds)
{
  const auto expectTruncated =
    [](const std::string& bytes, const std::string& what, std::size_t byte)
  {
    ExpectError(bytes, what);
    ExpectError(bytes, "byte " + std::to_string(byte));
  };
  // In a text, the error names the end of the file. For a binary record that is cut off, it names
  // where the record begins.
  const std::string text = asciiVertices + "end_header\n0 0 0\n1 0";
  expectTruncated(text, "vertex 1 of 4", text.size());
  expectTruncated(asciiVertices + "end_header\n", "vertex 0 of 4", asciiVertices.size() + 11);
  const std::string faces = WithFaces(2, "3 0 1 2\n");
  expectTruncated(faces, "face 1 of 2", faces.size());
  const std::string binary =
    BinaryPoints({ { 1, 2, 3 }, { 4, 5, 6 }, { 7, 8, 9 } }, EmitEncoding::LittleEndian);
  expectTruncated(binary.substr(0, binary.size() - 1), "vertex 2 of 3", binary.size() - 16);
  // An element that is skipped is truncated.
  const std::string cameras =
    "ply\nformat binary_little_endian 1.0\nelement camera 9223372036854775808\nproperty int f\n"
    "element vertex 1\nproperty float x\nproperty float y\nproperty float "
    "z\nend_header\n12345678ab";
  expectTruncated(cameras, "camera 2 of 9223372036854775808", cameras.size() - 2);
  // The list is complete, but the value after it is not.
  const std::string face =
    BinaryWithFace("property list uchar int vertex_indices\nproperty float quality\n",
      "\3" + std::string(12, '\0') + "123");
  expectTruncated(face, "face 0 of 1", face.size() - 3);
  const std::string most =
    "ply\nformat ascii 1.0\nelement vertex 4294967294\nproperty float x\nproperty float y\n"
    "property float z\nend_header\n";
  expectTruncated(most, "vertex 0 of 4294967294", most.size());
}

// Files of every encoding, cut off at every byte, give an error and no crash.
TEST(PlyReader, RefusesEveryTruncation)
{
  for (const EmitEncoding encoding :
    { EmitEncoding::Ascii, EmitEncoding::LittleEndian, EmitEncoding::BigEndian })
  {
    EmitStyle style;
    style.encoding = encoding;
    const std::string bytes = PlyEmitter(style).Emit(
      { { "vertex", { { "x", "float", "" }, { "y", "float", "" }, { "z", "float", "" } },
          { { { 0.5 }, { 1 }, { 2 } }, { { 3 }, { 4 }, { 5 } }, { { 6 }, { 7 }, { 8 } } } },
        { "face", { { "flag", "short", "" }, { "vertex_indices", "int", "uchar" } },
          { { { 1 }, { 0, 1, 2 } }, { { 10 }, { 0, 1, 2, 2 } } } } });
    EXPECT_TRUE(ReadBytes(bytes).status);
    // An ASCII file is complete without its last line break.
    const std::size_t whole = bytes.size() - (encoding == EmitEncoding::Ascii ? 1 : 0);
    for (std::size_t length = 0; length < whole; ++length)
    {
      const Contents read = ReadBytes(std::string_view(bytes).substr(0, length));
      EXPECT_FALSE(read.status) << length << " of " << bytes.size();
    }
  }
}

TEST(PlyReader, RefusesHeadersWithoutAMesh)
{
  const std::string format = "ply\nformat ascii 1.0\n";
  const std::string xy = "element vertex 1\nproperty float x\nproperty float y\n";
  ExpectError(format + "element face 1\nproperty list uchar int vertex_indices\nend_header\n",
    "element 'vertex'");
  ExpectError(format + xy + "end_header\n1 2\n", "element 'vertex'");
  ExpectError(
    format + xy + "property list uchar float z\nend_header\n", "property 'z' of element 'vertex'");
  const std::string xyz = format + xy + "property float z\n";
  ExpectError(xyz + "element face 1\nproperty int flag\nend_header\n", "element 'face'");
  ExpectError(xyz + "element face 1\nproperty int vertex_indices\nend_header\n",
    "property 'vertex_indices' of element 'face'");
  ExpectError(xyz + "element face 1\nproperty list uchar int vertex_indices\nproperty list uchar "
                    "int vertex_index\nend_header\n",
    "element 'face'");
  ExpectError(format + "element vertex 9223372036854775808\nproperty float x\nproperty float "
                       "y\nproperty float z\nend_header\n",
    "", ErrorCode::LimitExceeded);
  ExpectError(format + "element vertex 4294967295\nproperty float x\nproperty float y\nproperty "
                       "float z\nend_header\n",
    "", ErrorCode::LimitExceeded);
}

// In files with more vertices than a signed index can count, a negative index is still not valid.
TEST(PlyReader, TakesNoNegativeIndexForALargeOne)
{
  const fixtures::TemporaryFolder folder;
  const std::string head =
    "ply\nformat binary_little_endian 1.0\nelement face 1\nproperty list uchar int vertex_indices\n"
    "element vertex 4294967294\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  const auto file = folder.Write(
    "negative.ply", head + "\3" + std::string(8, '\0') + std::string("\xf0\xff\xff\xff", 4));
  Result<std::unique_ptr<MeshReader>> reader = MeshReader::Open(file);
  ASSERT_TRUE(reader);
  Mesh mesh;
  const Result<std::size_t> read = (*reader)->ReadTriangles(mesh, 1);
  ASSERT_FALSE(read);
  EXPECT_TRUE(fixtures::FailsAt(read, ErrorCode::InvalidInput, "face 0"));
}

}
