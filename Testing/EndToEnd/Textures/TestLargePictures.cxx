// SPDX-License-Identifier: BSD-3-Clause
// Pictures that are larger than --memory: neither kdstream-build nor kdstream-convert, which it
// runs, ever holds a whole picture.
#include "Testing/EndToEnd/ProgramsTest.h"
#include "Testing/Fixtures/Sanitized.h"
#include "filters/model/JsonReader.h"

#include <cstdio>
#include <jpeglib.h>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

class TestLargePictures : public ProgramsTest
{
protected:
  // Writes slanted bands, made row by row.
  void WriteJpeg(const std::string& name, unsigned side)
  {
    std::FILE* const file = std::fopen((this->Folder / name).c_str(), "wb");
    ASSERT_NE(file, nullptr);
    jpeg_compress_struct jpeg{};
    jpeg_error_mgr errors{};
    jpeg.err = jpeg_std_error(&errors);
    jpeg_create_compress(&jpeg);
    jpeg_stdio_dest(&jpeg, file);
    jpeg.image_width = jpeg.image_height = side;
    jpeg.input_components = 3;
    jpeg.in_color_space = JCS_RGB;
    jpeg_set_defaults(&jpeg);
    jpeg_start_compress(&jpeg, TRUE);
    std::vector<std::uint8_t> row(std::size_t{ 3 } * side);
    while (jpeg.next_scanline < side)
    {
      for (std::size_t i = 0; i < row.size(); ++i)
      {
        row[i] = static_cast<std::uint8_t>((i / 300 + jpeg.next_scanline / 64) % 256);
      }
      JSAMPROW rows[] = { row.data() };
      jpeg_write_scanlines(&jpeg, rows, 1);
    }
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    ASSERT_EQ(std::fclose(file), 0);
  }

  // Writes a square of side² faces, which show the whole picture.
  void WriteObj(const std::string& name, std::size_t side)
  {
    this->WriteText("large.mtl", "newmtl a\nmap_Kd large.jpg\n");
    std::string text = "mtllib large.mtl\nusemtl a\n";
    for (std::size_t i = 0; i < (side + 1) * (side + 1); ++i)
    {
      const std::string x = std::to_string(double(i % (side + 1)) / double(side));
      const std::string y = std::to_string(double(i / (side + 1)) / double(side));
      text += "v " + x + " " + y + " 0\nvt " + x + " " + y + "\n";
    }
    for (std::size_t i = 0; i < side * side; ++i)
    {
      const std::size_t a = i / side * (side + 1) + i % side + 1;
      text += "f";
      for (const std::size_t v : { a, a + 1, a + side + 2, a + side + 1 })
      {
        text += " " + std::to_string(v) + "/" + std::to_string(v);
      }
      text += "\n";
    }
    this->WriteText(name, text);
  }
};

}

// A gigabyte of texels. The system refuses more than 256M of private memory to both processes.
// Mapped pages of files do not count, because the system can take them back; they would count as
// resident memory.
TEST_F(TestLargePictures, NoProcessHoldsThem)
{
  if (fixtures::sanitized)
  {
    GTEST_SKIP() << "a sanitizer's own memory would count";
  }
  constexpr unsigned side = 16384;
  this->WriteJpeg("large.jpg", side);
  this->WriteObj("large.obj", 240);
  const std::string build = std::string(KDSTREAM_PROGRAMS) + "/kdstream-build";
  const Outcome built = RunProgram(this->Folder, "/bin/sh",
    { "-c", "ulimit -d 262144 && exec \"$0\" \"$@\"", build, "large.obj", "-o", "m.kds", "--quiet",
      "--memory", "256M", "--threads", "2", "--vertices-per-partition", "500", "--stats",
      "s.json" });
  ASSERT_EQ(built.exitCode, 0) << built.err;
  const auto stats = ParseJson(ReadWhole(this->Folder / "s.json"));
  ASSERT_TRUE(stats);
  EXPECT_EQ((*stats)["textures"]["pictures"].GetUint64(), 1U);
  EXPECT_GT((*stats)["tiles"]["texels"].GetUint64(), std::uint64_t{ side } * side);
  const std::uint64_t reported = (*stats)["peak_rss_bytes"].GetUint64();
  EXPECT_EQ(reported, (*stats)["convert_peak_rss_bytes"].GetUint64());
  EXPECT_GT(reported, std::uint64_t{ 4 } * side * side); // of the file with the picture
  EXPECT_LT(reported, std::uint64_t{ 4 } * side * side + (std::uint64_t{ 256 } << 20));
}
