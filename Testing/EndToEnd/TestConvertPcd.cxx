// SPDX-License-Identifier: BSD-3-Clause
// kdstream-convert with PCL's point clouds: files written by PCL, and files with false claims.
#include "Testing/EndToEnd/ConvertTools.h"

#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

class TestConvertPcd : public ConvertTest
{
protected:
  // A scan with everything that it can have: colours, normals, curvature; organised, with holes.
  pcl::PointCloud<pcl::PointXYZRGBNormal> MakeScan()
  {
    pcl::PointCloud<pcl::PointXYZRGBNormal> cloud(8, 5);
    for (std::size_t i = 0; i < cloud.size(); ++i)
    {
      pcl::PointXYZRGBNormal& p = cloud[i];
      const auto f = static_cast<float>(i);
      p.x = i % 7 == 3 ? nan : f * 0.1F;
      p.y = i % 11 == 5 ? nan : -f;
      p.z = f / 3;
      p.r = static_cast<std::uint8_t>(i);
      p.g = static_cast<std::uint8_t>(100 + i);
      p.b = static_cast<std::uint8_t>(255 - i);
      p.normal_x = 0.25F * f;
      p.normal_y = 1;
      p.normal_z = -f;
      p.curvature = 0.5F * f;
    }
    cloud.is_dense = false;
    return cloud;
  }

  std::string Header(const std::string& points, const std::string& data,
    const std::string& width = "", const std::string& fields = "x y z",
    const std::string& sizes = "4 4 4", const std::string& types = "F F F",
    const std::string& counts = "1 1 1")
  {
    return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS " + fields + "\nSIZE " +
           sizes + "\nTYPE " + types + "\nCOUNT " + counts + "\nWIDTH " +
           (width.empty() ? points : width) + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " +
           points + "\nDATA " + data + "\n";
  }
};

}

// PCL supports neither lines that end with only \r, nor uncompressed points in a file that claims
// compression.
TEST_F(TestConvertPcd, FilesOfOtherProgramsAreRead)
{
  std::string text;
  std::vector<Vec3> points;
  std::array<std::string, 3> axes;
  for (int i = 0; i < 20; ++i)
  {
    points.push_back({ double(i), double(i * 7 % 5), 0.5 });
    for (std::size_t k = 0; k < 3; ++k)
    {
      const auto value = static_cast<float>(points.back()[k]);
      text += std::to_string(value) + (k < 2 ? " " : "\n");
      axes[k].append(reinterpret_cast<const char*>(&value), sizeof(value));
    }
  }
  const std::string all = axes[0] + axes[1] + axes[2];
  const auto size = static_cast<std::uint32_t>(all.size());
  std::string sizes(reinterpret_cast<const char*>(&size), sizeof(size));
  sizes += sizes;
  std::string returns = this->Header("20", "ascii") + text;
  std::replace(returns.begin(), returns.end(), '\n', '\r');
  for (const std::string& file : { returns, this->Header("20", "binary_compressed") + sizes + all })
  {
    this->WriteText("in.pcd", file);
    EXPECT_EQ(this->Converted("in.pcd").points, points);
  }
  std::string moved = this->Header("20", "ascii") + text;
  moved.replace(moved.find("0 0 0 1 0 0 0"), 13, "5 0 0 0.7 0 0 0.7");
  this->WriteText("in.pcd", moved);
  EXPECT_EQ(this
              ->Converted("in.pcd",
                "kdstream-convert: warning: in.pcd: its VIEWPOINT (the scanner's position) is not "
                "applied: the coordinates are read as they are written\n")
              .points,
    points);
  this->WriteText("in.pcd",
    this->Header("20", "binary_compressed") + std::string("\x05\0\0\0\xF0\0\0\0zzzzz", 13));
  this->ExpectError("in.pcd", "its compressed points are damaged: write it again");
}

TEST_F(TestConvertPcd, EachEncodingComesBack)
{
  const auto cloud = this->MakeScan();
  const std::string file = (this->Folder / "in.pcd").string();
  pcl::PCDWriter writer;
  for (int encoding = 0; encoding < 3; ++encoding)
  {
    SCOPED_TRACE(encoding);
    ASSERT_EQ(encoding == 0   ? writer.writeASCII(file, cloud, 9)
              : encoding == 1 ? writer.writeBinary(file, cloud)
                              : writer.writeBinaryCompressed(file, cloud),
      0);
    const Mesh read = this->Converted("in.pcd", "kdstream-convert: warning: in.pcd: 9 points are "
                                                "not finite and are dropped; the first: point 3\n");
    ASSERT_EQ(read.points.size(), 31U);
    EXPECT_EQ(read.scalarType, ScalarType::Float32);
    const std::vector<double> rgb = ValuesOf(read, "RGB"), normals = ValuesOf(read, "Normals"),
                              curvature = ValuesOf(read, "curvature");
    ASSERT_EQ(rgb.size(), 93U);
    ASSERT_EQ(normals.size(), 93U);
    ASSERT_EQ(curvature.size(), 31U);
    std::size_t at = 0;
    for (const auto& p : cloud)
    {
      if (std::isfinite(p.x) && std::isfinite(p.y))
      {
        EXPECT_EQ(read.points[at], (Vec3{ double(p.x), double(p.y), double(p.z) }));
        EXPECT_EQ(rgb[at * 3], p.r);
        EXPECT_EQ(rgb[at * 3 + 1], p.g);
        EXPECT_EQ(rgb[at * 3 + 2], p.b);
        EXPECT_EQ(normals[at * 3], double(p.normal_x));
        EXPECT_EQ(normals[at * 3 + 2], double(p.normal_z));
        EXPECT_EQ(curvature[at], double(p.curvature));
        ++at;
      }
    }
  }
}

TEST_F(TestConvertPcd, IntensityRgbaAndDoubles)
{
  pcl::PointCloud<pcl::PointXYZI> intensity(2, 1);
  intensity[0].intensity = 0.5F;
  intensity[1].intensity = 7;
  intensity[1].x = 1;
  ASSERT_EQ(pcl::io::savePCDFileBinary((this->Folder / "i.pcd").string(), intensity), 0);
  EXPECT_EQ(ValuesOf(this->Converted("i.pcd"), "intensity"), (std::vector{ 0.5, 7.0 }));
  pcl::PointCloud<pcl::PointXYZRGBA> rgba(1, 1);
  rgba[0].r = 1;
  rgba[0].g = 2;
  rgba[0].b = 3;
  rgba[0].a = 4;
  ASSERT_EQ(pcl::io::savePCDFileBinary((this->Folder / "c.pcd").string(), rgba), 0);
  EXPECT_EQ(ValuesOf(this->Converted("c.pcd"), "RGBA"), (std::vector<double>{ 1, 2, 3, 4 }));
  this->WriteText("d.pcd",
    this->Header("2", "ascii", "", "x y z label hist", "8 8 8 2 4", "F F F U F", "1 1 1 1 3") +
      "4000000.001 5000000.002 0.5 7 1 2 3\n1 2 3 65535 4 5 6\n");
  const Mesh doubles = this->Converted("d.pcd");
  EXPECT_EQ(doubles.scalarType, ScalarType::Float64);
  EXPECT_EQ(doubles.points[0], (Vec3{ 4000000.001, 5000000.002, 0.5 }));
  EXPECT_EQ(ValuesOf(doubles, "label"), (std::vector<double>{ 7, 65535 }));
  EXPECT_EQ(ValuesOf(doubles, "hist"), (std::vector<double>{ 1, 2, 3, 4, 5, 6 }));
}

TEST_F(TestConvertPcd, HeadersThatLieAreRefusedBeforeMemoryIsTaken)
{
  const std::string three = "0 0 0\n1 1 1\n2 2 2\n";
  const std::string bytes(36, '\0');
  const auto sizes = [](std::uint32_t compressed, std::uint32_t whole)
  {
    return std::string(reinterpret_cast<const char*>(&compressed), 4) +
           std::string(reinterpret_cast<const char*>(&whole), 4);
  };
  const struct
  {
    std::string text, error;
  } cases[] = {
    { this->Header("4000000000", "binary") + bytes,
      "the header claims 4000000000 points, at least 48000000000 bytes; there are 36" },
    { this->Header("4", "binary") + bytes, "the header claims 4 points, at least 48 bytes" },
    { this->Header("1000000", "ascii") + three, "the header claims 1000000 points" },
    { this->Header("3", "ascii", "4") + three,
      "the header says POINTS 3, but WIDTH times HEIGHT is 4" },
    { this->Header("3000000000", "binary_compressed") + sizes(28, 4000000000U) + bytes,
      "compressed bytes hold" },
    { this->Header("3", "binary_compressed") + sizes(4000000000U, 36) + bytes,
      "claims 4000000000 bytes of compressed points; there are 36" },
    { this->Header("3", "binary_compressed") + sizes(36, 37) + bytes, "compressed bytes hold" },
    { this->Header("3", "binary_compressed") + "123", "ends before its compressed points" },
    { this->Header("99999999999999999999", "ascii") + three, "is not a count" },
    { this->Header("-3", "ascii") + three, "is not a count" },
    { this->Header("5000000000", "ascii") + three, "at most 4294967294" },
    { this->Header("3", "text") + three, "DATA is 'text'" },
    { this->Header("3", "ascii", "", "x y z", "4 4 3") + three, "is not a valid field" },
    { this->Header("3", "ascii", "", "x y z", "4 4 4", "F F Q") + three, "is not a valid field" },
    { this->Header("3", "ascii", "", "x y z", "4 4") + three, "another number of values" },
    { this->Header("3", "ascii", "", "x y z", "4 4 4", "F F F", "1 1 4000000000") + three,
      "is not a valid field" },
    { this->Header("3", "ascii", "", "a b c") + three, "has no field x" },
    { "VERSION 0.7\nWIDTH 3\n" + this->Header("3", "ascii") + three, "a second VERSION" },
    { "hello\n", "is not a PCD file" },
    { "VERSION 0.7\nFIELDS x y z\n", "ends inside its header, before DATA" },
    { this->Header("0", "ascii"), "holds no points" },
    { this->Header("3", "ascii") + "0.00 0 0\n1 1\n2 2 2.00\n",
      "line 13: has 2 numbers; a point has 3" },
    { this->Header("3", "ascii") + "0 0 0\n1 a 1\n2 2 2\n", "line 13: 'a' is not a number" },
    { this->Header("3", "ascii") + "0.00000000 0 0\n1 1.0000000 1\n",
      "the header claims 3 points; there are 2" },
    { this->Header("1", "ascii") + "nan nan nan\n", "holds no points" },
    { this->Header("2", "binary_compressed") + sizes(28, 37) + bytes, "compressed bytes hold" },
  };
  for (const auto& c : cases)
  {
    SCOPED_TRACE(c.text.substr(0, 400));
    this->WriteText("in.pcd", c.text);
    this->ExpectError("in.pcd", c.error);
    const Outcome outcome = this->Convert("in.pcd");
    EXPECT_LE(outcome.peakBytes, std::uint64_t{ 200 } << 20);
  }
}

TEST_F(TestConvertPcd, BytesAfterThePointsArePadding)
{
  const std::vector<Vec3> points{ { 0, 0, 0 }, { 1, 1, 1 } };
  this->WriteText("in.pcd", this->Header("2", "ascii") + "0 0 0\n1 1.00 1\n\n \t\n\r\n");
  EXPECT_EQ(this->Converted("in.pcd").points, points);
  const auto warning = [](const std::string& what)
  { return "kdstream-convert: warning: in.pcd: " + what + "\n"; };
  const std::string bodyBegin = std::to_string(this->Header("2", "binary").size() + 24);
  for (const std::size_t zeros : { 11, 12, 4096 })
  {
    this->WriteText("in.pcd", this->Header("2", "binary") + std::string(24 + zeros, '\0'));
    EXPECT_EQ(this
                ->Converted("in.pcd",
                  warning(std::to_string(zeros) +
                          " zeros after the end are padding; the first: byte " + bodyBegin))
                .points.size(),
      2U);
  }
  this->WriteText("in.pcd", this->Header("2", "binary") + std::string(24, '\0') + "hello");
  EXPECT_EQ(this
              ->Converted("in.pcd",
                warning("5 bytes after the end are not read; the first: byte " + bodyBegin))
              .points.size(),
    2U);
  this->WriteText("in.pcd", this->Header("2", "ascii") + "0 0 0\n1 1 1\nthe end\n");
  EXPECT_EQ(this
              ->Converted("in.pcd", warning("8 bytes after the end are not read; the first: byte " +
                                            std::to_string(this->Header("2", "ascii").size() + 12)))
              .points,
    points);
}

// Points that the header does not count are read, too.
TEST_F(TestConvertPcd, HeadersThatFallShortLoseNothing)
{
  const std::string warning = "kdstream-convert: warning: in.pcd: ";
  this->WriteText("in.pcd", this->Header("2", "ascii") + "0 0 0\n1 1 1\n2 2 2\n\n3 3 3\n");
  const Mesh longer = this->Converted("in.pcd",
    warning +
      "2 points or faces are in the file but its header does not count them; the first: line 14\n");
  ASSERT_EQ(longer.points.size(), 4U);
  EXPECT_EQ(longer.points.back(), (Vec3{ 3, 3, 3 }));
  const auto cloud = this->MakeScan();
  const std::string file = (this->Folder / "in.pcd").string();
  for (const bool compressed : { false, true })
  {
    SCOPED_TRACE(compressed);
    pcl::PCDWriter writer;
    ASSERT_EQ(
      compressed ? writer.writeBinaryCompressed(file, cloud) : writer.writeBinary(file, cloud), 0);
    std::string text = ReadWhole(file);
    const Mesh whole = this->Converted(
      "in.pcd", warning + "9 points are not finite and are dropped; the first: point 3\n");
    text.replace(text.find("WIDTH 8"), 7, "WIDTH 2");
    text.replace(text.find("POINTS 40"), 9, "POINTS 10");
    this->WriteText("in.pcd", text);
    const Mesh read = this->Converted("in.pcd",
      warning + "9 points are not finite and are dropped; the first: point 3\n" + warning +
        "30 points or faces are in the file but its header does not count them; the first: point "
        "10\n");
    EXPECT_EQ(read.points, whole.points);
    EXPECT_TRUE(read.attributes == whole.attributes);
  }
}

TEST_F(TestConvertPcd, HeadersInAnyDress)
{
  const std::vector<Vec3> points{ { 0, 0, 0 }, { 1, 1, 1 } };
  const std::string body = "0 0 0\n1 1 1\n";
  const std::string least = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\n";
  const auto expect = [&](const std::string& text)
  {
    SCOPED_TRACE(text);
    this->WriteText("in.pcd", text);
    EXPECT_EQ(this->Converted("in.pcd").points, points);
  };
  expect(this->Header("2", "ascii", "", "X Y Z") + body);
  expect(least + "WIDTH 2\nDATA ascii\n" + body);
  expect(least + "POINTS 2\nDATA ascii\n" + body);
  expect("version .5\nfields X y Z\nsize 4 4 4\ntype f f f\ncount 1 1 1\nwidth 2\nheight 1\n"
         "points 2\ndata ASCII\n" +
         body);
  std::string windows = this->Header("2", "ascii", "", "X Y Z") + body;
  for (std::size_t at = 0; (at = windows.find('\n', at)) != std::string::npos; at += 2)
  {
    windows.replace(at, 1, "\r\n");
  }
  expect(windows);
  std::string header = windows.substr(0, windows.find("ascii")) + "binary\r\n";
  const std::array<float, 6> values{ 0, 0, 0, 1, 1, 1 };
  expect(header + std::string(reinterpret_cast<const char*>(values.data()), sizeof(values)));
  this->WriteText("in.pcd",
    this->Header("2", "ascii", "", "X Y Z RGB Intensity", "4 4 4 4 4", "F F F U F", "1 1 1 1 1") +
      "1 2 3 16711680 7\n2 2 2 255 8\n");
  const Mesh colored = this->Converted("in.pcd");
  EXPECT_EQ(ValuesOf(colored, "RGB"), (std::vector<double>{ 255, 0, 0, 0, 0, 255 }));
  EXPECT_EQ(ValuesOf(colored, "intensity"), (std::vector<double>{ 7, 8 }));
}

TEST_F(TestConvertPcd, LinesAmongPointsMayBeComments)
{
  this->WriteText(
    "in.pcd", this->Header("3", "ascii") + "# first\n0 0 0\n  # second\n1 0 0\n0 2 0\n");
  EXPECT_EQ(
    this->Converted("in.pcd").points, (std::vector<Vec3>{ { 0, 0, 0 }, { 1, 0, 0 }, { 0, 2, 0 } }));
}

TEST_F(TestConvertPcd, DecimalsThatBecomeCoarseFloatsAreSaid)
{
  const std::string body = "500000.25 4000000.4565 1\n500010 4000010 2\n";
  this->WriteText("in.pcd", this->Header("2", "ascii") + body);
  this->Converted("in.pcd", "kdstream-convert: warning: in.pcd: coordinates are read as floats: at "
                            "4000010 they are 0.25 apart\n");
  this->WriteText("in.pcd", this->Header("2", "ascii", "", "x y z", "8 8 8") + body);
  EXPECT_EQ(this->Converted("in.pcd").points[0], (Vec3{ 500000.25, 4000000.4565, 1 }));
}

TEST_F(TestConvertPcd, CutAndChangedFiles)
{
  const auto cloud = this->MakeScan();
  const std::string file = (this->Folder / "whole.pcd").string();
  std::mt19937 random(9);
  for (int encoding = 0; encoding < 3; ++encoding)
  {
    pcl::PCDWriter writer;
    ASSERT_EQ(encoding == 0   ? writer.writeASCII(file, cloud, 9)
              : encoding == 1 ? writer.writeBinary(file, cloud)
                              : writer.writeBinaryCompressed(file, cloud),
      0);
    const std::string whole = ReadWhole(file);
    const std::size_t body = whole.find("DATA");
    for (unsigned draw = 0; draw < 40; ++draw)
    {
      std::string bad = whole;
      const bool cut = draw < 16;
      if (cut)
      {
        bad.resize(whole.size() * draw / 16);
      }
      for (unsigned change = 0; !cut && change <= draw % 3; ++change)
      {
        const std::size_t range = draw % 2 == 0 ? body + 20 : whole.size();
        bad[random() % range] = draw % 4 == 0 ? '9' : static_cast<char>(random() % 256);
      }
      this->WriteText("in.pcd", bad);
      this->ExpectRefusedOrRead(
        "in.pcd", !cut, std::to_string(encoding) + " " + std::to_string(draw));
    }
  }
}
