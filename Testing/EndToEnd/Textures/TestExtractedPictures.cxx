// SPDX-License-Identifier: BSD-3-Clause
// kdstream-store extract of a textured store writes pictures if the format allows them, and a
// warning if they are left out.
#include "Testing/EndToEnd/Textures/TexturedFiles.h"

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

const std::string noFormat = "this format cannot hold the original's textures; .obj and .glb can\n";
const std::string noMix = "the original's textures are left out: they can only be written with "
                          "partitions of the original, without levels\n";

class TestExtractedPictures : public TexturedTest
{
protected:
  void BuildHard()
  {
    this->WriteHardObj("hard", 5);
    const Outcome built =
      this->Build({ "hard.obj", "-o", "m.kds", "--quiet", "--vertices-per-partition", "100" });
    ASSERT_EQ(built.exitCode, 0) << built.err;
  }

  // Checks whether the file has pictures, and what the program says about them.
  void ExpectExtracted(
    const std::vector<std::string>& what, const std::string& output, const std::string& warning)
  {
    SCOPED_TRACE(what[0] + " " + output);
    std::vector<std::string> arguments{ "extract", "m.kds", "-o", output, "--quiet" };
    arguments.insert(arguments.end(), what.begin(), what.end());
    const Outcome extracted = this->Store(arguments);
    EXPECT_EQ(extracted.exitCode, 0) << extracted.err;
    EXPECT_EQ(
      extracted.err, warning.empty() ? "" : "kdstream-store: warning: " + output + ": " + warning);
  }

  bool GlbHasPictures(const std::string& name)
  {
    return ReadWhole(this->Folder / name).find("\"images\"") != std::string::npos;
  }

  // Writes a file for --resolutions that chooses `one` for the first partition of the tree, and
  // `others` for the rest.
  void WriteResolutions(const std::string& one, const std::string& others)
  {
    std::string list = "[" + one;
    for (int i = 1; i < 8; ++i)
    {
      list += "," + others;
    }
    this->WriteText("mix.json", list + "]");
  }
};

}

TEST_F(TestExtractedPictures, FormatsWithoutThemAreSaid)
{
  this->BuildHard();
  for (const char* output : { "all.ply", "all.vtp", "all.wrl" })
  {
    this->ExpectExtracted({ "--all" }, output, noFormat);
    this->ExpectExtracted({ "--partition", "1" }, output, noFormat);
    this->ExpectExtracted({ "--level", "4" }, output, "");
  }
  const std::string next = "kdstream-store: warning: all.stl: ";
  this->ExpectExtracted({ "--all" }, "all.stl",
    "this format cannot hold these attributes: RGB\n" + next +
      "STL holds floats; the coordinates were doubles and are rounded\n" + next + noFormat);
  this->ExpectExtracted({ "--all" }, "all.obj", "");
  this->ExpectExtracted({ "--all" }, "all.glb", "");
}

TEST_F(TestExtractedPictures, MixesWithLevelsAreSaid)
{
  this->BuildHard();
  for (const char* output : { "mix.obj", "mix.glb" })
  {
    this->ExpectExtracted({ "--region", "9", "--in-context", "3" }, output, noMix);
    this->WriteResolutions("\"original\"", "8");
    this->ExpectExtracted({ "--resolutions", "mix.json" }, output, noMix);
    this->WriteResolutions("8", "8");
    this->ExpectExtracted({ "--resolutions", "mix.json" }, output, "");
  }
  EXPECT_FALSE(this->GlbHasPictures("mix.glb"));
  this->ExpectExtracted({ "--level", "4" }, "level.glb", "");
  EXPECT_TRUE(this->GlbHasPictures("level.glb")) << "a level has textures of its own";
}

TEST_F(TestExtractedPictures, OnlyACutOfTheOriginalHasThem)
{
  this->BuildHard();
  this->WriteResolutions("\"original\"", "\"original\"");
  for (const char* output : { "mix.glb", "mix.obj" })
  {
    this->ExpectExtracted({ "--resolutions", "mix.json" }, output, "");
  }
  EXPECT_TRUE(this->GlbHasPictures("mix.glb"));
  EXPECT_TRUE(this->Files().contains("mix-partition-7.png"));
  EXPECT_EQ(this->Store({ "extract", "m.kds", "--all", "-o", "all.obj", "--quiet" }).exitCode, 0);
  EXPECT_EQ(this->ReadWithTextures("mix.obj").mesh.triangles,
    this->ReadWithTextures("all.obj").mesh.triangles);
  this->WriteText("mix.json", "{\"base\": \"original\", \"pieces\": []}");
  this->ExpectExtracted({ "--resolutions", "mix.json" }, "object.glb", "");
  EXPECT_TRUE(this->GlbHasPictures("object.glb"));
}

// Neither a .glb nor an .obj with pictures can contain other arrays.
TEST_F(TestExtractedPictures, OtherArraysAreNamed)
{
  this->WriteText("m.ply",
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
    "z\nproperty float quality\nelement face 1\nproperty list uchar int vertex_indices\nproperty "
    "int label\nend_header\n0 0 0 1\n1 0 0 2\n0 1 0 3\n3 0 1 2 7\n");
  ASSERT_EQ(this->Build({ "m.ply", "-o", "m.kds", "--quiet" }).exitCode, 0);
  this->ExpectExtracted(
    { "--all" }, "m.glb", "this format cannot hold these attributes: quality, label\n");
  this->ExpectExtracted({ "--all" }, "m.ply.ply", "");
}
