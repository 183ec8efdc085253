// SPDX-License-Identifier: BSD-3-Clause
// The OFF reader: reads what programs write into OFF files, and its errors name their place.
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/meshio/Testing/RandomOff.h"
#include "filters/meshio/Testing/ReadAll.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace kdstream::test
{

namespace
{

Contents ReadBytes(std::string_view bytes, std::size_t limit = everything)
{
  const fixtures::TemporaryFolder folder;
  return ReadAll(folder.Write("bytes.off", bytes), [limit] { return limit; });
}

void ExpectError(
  std::string_view bytes, std::string_view place = {}, ErrorCode code = ErrorCode::InvalidInput)
{
  EXPECT_TRUE(fixtures::FailsAt(ReadBytes(bytes).status, code, place));
}

std::vector<double> Values(const Mesh& mesh, const std::string& name)
{
  std::vector<double> values;
  for (const Attribute& attribute : mesh.attributes)
  {
    for (std::size_t i = 0; attribute.name == name && i < attribute.TupleCount(); ++i)
    {
      for (std::size_t k = 0; k < attribute.components; ++k)
      {
        values.push_back(attribute.Get(i, k));
      }
    }
  }
  return values;
}

const std::string square = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n", faces = "3 0 1 2\n3 0 2 3\n";
const std::vector<Vec3> corners{ { 0, 0, 0 }, { 1, 0, 0 }, { 1, 1, 0 }, { 0, 1, 0 } };
const std::vector<Triangle> triangles{ { 0, 1, 2 }, { 0, 2, 3 } };

}

TEST(OffReader, ReadsHeadersAsProgramsWriteThem)
{
  std::string returns = "OFF\n4 2 0\n" + square + faces;
  std::replace(returns.begin(), returns.end(), '\n', '\r');
  for (const std::string& bytes : { "OFF\n4 2 0\n" + square + faces, "OFF 4 2 5\n" + square + faces,
         "OFF4 2 0\n" + square + faces, "off\n4 2\n" + square + faces,
         "\xEF\xBB\xBFOFF\n# by hand\n4 2 0 # counts\n\n#\n" + square + "# faces\n" + faces +
           "# end\n",
         "\n# first\nOFF\n4\n2 0\n" + square + faces + "\n\n", "nOFF 3\n4 2 0\n" + square + faces,
         "OFF\n4 2 0\n" + square + "3\n0 1 2\n3\n0 2 3", "OFF\n4 2 0\n" + square + faces + "\x1A",
         "OFF\n4\n2\n5\n" + square + faces, "OFF\n4 2 # edges:\n\n5 # of no use\n" + square + faces,
         "OFF\n4\n2\n" + square + faces,
         std::string("OFF\n4 2 0\n# a\n# b\n  # c\n# d\n0 0 0 1 0 0 1 1 0 0 1 0\n# e\n"
                     "3 0 1 2 3 0 2 3\n"),
         returns, std::string("OFF\n4 2 0\n0 0 0 1 0 0 1 1 0 0 1 0\n3 0 1 2 3 0 2 3\n") })
  {
    SCOPED_TRACE(bytes);
    const Contents read = ReadBytes(bytes);
    ASSERT_TRUE(read.status) << read.status.GetError().message;
    EXPECT_EQ(read.mesh.points, corners);
    EXPECT_EQ(read.mesh.triangles, triangles);
    EXPECT_TRUE(read.mesh.attributes.empty());
    EXPECT_EQ(read.info.tolerance.Warnings(), std::vector<std::string>());
    EXPECT_TRUE(read.info.ignoredAttributes.empty());
  }
}

TEST(OffReader, ReadsNumbersAfterCoordinates)
{
  const struct
  {
    std::string bytes, array;
    std::vector<double> values;
    bool isReported;
  } cases[] = {
    { "COFF\n2 0 0\n0 0 0 255 128 0 255\n1 0 0 0 64 9 10\n", "RGBA",
      { 255, 128, 0, 255, 0, 64, 9, 10 }, false },
    { "COFF\n2 0 0\n0 0 0 2 128 0\n1 0 0 0 64 9\n", "RGB", { 2, 128, 0, 0, 64, 9 }, false },
    { "COFF\n2 0 0\n0 0 0 1 0.5 0 1\n1 0 0 0 1 0.2 1\n", "RGB", { 255, 128, 0, 0, 255, 51 }, true },
    { "COFF\n2 0 0\n0 0 0 1 0 0\n1 0 0 0 1 1\n", "RGB", { 255, 0, 0, 0, 255, 255 }, true },
    { "NOFF\n2 0 0\n0 0 0 0 0 1\n1 0 0 0 1 0\n", "Normals", { 0, 0, 1, 0, 1, 0 }, false },
    { "noff\n2 0 0\n0 0 0 0 0 1\n1 0 0 0 1 0\n", "Normals", { 0, 0, 1, 0, 1, 0 }, false },
    { "stcnoff\n1 0\n0\n0 0 0 0 0 1 9 8 7 0.5 1\n", "TCoords", { 0.5, 1 }, false },
    { "STOFF\n2 0 0\n0 0 0 0.5 1\n1 0 0 0 0.25\n", "TCoords", { 0.5, 1, 0, 0.25 }, false },
    { "STCNOFF\n1 0 0\n0 0 0 0 0 1 9 8 7 0.5 1\n", "RGB", { 9, 8, 7 }, false },
    { "NCOFF\n1 0 0\n0 0 0 9 8 7 255 0 0 1\n", "RGBA", { 9, 8, 7, 255 }, true },
    { "NCOFF\n1 0 0\n0 0 0 9 8 7 255 0 0 1\n", "Normals", { 0, 0, 1 }, true },
    { "CNOFF\n1 0 0\n0 0 0 0 0 1 9 8 7 255\n", "Normals", { 0, 0, 1 }, false },
  };
  for (const auto& c : cases)
  {
    SCOPED_TRACE(c.bytes);
    const Contents read = ReadBytes(c.bytes);
    ASSERT_TRUE(read.status) << read.status.GetError().message;
    EXPECT_EQ(Values(read.mesh, c.array), c.values);
    EXPECT_EQ(!read.info.tolerance.Warnings().empty(), c.isReported);
    EXPECT_TRUE(read.info.tolerance.Check(true));
  }
}

TEST(OffReader, ColoursOfFaces)
{
  const std::string begin = "OFF\n4 2 0\n" + square;
  const Contents bytes = ReadBytes(begin + "4 0 1 2 3 255 0 9\n3 0 2 3 1 2 3\n");
  ASSERT_TRUE(bytes.status) << bytes.status.GetError().message;
  EXPECT_EQ(Values(bytes.mesh, "RGB"), (std::vector<double>{ 255, 0, 9, 255, 0, 9, 1, 2, 3 }));
  const Contents some = ReadBytes(begin + "3 0 1 2 255 0 9\n3 0 2 3\n");
  ASSERT_TRUE(some.status) << some.status.GetError().message;
  EXPECT_EQ(some.mesh.triangles, triangles);
  EXPECT_EQ(some.info.tolerance.Of(Lapse::ValuesNotNamed), 1U);
}

TEST(OffReader, CountsWhatItDoesNotRead)
{
  const std::string begin = "OFF\n4 2 0\n" + square;
  const auto warnings = [](const std::string& bytes)
  {
    const Contents read = ReadBytes(bytes);
    EXPECT_TRUE(read.status) << read.status.GetError().message;
    return read.info.tolerance.Warnings();
  };
  EXPECT_EQ(warnings("OFF\n2 0 0\n0 0 0 1 2 3\n1 0 0 4 5 6\n"),
    (std::vector<std::string>{ "2 lines have more values than the header names: they are not read; "
                               "the first: vertex 0 (line 3)" }));
  EXPECT_EQ(warnings(begin + faces + "3 1 2 3\n"),
    (std::vector<std::string>{ "9 bytes after the end are not read; the first: byte 49, after "
                               "the last face that the header counts" }));
  EXPECT_EQ(warnings("OFF\n0\n0\n0\n\n"), std::vector<std::string>());
  EXPECT_EQ(warnings(begin + "2 0 1\n3 0 1 2\n"),
    (std::vector<std::string>{ "1 face has fewer than three corners and is dropped: face 0" }));
}

TEST(OffReader, DoublesOnlyWhereFloatsWouldLoseDecimals)
{
  EXPECT_EQ(ReadBytes("OFF\n1 0 0\n0.1 4.5 1e6\n").info.scalarType, ScalarType::Float32);
  EXPECT_EQ(ReadBytes("OFF\n1 0 0\n0.1 4000000.4565 1\n").info.scalarType, ScalarType::Float64);
}

TEST(OffReader, ChunksMakeNoDifference)
{
  for (unsigned seed = 0; seed < 100; ++seed)
  {
    SCOPED_TRACE("seed " + std::to_string(seed));
    RandomOffMaker maker(seed);
    const std::string bytes = maker.Make(12).bytes;
    const Contents whole = ReadBytes(bytes);
    ASSERT_TRUE(whole.status) << whole.status.GetError().message << "\n" << bytes;
    const Contents parts = ReadBytes(bytes, 1 + maker.Generator().Pick(4));
    ASSERT_TRUE(parts.status) << parts.status.GetError().message;
    EXPECT_TRUE(SameBits(whole.mesh.points, parts.mesh.points));
    EXPECT_EQ(whole.mesh.triangles, parts.mesh.triangles);
    ASSERT_EQ(whole.mesh.attributes.size(), parts.mesh.attributes.size());
    for (std::size_t k = 0; k < whole.mesh.attributes.size(); ++k)
    {
      EXPECT_EQ(whole.mesh.attributes[k].values, parts.mesh.attributes[k].values);
    }
    EXPECT_EQ(whole.info.tolerance.Warnings(), parts.info.tolerance.Warnings());
  }
}

TEST(OffReader, SaysWhatIsWrongAndWhere)
{
  const std::string begin = "OFF\n4 2 0\n" + square;
  for (const auto& [bytes, place] : {
         std::pair<std::string, std::string>{ "", "" },
         { "hello\n", "" },
         { "OFF\n", "line 2" },
         { "OFF\n4 x\n", "line 2: 'x'" },
         { "OFF\n4 2 0 7\n" + square + faces, "line 2" },
         { begin + "3 0 1 2\n3 0 2 4\n", "face 1 (line 8) names vertex 4" },
         { begin + "3 0 1 2\n", "byte 42" },
         { begin + "3 0 1 2\n3 0 2\n", "face 1 (line 8)" },
         { "OFF\n2 1 0\n0 0\n0 1 2\n3 0 0 0\n", "vertex 0 (line 3)" },
         { "OFF\n4 2 0\n0 0\n1 0 0\n1 1 0\n0 1 0\n" + faces + "3 0 1 3\n", "vertex 0 (line 3)" },
         { begin + "3 0 1\n2 3 0 2\n3 0 1 3\n", "face 0 (line 7)" },
         { "OFF\n4\n2\n5 7\n" + square + faces, "vertex 0 (line 4)" },
         { "OFF\n2 0 0\n0 0 0\n0 1,5 2\n", "vertex 1 (line 4): y '1,5'" },
       })
  {
    ExpectError(bytes, place);
  }
  for (const std::string& bytes : { std::string("OFF BINARY\n\0\0\0\4", 15),
         std::string("4OFF\n1 0 0\n1 2 3 1\n"), std::string("4nOFF\n3\n1 0 0\n1 2 3 1\n"),
         std::string("4off\n1 0 0\n1 2 3 1\n"), std::string("nOFF\n2\n1 0 0\n1 2\n") })
  {
    ExpectError(bytes, "", ErrorCode::Unsupported);
  }
}

}
