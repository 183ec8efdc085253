// SPDX-License-Identifier: BSD-3-Clause
// Texture options without effect are refused, or, if only the input shows this, cause a warning.
// The memory of a conversion is reported before it.
#include "Testing/EndToEnd/Textures/TexturedFiles.h"
#include "filters/model/JsonReader.h"

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

class TestTextureOptions : public TexturedTest
{
protected:
  void SetUp() override
  {
    this->WriteHardObj("hard", 3);
    this->WriteText("plain.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  }
  Outcome Tool(const std::string& name, const std::vector<std::string>& arguments)
  {
    return RunTool(this->Folder, name, arguments);
  }
  // The warnings about options.
  std::string WarningsOf(const std::string& input, const std::vector<std::string>& more)
  {
    std::vector<std::string> arguments{ input, "-o", "m.kds", "--quiet" };
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome built = this->Build(arguments);
    EXPECT_EQ(built.exitCode, 0) << built.err;
    std::istringstream lines(built.err);
    std::string reported;
    for (std::string line; std::getline(lines, line);)
    {
      reported += line.find(": --") != std::string::npos ? line + "\n" : "";
    }
    return reported;
  }
};

}

TEST_F(TestTextureOptions, AQualityNeedsTiles)
{
  for (const std::string textures : { "off", "colors" })
  {
    this->ExpectError(this->Build({ "hard.obj", "-o", "m.kds", "--textures", textures,
                        "--texture-quality", "lossless" }),
      2,
      "kdstream-build: error: --texture-quality needs --textures on or tiles: the original has no "
      "textures with " +
        textures);
  }
  EXPECT_FALSE(this->Files().contains("m.kds"));
  EXPECT_EQ(this->WarningsOf("hard.obj", { "--textures", "tiles", "--texture-quality", "80" }), "");
}

TEST_F(TestTextureOptions, ABoundOfPixelsNeedsPictures)
{
  const std::string refused =
    "error: --texture-pixels has no effect with --textures off: no textures are read";
  this->ExpectError(
    this->Build({ "hard.obj", "-o", "m.kds", "--textures", "off", "--texture-pixels", "1000000" }),
    2, "kdstream-build: " + refused);
  this->ExpectError(this->Tool("convert", { "hard.obj", "-o", "o.ply", "--textures", "off",
                                            "--texture-pixels", "1000000" }),
    2, "kdstream-convert: " + refused);
  EXPECT_EQ(this->WarningsOf("hard.obj", { "--texture-pixels", "1000000" }), "");
}

// Scripts may use these options for all inputs, so this is only a warning.
TEST_F(TestTextureOptions, MeshesWithoutPicturesAreWarnedOf)
{
  const std::string begin = "kdstream-build: warning: plain.obj: ",
                    none = " has no effect: no textures were read\n";
  EXPECT_EQ(this->WarningsOf("plain.obj", { "--texture-quality", "90" }),
    begin + "--texture-quality" + none);
  EXPECT_EQ(this->WarningsOf("plain.obj", { "--texture-quality", "90", "--texture-pixels", "9" }),
    begin + "--texture-quality" + none + begin + "--texture-pixels" + none);
  EXPECT_EQ(this->WarningsOf("plain.obj", {}), "");
  const Outcome converted =
    this->Tool("convert", { "plain.obj", "-o", "o.ply", "--quiet", "--texture-pixels", "9" });
  EXPECT_EQ(converted.exitCode, 0);
  EXPECT_EQ(converted.err, "kdstream-convert: warning: plain.obj: --texture-pixels" + none);
}

TEST_F(TestTextureOptions, OnlyAStatueHasPhotographs)
{
  for (const std::string kind : { "relief", "vase" })
  {
    this->ExpectError(this->Tool("generate", { kind, "m.ply", "--picture-side", "256", "--quiet" }),
      2,
      "kdstream-generate: error: m.ply: a " + kind + " has no --picture-side: only a statue has");
    EXPECT_FALSE(this->Files().contains("m.ply"));
  }
}

// The conversion of a file of 34 MB is assumed to take 68 MB of memory.
TEST_F(TestTextureOptions, TheMemoryOfAConversionIsReportedBefore)
{
  const std::string text = ReadWhole(this->Folder / "hard.obj");
  const std::string comment = "# " + std::string(997, '-') + "\n";
  std::string padded = text;
  while (padded.size() < 34'000'000)
  {
    padded += comment;
  }
  this->WriteText("large.obj", padded);
  const std::string reported =
    "kdstream-build: note: large.obj: kdstream-convert reads the whole file, which "
    "takes about 68 MB in addition to --memory\n";
  const Outcome large = this->Build({ "large.obj", "-o", "m.kds", "--memory", "64M" });
  EXPECT_EQ(large.exitCode, 0) << large.err;
  EXPECT_EQ(large.err.substr(0, reported.size()), reported);
  for (const std::vector<std::string>& more : { std::vector<std::string>{ "--memory", "128M" },
         { "--memory", "64M", "--quiet" }, { "--memory", "64M", "--textures", "off" } })
  {
    std::vector<std::string> arguments{ "large.obj", "-o", "m.kds" };
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome built = this->Build(arguments);
    EXPECT_EQ(built.exitCode, 0) << built.err;
    EXPECT_EQ(built.err.find("beside"), std::string::npos) << built.err;
  }
}

// The peak is the larger one of the two processes; the conversion's own peak is counted, too.
TEST_F(TestTextureOptions, StatisticsCountTheConversion)
{
  const auto statsOf = [&](const std::string& input)
  {
    const Outcome built =
      this->Build({ input, "-o", "m.kds", "--quiet", "--stats", "s.json", "--threads", "1" });
    EXPECT_EQ(built.exitCode, 0) << built.err;
    auto stats = ParseJson(ReadWhole(this->Folder / "s.json"));
    EXPECT_TRUE(stats);
    const std::uint64_t peak = (*stats)["peak_rss_bytes"].GetUint64();
    EXPECT_LE(peak, built.peakBytes);
    EXPECT_GT(peak + 1'000'000, built.peakBytes); // memory used after the statistics were written
    return std::pair(peak, FindMember(*stats, "convert_peak_rss_bytes")
                             ? (*stats)["convert_peak_rss_bytes"].GetUint64()
                             : 0);
  };
  const auto [peak, converted] = statsOf("hard.obj");
  EXPECT_GT(converted, 10'000'000U);
  EXPECT_GE(peak, converted);
  EXPECT_EQ(statsOf("plain.obj").second, 0U);
}
