// SPDX-License-Identifier: BSD-3-Clause
// PlyHeader: the lines of a header, and every way in which one can be wrong.
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/meshio/ply/PlyHeader.h"

#include <gtest/gtest.h>

namespace kdstream::test
{

namespace
{

Result<PlyHeader> Parse(std::string_view text, std::uint64_t* bodyAt = nullptr)
{
  const fixtures::TemporaryFolder folder;
  Result<ByteSource> source = ByteSource::Open(folder.Write("header.ply", text));
  EXPECT_TRUE(source);
  Result<PlyHeader> header = ReadPlyHeader(*source);
  if (bodyAt != nullptr)
  {
    *bodyAt = source->Position();
  }
  return header;
}

void ExpectError(std::string_view text, std::string_view place = {})
{
  EXPECT_TRUE(fixtures::FailsAt(Parse(text), ErrorCode::InvalidInput, place));
}

const std::string start = "ply\nformat ascii 1.0\n";

}

TEST(PlyHeader, ReadsElementsPropertiesAndWhereTheBodyBegins)
{
  for (const std::string newline : { "\n", "\r\n", "\r" })
  {
    std::string text =
      "ply\ncomment before\nformat binary_big_endian 1.0\nobj_info a b c\n\n"
      "element vertex 18446744073709551615\n  property  double\tx \n"
      "property list uint8 int32 vertex_index\nelement face 0\ncomment end\nend_header\n";
    for (std::size_t at = text.find('\n'); at != std::string::npos;
         at = text.find('\n', at + newline.size()))
    {
      text.replace(at, 1, newline);
    }
    std::uint64_t bodyAt = 0;
    const Result<PlyHeader> header = Parse(text + "\n\r\n", &bodyAt);
    ASSERT_TRUE(header) << header.GetError().message;
    EXPECT_EQ(bodyAt, text.size());
    EXPECT_EQ(header->encoding, PlyEncoding::BinaryBigEndian);
    ASSERT_EQ(header->elements.size(), 2U);
    const PlyElement& vertex = header->elements[0];
    EXPECT_EQ(vertex.name, "vertex");
    EXPECT_EQ(vertex.count, 18446744073709551615U);
    ASSERT_EQ(vertex.properties.size(), 2U);
    EXPECT_EQ(vertex.properties[0].name, "x");
    EXPECT_EQ(vertex.properties[0].type, AttributeType::Float64);
    EXPECT_FALSE(vertex.properties[0].isList);
    EXPECT_TRUE(vertex.properties[1].isList);
    EXPECT_EQ(vertex.properties[1].countType, AttributeType::UInt8);
    EXPECT_EQ(vertex.properties[1].type, AttributeType::Int32);
    EXPECT_EQ(vertex.Find("vertex_index"), 1U);
    EXPECT_EQ(vertex.Find("z"), 2U);
    EXPECT_EQ(header->elements[1].count, 0U);
  }
}

TEST(PlyHeader, NamesMayHaveBlanks)
{
  const Result<PlyHeader> header =
    Parse(start + "element vertex 1\nproperty float  scalar_Scalar  field #2 \nproperty list uchar "
                  "int all corners\nend_header\n");
  ASSERT_TRUE(header) << header.GetError().message;
  ASSERT_EQ(header->elements[0].properties.size(), 2U);
  EXPECT_EQ(header->elements[0].properties[0].name, "scalar_Scalar  field #2");
  EXPECT_EQ(header->elements[0].properties[1].name, "all corners");
}

TEST(PlyHeader, KnowsBothNamesOfEveryType)
{
  const std::vector<std::pair<std::string, std::size_t>> types{ { "char", 1 }, { "uchar", 1 },
    { "short", 2 }, { "ushort", 2 }, { "int", 4 }, { "uint", 4 }, { "int64", 8 }, { "uint64", 8 },
    { "float", 4 }, { "double", 8 }, { "int8", 1 }, { "uint8", 1 }, { "int16", 2 }, { "uint16", 2 },
    { "int32", 4 }, { "uint32", 4 }, { "int64", 8 }, { "uint64", 8 }, { "float32", 4 },
    { "float64", 8 } };
  for (std::size_t i = 0; i < types.size(); ++i)
  {
    const Result<PlyHeader> header =
      Parse(start + "element vertex 1\nproperty " + types[i].first + " x\nend_header\n");
    ASSERT_TRUE(header) << types[i].first;
    const AttributeType type = header->elements[0].properties[0].type;
    EXPECT_EQ(PlyTypeName(type), types[i % 10].first);
    EXPECT_EQ(SizeOf(type), types[i].second);
  }
}

TEST(PlyHeader, RefusesWhatIsNotAHeader)
{
  ExpectError("");
  ExpectError("solid cube\n");
  ExpectError("ply");
  ExpectError("plyx\n");
  ExpectError(std::string(100, '\0'));
  ExpectError(start + "element vertex 1\n");
  ExpectError(start + "end_header");
  ExpectError(start + "comment " + std::string(2 << 20, 'x') + "\nend_header\n");
  ExpectError("ply\nelement vertex 1\nend_header\n");
}

TEST(PlyHeader, RefusesBadLinesByNumber)
{
  ExpectError(start + "vertex 8\n", "header line 3: unknown word 'vertex'");
  ExpectError(start + "format ascii 1.0\n", "header line 3");
  ExpectError("ply\nformat ascii\n", "header line 2");
  ExpectError("ply\nformat binary 1.0\n", "header line 2: unknown format 'binary'");
  ExpectError("ply\nformat ascii 2.0\n", "header line 2: unknown version '2.0'");
  ExpectError(start + "element vertex\n", "header line 3");
  for (const std::string count :
    { "-1", "1.5", "eight", "18446744073709551616", "+5", "0x10", "8,000" })
  {
    ExpectError(
      start + "element vertex " + count + "\n", "header line 3: the count '" + count + "'");
  }
  ExpectError(start + "property float x\n", "header line 3");
  const std::string vertex = start + "element vertex 1\nproperty float x\n";
  ExpectError(vertex + "element vertex 2\n", "header line 5");
  ExpectError(start + "element Face 1\nelement face 2\n", "header line 4");
  ExpectError(vertex + "property float\n", "header line 5");
  ExpectError(vertex + "property\n", "header line 5");
  ExpectError(vertex + "property list uchar vertex_index\n", "header line 5");
  ExpectError(vertex + "property real y\n", "header line 5: unknown type 'real'");
  ExpectError(vertex + "property list size int y\n", "header line 5: unknown type 'size'");
  ExpectError(vertex + "property list uchar index y\n", "header line 5: unknown type 'index'");
  ExpectError(vertex + "property float \x1b[2J\n", "header line 5: the name '?[2J'");
  ExpectError(start + "element " + std::string(1100, 'a') + " 1\n",
    "header line 3: the name '" + std::string(40, 'a') + "…'");
}

}
