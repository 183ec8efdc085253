// SPDX-License-Identifier: BSD-3-Clause
// kdstream-convert with the point clouds of laser scanners: LAS as specified, and files with false
// claims.
#include "Testing/EndToEnd/ConvertTools.h"
#include "Testing/Fixtures/TemporaryFolder.h"

#ifdef KDSTREAM_HAS_LASZIP
#include <laszip/laszip_api.h>
#endif

#include <functional>
#include <limits>
#include <random>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

constexpr std::size_t leastPointBytes[] = { 20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67 };
constexpr std::size_t points = 40;

template <class T>
void Put(std::string& bytes, std::size_t place, T value)
{
  std::memcpy(&bytes[place], &value, sizeof(value));
}

bool HasColors(unsigned format)
{
  return format == 2 || format == 3 || format == 5 || format == 7 || format == 8 || format == 10;
}

// Point i is at (1e6 + i / 100, 2e6 - i / 100, i / 2); point 7 is withheld.
std::string MakeLas(unsigned format, unsigned channelScale = 256, std::size_t extraBytes = 3)
{
  const bool isLong = format >= 6;
  const unsigned minor = isLong ? 4 : 2;
  const std::size_t headerBytes = isLong ? 375 : 227, begin = headerBytes + 54;
  const std::size_t pointBytes = leastPointBytes[format] + extraBytes;
  std::string las(begin + points * pointBytes + 11, '\x7f');
  std::fill_n(las.begin(), headerBytes, '\0');
  las.replace(0, 4, "LASF");
  las[24] = 1;
  las[25] = static_cast<char>(minor);
  Put(las, 94, static_cast<std::uint16_t>(headerBytes));
  Put(las, 96, static_cast<std::uint32_t>(begin));
  las[104] = static_cast<char>(format);
  Put(las, 105, static_cast<std::uint16_t>(pointBytes));
  Put(las, 107, static_cast<std::uint32_t>(isLong ? 0 : points));
  const double scale[] = { 0.01, -0.01, 0.5 }, offset[] = { 1e6, 2e6, 0 };
  for (std::size_t k = 0; k < 3; ++k)
  {
    Put(las, 131 + 8 * k, scale[k]);
    Put(las, 155 + 8 * k, offset[k]);
  }
  if (isLong)
  {
    Put(las, 247, std::uint64_t{ points });
  }
  for (std::size_t i = 0; i < points; ++i)
  {
    const std::size_t at = begin + i * pointBytes;
    for (std::size_t k = 0; k < 3; ++k)
    {
      Put(las, at + 4 * k, static_cast<std::int32_t>(i));
    }
    Put(las, at + 12, static_cast<std::uint16_t>(1000 + i));
    const auto kind = static_cast<std::uint8_t>(i % 9);
    const bool withheld = i == 7;
    las[at + 14] = static_cast<char>((isLong ? 0x50U : 0x28U) | (i % 3 + 1));
    las[at + 15] = static_cast<char>(isLong ? (withheld ? 4U : 0U) : kind | (withheld ? 128U : 0U));
    las[at + 16] = static_cast<char>(isLong ? kind : 0);
    if (HasColors(format))
    {
      const std::size_t place = at + (format == 2 ? 20 : isLong ? 30 : 28);
      Put(las, place, static_cast<std::uint16_t>(i * channelScale));
      Put(las, place + 2, static_cast<std::uint16_t>(200 * channelScale));
      Put(las, place + 4, static_cast<std::uint16_t>(0));
    }
  }
  return las;
}

// Cuts a file in the first `cuts` draws, and changes bytes in the others: in half of them only of
// the first `head` bytes.
std::string Spoilt(
  std::string file, unsigned draw, unsigned cuts, std::size_t head, std::mt19937& random)
{
  if (draw < cuts)
  {
    file.resize(file.size() * draw / cuts);
    return file;
  }
  for (unsigned change = 0; change <= draw % 4; ++change)
  {
    file[random() % (draw % 2 == 0 ? head : file.size())] = static_cast<char>(random() % 256);
  }
  return file;
}

class TestConvertLas : public ConvertTest
{
protected:
  // warnings: all except the one about the bytes that MakeLas puts at the end of each point.
  Mesh Converted(const std::string& input, const std::string& warnings = "")
  {
    return ConvertTest::Converted(input, warnings + "kdstream-convert: warning: " + input +
                                           ": each point has 3 bytes after its format's fields "
                                           "(extra dimensions), which are left out\n");
  }

  std::string DigestOfStore(const std::string& input)
  {
    std::filesystem::remove(this->Folder / "out.kds");
    const Outcome built = this->Build({ input, "-o", "out.kds", "--quiet" });
    EXPECT_EQ(built.exitCode, 0) << built.err;
    const Outcome info = RunTool(this->Folder, "store", { "info", "out.kds", "--json" });
    const std::size_t digest = info.out.find("\n  \"digest\": ");
    EXPECT_NE(digest, std::string::npos) << info.out;
    return info.out.substr(std::min(digest, info.out.size()), 50);
  }
};

const std::string withheld =
  "kdstream-convert: warning: in.las: 1 point is marked as withheld and is dropped: point 7\n";

std::string Warning(const std::string& what)
{
  return "kdstream-convert: warning: in.las: " + what + "\n";
}

// The warning about the bytes that MakeLas appends after the points.
std::string Behind(unsigned format, std::size_t extraBytes = 3)
{
  const std::size_t begin = (format >= 6 ? 375 : 227) + 54;
  return Warning("11 bytes after the end are not read; the first: byte " +
                 std::to_string(begin + points * (leastPointBytes[format] + extraBytes)));
}

}

TEST_F(TestConvertLas, EachFormatComesBack)
{
  for (unsigned format = 0; format <= 10; ++format)
  {
    SCOPED_TRACE(format);
    this->WriteText("in.las", MakeLas(format, format % 2 == 0 ? 1 : 256));
    const Mesh read = this->Converted("in.las", withheld + Behind(format));
    ASSERT_EQ(read.points.size(), points - 1);
    EXPECT_EQ(read.scalarType, ScalarType::Float64);
    EXPECT_TRUE(read.triangles.empty());
    const auto intensity = ValuesOf(read, "intensity"), kinds = ValuesOf(read, "classification"),
               returns = ValuesOf(read, "return_number"), colors = ValuesOf(read, "RGB");
    ASSERT_EQ(intensity.size(), points - 1);
    ASSERT_EQ(kinds.size(), points - 1);
    ASSERT_EQ(returns.size(), points - 1);
    ASSERT_EQ(colors.size(), HasColors(format) ? 3 * (points - 1) : 0);
    for (std::size_t v = 0; v < read.points.size(); ++v)
    {
      const std::size_t i = v < 7 ? v : v + 1;
      const double n = static_cast<double>(i);
      EXPECT_EQ(read.points[v], (Vec3{ n * 0.01 + 1e6, n * -0.01 + 2e6, n * 0.5 }));
      EXPECT_EQ(intensity[v], 1000 + n);
      EXPECT_EQ(kinds[v], double(i % 9));
      EXPECT_EQ(returns[v], double(i % 3 + 1));
      if (HasColors(format))
      {
        EXPECT_EQ(colors[3 * v], n);
        EXPECT_EQ(colors[3 * v + 1], 200);
      }
    }
  }
}

TEST_F(TestConvertLas, BecomesAStore)
{
  this->WriteText("in.las", MakeLas(7));
  const Outcome built = this->Build({ "in.las", "-o", "out.kds", "--quiet" });
  EXPECT_EQ(built.exitCode, 0) << built.err;
  const Outcome info = RunTool(this->Folder, "store", { "info", "out.kds", "--json" });
  EXPECT_NE(info.out.find("\"classification\""), std::string::npos) << info.out;
  EXPECT_NE(info.out.find("1000"), std::string::npos) << info.out;
}

TEST_F(TestConvertLas, WhatSaysNothingIsLeftOut)
{
  std::string las = MakeLas(2, 0);
  for (std::size_t i = 0; i < points; ++i)
  {
    const std::size_t at = 281 + i * 29;
    Put(las, at + 12, std::uint16_t{ 0 });
    las[at + 14] = 1;
    las[at + 15] = 0;
    Put(las, at + 22, std::uint16_t{ 0 });
  }
  this->WriteText("in.las", las);
  const Mesh read = this->Converted("in.las", Behind(2));
  EXPECT_EQ(read.points.size(), points);
  EXPECT_TRUE(read.attributes.empty());
}

// LAS 1.0 has no flags; they came with 1.1.
TEST_F(TestConvertLas, ClassesOfTheOldestVersionHaveTheirByte)
{
  std::string las = MakeLas(1);
  las.resize(las.size() - 11);
  las[25] = 0;
  this->WriteText("in.las", las);
  const Mesh read = this->Converted("in.las");
  ASSERT_EQ(read.points.size(), points);
  EXPECT_EQ(ValuesOf(read, "classification")[7], 135);
  EXPECT_EQ(ValuesOf(read, "classification")[8], 8);
}

// The header counts fewer points than there are, as if its writer had not finished.
TEST_F(TestConvertLas, PointsThatTheHeaderDoesNotCountAreRead)
{
  for (const unsigned format : { 2U, 7U })
  {
    SCOPED_TRACE(format);
    std::string las = MakeLas(format);
    las.resize(las.size() - 11);
    format < 6 ? Put(las, 107, std::uint32_t{ 10 }) : Put(las, 247, std::uint64_t{ 10 });
    this->WriteText("in.las", las);
    const Mesh read = this->Converted("in.las",
      withheld + Warning(
                   "30 points or faces are in the file but its header does not count them; the "
                   "first: point 10"));
    EXPECT_EQ(read.points.size(), points - 1);
    EXPECT_EQ(read.points.back(), (Vec3{ 39 * 0.01 + 1e6, 39 * -0.01 + 2e6, 39 * 0.5 }));
    // Data that follows the points according to the header does not count as points.
    if (format >= 6)
    {
      Put(las, 235, std::uint64_t{ 375 + 54 + 20 * 39 });
      Put(las, 243, std::uint32_t{ 1 });
      this->WriteText("in.las", las);
      EXPECT_EQ(this
                  ->Converted(
                    "in.las", withheld + Warning("10 points or faces are in the file but its "
                                                 "header does not count them; the first: point 10"))
                  .points.size(),
        19U);
    }
  }
  // Whole records of other data; only the header's box shows that they are not points.
  std::string las = MakeLas(2);
  las.resize(las.size() - 11);
  for (std::size_t k = 0; k < 3; ++k)
  {
    const double ends[] = { 1e6, 1e6 + 0.39, 2e6 - 0.39, 2e6, 0, 19.5 };
    Put(las, 187 + 16 * k, ends[2 * k]);
    Put(las, 179 + 16 * k, ends[2 * k + 1]);
  }
  this->WriteText("in.las", las + std::string(29 * 2, 'x'));
  EXPECT_EQ(
    this
      ->Converted("in.las", withheld + Warning("58 bytes after the end are not read; the first: "
                                               "byte " +
                                               std::to_string(las.size())))
      .points.size(),
    points - 1);
  Put(las, 107, std::uint32_t{ 10 });
  this->WriteText("in.las", las);
  EXPECT_EQ(
    this
      ->Converted("in.las", withheld + Warning("30 points or faces are in the file but its header "
                                               "does not count them; the first: point 10"))
      .points.size(),
    points - 1);
  std::string padded = MakeLas(3);
  padded.resize(padded.size() - 11);
  const std::string end = std::to_string(padded.size());
  this->WriteText("in.las", padded + std::string(37 * 5, '\0'));
  EXPECT_EQ(this
              ->Converted("in.las", withheld + Warning("185 zeros after the end are padding; "
                                                       "the first: byte " +
                                                       end))
              .points.size(),
    points - 1);
}

TEST_F(TestConvertLas, AHeaderThatCountsNoneSaysThatThereAreSome)
{
  std::string las = MakeLas(3);
  Put(las, 107, std::uint32_t{ 0 });
  this->WriteText("in.las", las);
  this->ExpectError("in.las", "its header counts no points, but the file holds 40 after it");
  this->WriteText("in.las", las.substr(0, 281));
  this->ExpectError("in.las", "has no points");
}

// The majority of the channels decides whether colours have 8 bits or 16.
TEST_F(TestConvertLas, ColoursAreThoseOfMost)
{
  std::string las = MakeLas(2, 1); // channels of 8 bits
  las.resize(las.size() - 11);
  Put(las, 281 + 20, std::uint16_t{ 256 });
  Put(las, 281 + 29 + 20, std::uint16_t{ 65535 });
  this->WriteText("in.las", las);
  const std::vector<double> rgb = ValuesOf(
    this->Converted("in.las",
      withheld + Warning("colours are read as 8-bit values, because most channels are: 2 of 78 "
                         "are above 255 and count as 255")),
    "RGB");
  ASSERT_EQ(rgb.size(), 3 * (points - 1));
  EXPECT_EQ(rgb[0], 255);
  EXPECT_EQ(rgb[1], 200);
  EXPECT_EQ(rgb[3], 255);
  EXPECT_EQ(rgb[6], 2);
  las = MakeLas(2, 256); // channels of 16 bits, some of them dark
  las.resize(las.size() - 11);
  Put(las, 281 + 20, std::uint16_t{ 255 });
  this->WriteText("in.las", las);
  const std::vector<double> full = ValuesOf(this->Converted("in.las", withheld), "RGB");
  EXPECT_EQ(full[0], 0);
  EXPECT_EQ(full[1], 200);
}

TEST_F(TestConvertLas, LiarsAreRefusedByWhatIsWrong)
{
  struct Case
  {
    std::string error;
    std::function<void(std::string&)> change;
    unsigned format = 3;
  };
  const Case cases[] = {
    { "is not a LAS file", [](std::string& las) { las[0] = 'X'; } },
    { "truncated: ends inside its header", [](std::string& las) { las.resize(200); } },
    { "truncated: ends inside its header", [](std::string& las) { las.resize(374); }, 6 },
    { "has version 2.2 of LAS; versions 1.0 to 1.4 can be read",
      [](std::string& las) { las[24] = 2; } },
    { "has version 1.5 of LAS", [](std::string& las) { las[25] = 5; } },
    { "its points have format 11; formats 0 to 10 can be read",
      [](std::string& las) { las[104] = 11; } },
    { "a point of format 3 takes 34 bytes, not 33",
      [](std::string& las) { Put(las, 105, std::uint16_t{ 33 }); } },
    { "a point of format 3 takes 34 bytes, not 0",
      [](std::string& las) { Put(las, 105, std::uint16_t{ 0 }); } },
    { "its points begin at byte 12, in the header",
      [](std::string& las) { Put(las, 96, std::uint32_t{ 12 }); } },
    { "its points begin at byte 4294967295, in the header or after the end of the file",
      [](std::string& las) { Put(las, 96, ~std::uint32_t{ 0 }); } },
    { "truncated: the header claims 4294967295 points, but the file holds 40",
      [](std::string& las) { Put(las, 107, ~std::uint32_t{ 0 }); } },
    { "truncated: the header claims 18446744073709551615 points, but the file holds 40",
      [](std::string& las) { Put(las, 247, ~std::uint64_t{ 0 }); }, 7 },
    { "the scale or the offset of y is not a usable number",
      [](std::string& las) { Put(las, 139, std::numeric_limits<double>::infinity()); } },
    { "the scale or the offset of x is not a usable number",
      [](std::string& las) { Put(las, 131, 0.0); } },
    { "the scale or the offset of z is not a usable number",
      [](std::string& las) { Put(las, 171, std::numeric_limits<double>::quiet_NaN()); } },
    { "truncated: the header claims 40 points, but the file holds 38",
      [](std::string& las) { las.resize(las.size() - 50); } },
    { "all of its points are marked as withheld",
      [](std::string& las)
      {
        for (std::size_t i = 0; i < points; ++i)
        {
          las[281 + i * 37 + 15] = char(128);
        }
      } },
  };
  for (const Case& c : cases)
  {
    SCOPED_TRACE(c.error);
    std::string las = MakeLas(c.format);
    c.change(las);
    this->WriteText("in.las", las);
    this->ExpectError("in.las", c.error);
  }
}

// Files that claim to be compressed but are not.
TEST_F(TestConvertLas, CompressedOnesNeedLaszip)
{
  std::string compressed = MakeLas(7);
  compressed[104] = char(128 + 7);
  this->WriteText("in.laz", compressed);
#ifdef KDSTREAM_HAS_LASZIP
  this->ExpectError("in.laz", "cannot be decompressed");
#else
  this->ExpectError("in.laz", "compressed (LAZ), which is not read: make a .las of it");
#endif
  compressed.resize(200);
  this->WriteText("in.laz", compressed);
  this->ExpectError("in.laz", "truncated: ends inside its header");
}

#ifdef KDSTREAM_HAS_LASZIP

namespace
{

// Compresses with LASzip's own writer.
void CompressLas(const std::filesystem::path& las, const std::filesystem::path& laz)
{
  laszip_POINTER reader = nullptr, writer = nullptr;
  laszip_BOOL isCompressed = 0;
  laszip_header_struct* header = nullptr;
  laszip_point_struct* point = nullptr;
  ASSERT_EQ(laszip_create(&reader) + laszip_create(&writer), 0);
  ASSERT_EQ(laszip_open_reader(reader, las.c_str(), &isCompressed), 0);
  ASSERT_EQ(laszip_get_header_pointer(reader, &header), 0);
  ASSERT_EQ(laszip_get_point_pointer(reader, &point), 0);
  ASSERT_EQ(laszip_set_header(writer, header), 0);
  ASSERT_EQ(laszip_request_native_extension(writer, 1), 0);
  ASSERT_EQ(laszip_set_chunk_size(writer, 16), 0); // so that there are several chunks
  ASSERT_EQ(laszip_open_writer(writer, laz.c_str(), 1), 0);
  for (std::size_t i = 0; i < points; ++i)
  {
    ASSERT_EQ(laszip_read_point(reader), 0);
    ASSERT_EQ(laszip_set_point(writer, point), 0);
    ASSERT_EQ(laszip_write_point(writer), 0);
  }
  ASSERT_EQ(laszip_close_writer(writer) + laszip_close_reader(reader), 0);
  ASSERT_EQ(laszip_destroy(writer) + laszip_destroy(reader), 0);
}

}

TEST_F(TestConvertLas, CompressedOnesGiveTheSameStore)
{
  for (unsigned format = 0; format <= 10; ++format)
  {
    SCOPED_TRACE(format);
    std::string las = MakeLas(format);
    las.resize(las.size() - 11);
    this->WriteText("in.las", las);
    CompressLas(this->Folder / "in.las", this->Folder / "in.laz");
    EXPECT_NE(ReadWhole(this->Folder / "in.laz").at(104) & 0x80, 0);
    EXPECT_EQ(this->DigestOfStore("in.las"), this->DigestOfStore("in.laz"));
  }
}

TEST_F(TestConvertLas, CompressedOnesThatAreCutOrChanged)
{
  std::mt19937 random(12);
  for (unsigned draw = 0; draw < 66; ++draw)
  {
    std::string las = MakeLas(draw % 11);
    las.resize(las.size() - 11);
    this->WriteText("in.las", las);
    CompressLas(this->Folder / "in.las", this->Folder / "in.laz");
    this->WriteText("in.laz", Spoilt(ReadWhole(this->Folder / "in.laz"), draw, 22, 500, random));
    this->ExpectRefusedOrRead("in.laz", draw >= 22, "draw " + std::to_string(draw));
  }
}

#endif

TEST_F(TestConvertLas, CutAndChangedFiles)
{
  std::mt19937 random(11);
  for (unsigned draw = 0; draw < 60; ++draw)
  {
    this->WriteText("in.las", Spoilt(MakeLas(draw % 11), draw, 16, 375, random));
    this->ExpectRefusedOrRead("in.las", draw >= 16, "draw " + std::to_string(draw));
  }
}
