// SPDX-License-Identifier: BSD-3-Clause
// The STL reader: random soups in every notation are read back exactly, with any chunk size.
// Handwritten files test what random ones do not reach. Every error names its place.
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/meshio/MeshWriter.h"
#include "filters/meshio/Testing/RandomStl.h"
#include "filters/meshio/Testing/ReadAll.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace kdstream::test
{

namespace
{

Contents ReadBytes(std::string_view bytes)
{
  const fixtures::TemporaryFolder folder;
  return ReadAll(folder.Write("bytes.stl", bytes), [] { return everything; });
}

void ExpectError(
  std::string_view bytes, std::string_view place = {}, ErrorCode code = ErrorCode::InvalidInput)
{
  EXPECT_TRUE(fixtures::FailsAt(ReadBytes(bytes).status, code, place));
}

const std::string oneFacet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
                             "vertex 0 1 0\nendloop\nendfacet\n";
const std::vector<Vec3> onePlace{ { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } };

}

TEST(StlReader, ReadsRandomFilesBack)
{
  for (unsigned seed = 0; seed < 400; ++seed)
  {
    ExpectReadBack<RandomStlMaker>("random.stl", seed, 12, 7);
  }
}

// Corners with equal numbers are joined: 0.0 and -0.0 are the same place.
TEST(StlReader, NegativeZerosAreZeros)
{
  std::string facet = oneFacet;
  facet.replace(facet.find("vertex 0 0 0"), 12, "vertex -0 0 -0.0");
  const Contents text = ReadBytes("solid a\n" + facet + "endsolid a\n");
  ASSERT_TRUE(text.status) << text.status.GetError().message;
  EXPECT_TRUE(SameBits(text.mesh.points, onePlace));
  std::string bytes(84, '\0');
  bytes[80] = 1;
  for (const float value : { 0.F, 0.F, 1.F, -0.F, 0.F, -0.F, 1.F, 0.F, 0.F, 0.F, 1.F, -0.F })
  {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
  }
  const Contents binary = ReadBytes(bytes + std::string(2, '\0'));
  ASSERT_TRUE(binary.status) << binary.status.GetError().message;
  EXPECT_TRUE(SameBits(binary.mesh.points, onePlace));
}

// The file has several blocks and many batches.
TEST(StlReader, ReadsLargeFilesBack)
{
  for (unsigned seed = 400; seed < 412; ++seed)
  {
    ExpectReadBack<RandomStlMaker>("random.stl", seed, 40000, 5000);
  }
}

TEST(StlReader, ReadsWhatTheWriterWrites)
{
  Mesh mesh;
  mesh.points = { { 0, 0, 0 }, { 1, 0, 0.1F }, { 0, 1, 0 }, { 1, 1, 7 } };
  mesh.triangles = { { 0, 1, 2 }, { 1, 3, 2 }, { 3, 3, 3 } };
  const fixtures::TemporaryFolder folder;
  ASSERT_TRUE(WriteMesh(folder / "m.stl", mesh));
  const Contents read = ReadAll(folder / "m.stl", [] { return std::size_t{ 2 }; });
  ASSERT_TRUE(read.status);
  ASSERT_EQ(read.mesh.points.size(), 9U);
  for (std::size_t i = 0; i < 9; ++i)
  {
    EXPECT_EQ(read.mesh.points[i], mesh.points[mesh.triangles[i / 3][i % 3]]);
  }
}

TEST(StlReader, DoublesOnlyWhereFloatsWouldLoseDecimals)
{
  const auto typeOf = [](const std::string& number)
  {
    std::string facet = oneFacet;
    facet.replace(facet.find("vertex 1") + 7, 1, number);
    return ReadBytes("solid\n" + facet + "endsolid\n").info.scalarType;
  };
  EXPECT_EQ(typeOf("4000000.4565"), ScalarType::Float64);
  EXPECT_EQ(typeOf("0.123456789"), ScalarType::Float64);
  EXPECT_EQ(typeOf("16777217"), ScalarType::Float64);
  EXPECT_EQ(typeOf("1e-60"), ScalarType::Float64);
  EXPECT_EQ(typeOf("4.000000e+06"), ScalarType::Float32);
  EXPECT_EQ(typeOf("16777216"), ScalarType::Float32);
  EXPECT_EQ(typeOf("-0.100000001"), ScalarType::Float32);
}

TEST(StlReader, BinaryFilesMayBeginWithSolid)
{
  const Contents read = ReadBytes(BinaryStl("solid ascii\n" + oneFacet, onePlace));
  ASSERT_TRUE(read.status) << read.status.GetError().message;
  EXPECT_TRUE(SameBits(read.mesh.points, onePlace));
  // A binary file without its last byte is still recognised as binary.
  const std::string whole = BinaryStl("solid exported", onePlace);
  ExpectError(whole.substr(0, whole.size() - 1));
  // Only the triangle shows that this is not a text.
  ExpectError("solid" + std::string(75, ' ') + "\xFE\xFF\xFF\xFF" + whole.substr(84));
}

TEST(StlReader, EmptySoupsAreMeshesWithoutVertices)
{
  for (const std::string& bytes : { BinaryStl("", {}), std::string("solid\nendsolid"),
         std::string("solid a\nendsolid a\nsolid b\nendsolid b\n") })
  {
    const Contents read = ReadBytes(bytes);
    EXPECT_TRUE(read.status);
    EXPECT_EQ(read.info.vertices + read.info.faces, 0U);
  }
}

// Quads and other polygons are cut as in other formats; loops of one or two vertices are dropped.
TEST(StlReader, ReadsLoopsOfAnyNumberOfVertices)
{
  const auto facet = [](const std::string& vertices)
  { return "facet normal 0 0 1\nouter loop\n" + vertices + "endloop\nendfacet\n"; };
  const std::string quad =
    "vertex 0.0D+00 0 0\nvertex 2.0D+00 0 0\nvertex 2 2.5d-1 0\nvertex 0 .25D0 0\n";
  const std::string arrow = "vertex 0 0 1\nvertex 4 -4 1\nvertex 1 0 1\nvertex 4 4 1\n";
  const std::string text = "solid a\n" + facet("vertex 0 0 0\nvertex 1 0 0\n") + facet(quad) +
                           facet("") + oneFacet + facet(arrow) + facet("vertex 7 7 nan\n") +
                           "endsolid a\n";
  const std::vector<Vec3> expected{ { 0, 0, 0 }, { 2, 0, 0 }, { 2, 0.25, 0 }, { 0, 0, 0 },
    { 2, 0.25, 0 }, { 0, 0.25, 0 }, { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } };
  const fixtures::TemporaryFolder folder;
  for (const std::size_t limit : { everything, std::size_t{ 1 }, std::size_t{ 4 } })
  {
    const Contents read = ReadAll(folder.Write("m.stl", text), [&] { return limit; });
    ASSERT_TRUE(read.status) << read.status.GetError().message;
    EXPECT_EQ(read.info.faces, 5U);
    ASSERT_EQ(read.mesh.points.size(), 15U);
    EXPECT_EQ(read.mesh.triangles.size(), 5U);
    EXPECT_TRUE(std::equal(expected.begin(), expected.end(), read.mesh.points.begin()));
    double area = 0; // area of the arrow: its notch stays empty
    for (std::size_t i = 9; i < 15; i += 3)
    {
      const Vec3* const p = read.mesh.points.data() + i;
      area +=
        ((p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[2][0] - p[0][0]) * (p[1][1] - p[0][1])) / 2;
    }
    EXPECT_EQ(area, 4);
    EXPECT_EQ(read.info.tolerance.Of(Lapse::FaceTooSmall), 3U);
    EXPECT_EQ(read.info.tolerance.Warnings(),
      (std::vector<std::string>{
        "3 faces have fewer than three corners and are dropped; the first: facet 0, of 2" }));
  }
  // If a vertex of a polygon is not finite, all triangles of the polygon are dropped.
  const std::string bad = "solid a\n" + facet(arrow) + facet("vertex 9 nan 9\n" + quad) + oneFacet;
  for (const std::size_t limit : { everything, std::size_t{ 1 } })
  {
    const Contents read = ReadAll(folder.Write("m.stl", bad), [&] { return limit; });
    ASSERT_TRUE(read.status) << read.status.GetError().message;
    EXPECT_EQ(read.mesh.triangles.size(), 3U);
    EXPECT_EQ(read.info.tolerance.Of(Lapse::PointNotFinite), 1U);
  }
}

// Facets are dropped as a whole, whichever of their vertices is not finite, and with any chunk
// size.
TEST(StlReader, DropsFacetsThatAreNotFinite)
{
  std::vector<Vec3> points;
  for (int i = 0; i < 30; ++i)
  {
    points.push_back({ double(i), 2, 3 });
  }
  const std::string binary = BinaryStl("", points);
  std::vector<Vec3> bad = points;
  bad[7][1] = std::nan("");
  bad[9][0] = bad[11][2] = std::numeric_limits<double>::infinity();
  std::string text = "solid\n";
  for (std::size_t i = 0; i < bad.size(); i += 3)
  {
    text += "facet normal 0 0 1\nouter loop\n";
    for (std::size_t k = i; k < i + 3; ++k)
    {
      text += "vertex " + std::to_string(bad[k][0]) + " " + std::to_string(bad[k][1]) + " " +
              std::to_string(bad[k][2]) + "\n";
    }
    text += "endloop\nendfacet\n";
  }
  const fixtures::TemporaryFolder folder;
  for (const std::string& bytes : { BinaryStl("", bad), text + "endsolid\n" })
  {
    for (const std::size_t limit : { everything, std::size_t{ 1 }, std::size_t{ 4 } })
    {
      const Contents read = ReadAll(folder.Write("m.stl", bytes), [&] { return limit; });
      ASSERT_TRUE(read.status) << read.status.GetError().message;
      ASSERT_EQ(read.mesh.points.size(), 24U);
      ASSERT_EQ(read.mesh.triangles.size(), 8U);
      EXPECT_EQ(read.info.tolerance.Warnings(),
        (std::vector<std::string>{
          "3 points are not finite and are dropped; the first: vertex 1 of facet 2",
          "2 faces are dropped with the points that are not finite; the first: face 2" }));
      for (std::size_t i = 0; i < 24; ++i)
      {
        const Triangle& t = read.mesh.triangles[i / 3];
        EXPECT_EQ(read.mesh.points[t[i % 3]], points[i < 6 ? i : i + 6]);
      }
    }
  }
}

TEST(StlReader, ReadsWhatFollowsTheEnd)
{
  const std::string binary = BinaryStl("solid exported", onePlace);
  const auto warnings = [](const std::string& bytes)
  {
    const Contents read = ReadBytes(bytes);
    EXPECT_TRUE(read.status) << read.status.GetError().message;
    EXPECT_TRUE(SameBits(read.mesh.points, onePlace));
    return read.info.tolerance.Warnings();
  };
  const std::string where = "; the first: byte 134, after the 1 triangles that the header counts";
  EXPECT_EQ(warnings(binary + "xy"),
    (std::vector<std::string>{ "2 bytes after the end are not read" + where }));
  EXPECT_EQ(warnings(binary + std::string(378, '\0')),
    (std::vector<std::string>{ "378 zeros after the end are padding" + where }));
  const std::vector<std::string> none;
  const std::string text = "solid a\n" + oneFacet + "endsolid a\n";
  EXPECT_EQ(warnings(text + "\x1A"), none);
  EXPECT_EQ(warnings(text + "\x1A\r\n"), none);
  EXPECT_EQ(warnings("\xEF\xBB\xBF" + text), none);
  EXPECT_EQ(warnings(text + std::string(7, '\0')),
    (std::vector<std::string>{ "7 zeros after the end are padding" }));
}

TEST(StlReader, NamesAttributeBytes)
{
  std::string binary = BinaryStl("exported", onePlace);
  binary.replace(binary.size() - 2, 2, 2, '\0');
  EXPECT_TRUE(ReadBytes(binary).info.ignoredAttributes.empty());
  binary.back() = '\x80';
  EXPECT_EQ(ReadBytes(binary).info.ignoredAttributes,
    std::vector<std::string>{ "attribute bytes of triangles (colours, mostly)" });
  std::string colored = BinaryStl("COLOR=abcd", onePlace);
  colored.replace(colored.size() - 2, 2, 2, '\0');
  EXPECT_EQ(ReadBytes(colored).info.ignoredAttributes,
    std::vector<std::string>{ "the colour in the header (COLOR=)" });
}

TEST(StlReader, CountsThatAreTooSmallOrNotKnown)
{
  const std::string binary = BinaryStl("exported", onePlace);
  const std::string facet = binary.substr(84);
  const std::string two = " points or faces are in the file but its header does not count them; ";
  {
    const Contents read = ReadBytes(binary + facet + facet);
    EXPECT_EQ(read.mesh.triangles.size(), 1U);
    EXPECT_EQ(read.info.tolerance.Warnings(),
      std::vector<std::string>{ "2" + two +
                                "the first: byte 134, after the 1 triangles that the "
                                "header counts; only these are read" });
  }
  for (const std::string& count : { std::string(4, '\0'), std::string(4, '\xFF') })
  {
    const Contents read = ReadBytes(binary.substr(0, 80) + count + facet + facet);
    ASSERT_TRUE(read.status) << read.status.GetError().message;
    EXPECT_EQ(read.mesh.triangles.size(), 2U);
    EXPECT_EQ(read.info.tolerance.Of(Lapse::NotCounted), 2U);
  }
}

TEST(StlReader, EndsMayBeTwoWords)
{
  std::string facet = oneFacet;
  facet.replace(facet.find("endloop"), 7, "end loop");
  facet.replace(facet.find("endfacet"), 8, "END Facet");
  std::string joined = oneFacet;
  joined.replace(joined.find("outer loop"), 10, "outerloop");
  for (const std::string& text : { "solid a b\n" + facet + "end solid a b\n",
         "solid\n" + joined + "endsolid\n", "solid\r" + oneFacet + "endsolid\r" })
  {
    const Contents read = ReadBytes(text);
    ASSERT_TRUE(read.status) << read.status.GetError().message;
    EXPECT_TRUE(SameBits(read.mesh.points, onePlace));
  }
  ExpectError("solid a\n" + oneFacet + "end of it", "facet 1: 'of'");
}

TEST(StlReader, ReadsTextsOfOtherPrograms)
{
  const auto read = [](const std::string& bytes, std::size_t facets)
  {
    SCOPED_TRACE(bytes);
    Contents contents = ReadBytes(bytes);
    EXPECT_TRUE(contents.status) << contents.status.GetError().message;
    EXPECT_EQ(contents.mesh.triangles.size(), facets);
    EXPECT_TRUE(
      contents.mesh.points.size() == 3 * facets &&
      SameBits({ contents.mesh.points.begin(), contents.mesh.points.begin() + 3 }, onePlace));
    return contents.info;
  };
  std::string line = oneFacet;
  std::replace(line.begin(), line.end(), '\n', ' ');
  const std::string bare = "facet" + line.substr(18);
  std::string joined = bare;
  joined.replace(joined.find("outer loop"), 10, "OuterLoop");
  std::string capitals = "solid A\n" + oneFacet + "endsolid A\n";
  std::transform(capitals.begin(), capitals.end(), capitals.begin(),
    [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; });
  const std::vector<std::string> none;
  for (const auto& [bytes, facets] : { std::pair{ "solid a b " + line + line + "endsolid a b", 2U },
         { "solid " + line + "endsolid solid b " + line + "endsolid b", 2U },
         { "solid facet normal\n" + oneFacet + "endsolid facet\nsolid b\n" + oneFacet + "endsolid",
           2U },
         { capitals + capitals, 2U },
         { "solid a " + bare + line + "endsolid solid b " + bare + "endsolid", 3U },
         { "solid outer vertex " + joined + "endsolid outer", 1U },
         { "solid outer loops\n" + oneFacet + "endsolid vertex\n", 1U },
         { "solid a\nfacet" + oneFacet.substr(18) + "endsolid a\n", 1U },
         { "\xEF\xBB\xBF\n \n" + capitals, 1U } })
  {
    const MeshFileInfo info = read(bytes, facets);
    EXPECT_EQ(info.tolerance.Warnings(), none);
    EXPECT_EQ(info.ignoredAttributes, none);
  }
  for (const auto& [bytes, ends] : { std::pair{ "solid a\n" + oneFacet + oneFacet, 1U },
         { "solid a\n" + oneFacet + "solid b\n" + oneFacet + "endsolid b\n", 1U },
         { "solid a " + line + "solid b " + line, 2U } })
  {
    const MeshFileInfo info = read(bytes, 2);
    EXPECT_EQ(info.tolerance.Of(Lapse::EndMissing), ends);
  }
  for (const std::string& bytes : { "solid a\ncolor 1 0.5 0\n" + oneFacet + "endsolid a\n",
         "solid a\n" + oneFacet + "COLOR 1 0 0\nendsolid a\n",
         "solid\ncolor 1 0 0 " + line + "endsolid",
         "solid a\n" + oneFacet + "endsolid a\nMade by hand\n",
         "solid a\n# by hand\n" + oneFacet + "endsolid a\n" })
  {
    const MeshFileInfo info = read(bytes, 1);
    EXPECT_EQ(info.tolerance.Warnings(), none);
    ASSERT_EQ(info.ignoredAttributes.size(), 1U);
    EXPECT_EQ(info.ignoredAttributes[0].find("words between facets that STL does not have ('"), 0U);
  }
  // A facet with a damaged first word is an error: it is not skipped.
  for (const auto& [begin, message] :
    { std::pair{ "solid a\n" + oneFacet, "facet 1: 'faset' where 'facet' or 'endsolid' is" },
      { "solid a\n# remark ", "facet 0: '#' where 'facet' or 'endsolid' is" },
      { "solid a " + line + "color 1 0 0 ", "facet 1: 'color' where 'facet' or 'endsolid' is" },
      { std::string("solid a "), "facet 0: 'outer' where 'facet' or 'endsolid' is" },
      { "solid a\n" + oneFacet + "endsolid a ", "facet 1: 'outer' where 'solid' is" } })
  {
    for (const std::string& facet : { "faset" + line.substr(5), "faset" + bare.substr(5) })
    {
      SCOPED_TRACE(begin + facet);
      const Contents damaged = ReadBytes(begin + facet + "\nendsolid a\n");
      ASSERT_FALSE(damaged.status);
      EXPECT_EQ(damaged.status.GetError().message.find(message), 0U)
        << damaged.status.GetError().message;
    }
  }
  ExpectError("solid a\nfacett" + oneFacet.substr(5) + "endsolid\n", "facet 0: 'outer'");
}

TEST(StlReader, SaysWhatIsWrongAndWhere)
{
  ExpectError("");
  ExpectError("soli");
  ExpectError(oneFacet + "endsolid\n");
  ExpectError(std::string(84, 'x'));
  ExpectError(std::string(80, '\0') + "\xff\xff\xff\xff" + std::string(500, '\0'));
  ExpectError(std::string(80, 'x') + std::string("\1\0\0\0", 4) + std::string(51, '\xFF'));
  ExpectError(std::string(80, '\0') + std::string(4 + 51, '\0'));
  ExpectError("solid a", "facet 0: 'facet'");
  ExpectError("solid a\n" + oneFacet.substr(0, 56), "facet 0: 'vertex'");
  ExpectError("solid a\n" + oneFacet + "facet abnormal", "facet 1: 'abnormal'");
  ExpectError("solid a\n" + oneFacet + "endsolid\nfacet", "facet 1: 'facet'");
  const auto with = [](const std::string& number)
  {
    std::string facet = oneFacet;
    facet.replace(facet.find("vertex 1 0") + 9, 1, number);
    return "solid a\n" + oneFacet + facet + "endsolid\n";
  };
  ExpectError(with("x"), "facet 1: vertex 1: y 'x'");
  ExpectError(with("1e999"), "facet 1: vertex 1: y '1e999'");
  ExpectError(with("0 0 edge 0 0"), "facet 1: 'edge'");
}

TEST(StlReader, CanBeCancelledWhileItCounts)
{
  const fixtures::TemporaryFolder folder;
  Execution execution;
  execution.progress = [](std::string_view step, double) { return step != "read"; };
  const auto reader =
    MeshReader::Open(folder.Write("a.stl", "solid\n" + oneFacet + "endsolid\n"), execution);
  ASSERT_FALSE(reader);
  EXPECT_EQ(reader.GetError().code, ErrorCode::Cancelled);
}

}
