// SPDX-License-Identifier: BSD-3-Clause
// What kdstream-view's pictures show besides the shape: light, the colours of an array and their
// legend, and the view and distances of a link.
#include "viewer/desktop/Testing/PicturesCompared.h"
#include "viewer/desktop/Testing/ViewTest.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <array>
#include <map>
#include <string>
#include <utility>

using namespace kdstream;
using kdstream::fixtures::ReadWhole;
using kdstream::testing::BoxThatDiffers;
using kdstream::testing::CountOfColor;
using kdstream::testing::ShareThatDiffers;
using kdstream::testing::ViewTest;

namespace
{

class TestViewPictures : public ViewTest
{
};

TEST_F(TestViewPictures, LightShowsReliefUnlessItIsPlain)
{
  const auto view = [this](const std::string& light)
  {
    EXPECT_EQ(this->View("--size 200x300 --offscreen auto --screenshot p.png" + light), 0);
    return ReadWhole(this->Folder / "p.png");
  };
  const std::string usual = view("");
  EXPECT_EQ(view(" --light relief"), usual);
  EXPECT_NE(view(" --light plain"), usual);
}

// A point cloud with an intensity and a class for each point, as PLY.
std::string CloudWithArrays()
{
  std::string ply = "ply\nformat ascii 1.0\nelement vertex 3600\nproperty float x\n"
                    "property float y\nproperty float z\nproperty float reflectance\n"
                    "property uchar classification\nend_header\n";
  for (int i = 0; i < 3600; ++i)
  {
    const int x = i % 60, y = i / 60;
    ply += std::to_string(x) + " " + std::to_string(y) + " 0 " + std::to_string(x * 0.25) + " " +
           std::to_string(x < 30 ? 2 : 6) + "\n";
  }
  return ply;
}

// Arrays other than the coordinates are streamed, and can be shown.
TEST_F(TestViewPictures, ColoursByAnArray)
{
  this->Write("cloud.ply", CloudWithArrays());
  const std::string view = "cloud.ply --offscreen auto --size 200x200 --cache kept --screenshot ";
  ASSERT_EQ(this->Run(view + "own.png"), 0) << this->Err;
  ASSERT_EQ(this->Run(view + "a.png --colour-by reflectance --report r.json"), 0) << this->Err;
  EXPECT_GT(ShareThatDiffers(this->Folder / "a.png", this->Folder / "own.png"), 0.1);
  ASSERT_EQ(this->Run(view + "b.png --color-by reflectance --colour-range 0,14.75"), 0);
  EXPECT_GT(ShareThatDiffers(this->Folder / "b.png", this->Folder / "own.png"), 0.1);
  ASSERT_EQ(this->Run(view + "c.png --colour-by reflectance --colour-map diverging"), 0);
  EXPECT_GT(ShareThatDiffers(this->Folder / "c.png", this->Folder / "a.png"), 0.1);
  ASSERT_EQ(this->Run(view + "d.png --colour-by classification"), 0) << this->Err;
  EXPECT_GT(ShareThatDiffers(this->Folder / "d.png", this->Folder / "a.png"), 0.1);
  EXPECT_NE(ReadWhole(this->Folder / "r.json").find("&colours=by:reflectance"), std::string::npos);
  EXPECT_EQ(this->Run(view + "e.png --colour-by nothing"), 1);
  EXPECT_NE(this->Err.find("the model has no array of numbers 'nothing' to colour it by; it has "
                           "'reflectance', 'classification'"),
    std::string::npos)
    << this->Err;
  EXPECT_EQ(this->Run(view + "e.png --colour-by reflectanse"), 1);
  EXPECT_NE(this->Err.find("it has 'reflectance', 'classification'; did you mean reflectance?\n"),
    std::string::npos)
    << this->Err;
  EXPECT_FALSE(std::filesystem::exists(this->Folder / "e.png"));
  EXPECT_EQ(this->Run(view + "e.png --colour-map cividis"), 2) << this->Err;
  EXPECT_EQ(this->Run(view + "e.png --colour-by reflectance --colour-range 2,1"), 2) << this->Err;
}

// There is a legend only if the colours are those of an array, only in the picture of --screenshot,
// and only in the picture's corner.
TEST_F(TestViewPictures, APictureHasALegend)
{
  this->Write("cloud.ply", CloudWithArrays());
  this->Write("session.jsonl",
    "{\"select\":\"cloud\"}\n{\"select\":\"cloud\"}\n{\"wait\":\"idle\"}\n"
    "{\"screenshot\":\"step.png\"}\n");
  const std::string view = "cloud.ply --offscreen auto --size 640x480 --cache kept --screenshot ";
  for (const std::string array : { "reflectance", "classification" })
  {
    const std::string by = " --colour-by " + array;
    ASSERT_EQ(this->Run(view + "with.png" + by), 0) << this->Err;
    ASSERT_EQ(this->Run(view + "without.png --legend off" + by), 0) << this->Err;
    const double share = ShareThatDiffers(this->Folder / "with.png", this->Folder / "without.png");
    EXPECT_GT(share, 0.01) << array;
    EXPECT_LT(share, 0.2) << array;
    // The colour of the text, and a colour that no light shades: the map's upper end or that of the
    // class "ground".
    const std::array<int, 3> words{ 235, 235, 235 };
    const std::array<int, 3> shown =
      array == "reflectance" ? std::array{ 250, 230, 36 } : std::array{ 160, 112, 60 };
    EXPECT_GT(CountOfColor(this->Folder / "with.png", words, 60), 100) << array;
    EXPECT_EQ(CountOfColor(this->Folder / "without.png", words, 60), 0) << array;
    EXPECT_GT(CountOfColor(this->Folder / "with.png", shown), 20) << array;
    EXPECT_EQ(CountOfColor(this->Folder / "without.png", shown), 0) << array;
    const auto box = BoxThatDiffers(this->Folder / "with.png", this->Folder / "without.png");
    EXPECT_GT(box[0], 400) << array;
    EXPECT_LT(box[2], 640 - 8) << array;
    EXPECT_LT(box[1], 40) << array;
    EXPECT_GT(box[1], 4) << array;
    ASSERT_EQ(this->Run(view + "last.png --replay session.jsonl" + by), 0) << this->Err;
    EXPECT_LT(ShareThatDiffers(this->Folder / "step.png", this->Folder / "last.png"), 0.2);
    EXPECT_GT(ShareThatDiffers(this->Folder / "step.png", this->Folder / "last.png"), 0.01)
      << "the session's own picture shows the model alone";
  }
  for (const std::string colors : { "own", "partition" })
  {
    const std::string by = " --colour-by " + colors;
    ASSERT_EQ(this->Run(view + "with.png" + by), 0) << this->Err;
    ASSERT_EQ(this->Run(view + "without.png --legend off" + by), 0) << this->Err;
    EXPECT_EQ(ReadWhole(this->Folder / "with.png"), ReadWhole(this->Folder / "without.png"));
  }
  EXPECT_EQ(this->Run("cloud.ply --offscreen auto --size 60x40 --cache kept --screenshot tiny.png "
                      "--colour-by classification"),
    0)
    << this->Err;
}

TEST_F(TestViewPictures, ALinkOpensTheViewThatItNames)
{
  const std::string url = this->Server->Url();
  const std::string view = " --offscreen auto --size 200x150 --screenshot ";
  ASSERT_EQ(this->Run(url + " --colour-by partition --detail level" + view + "a.png"), 0);
  ASSERT_EQ(
    this->Run("'" + url + "/#model=torus&colours=partition&detail=level'" + view + "b.png"), 0)
    << this->Err;
  EXPECT_EQ(ReadWhole(this->Folder / "b.png"), ReadWhole(this->Folder / "a.png"));
  ASSERT_EQ(
    this->Run("'" + url + "/m/torus#model=torus&colours=partition&detail=level'" + view + "b.png"),
    0)
    << this->Err;
  EXPECT_EQ(ReadWhole(this->Folder / "b.png"), ReadWhole(this->Folder / "a.png")) << "by its page";
  ASSERT_EQ(this->Run(url + "/m/torus/ --colour-by partition --detail level" + view + "b.png"), 0)
    << this->Err;
  // The link in one report shows the same view in another run.
  this->Write("zoom.jsonl",
    "{\"turning\":\"upright\"}\n{\"select\":\"torus\"}\n{\"select\":\"torus\"}\n"
    "{\"wait\":\"idle\"}\n{\"zoom\":2,\"x\":120,\"y\":70}\n{\"wait\":\"idle\"}\n");
  ASSERT_EQ(this->Run(url + " --replay zoom.jsonl --report r.json" + view + "c.png"), 0);
  const std::string reported =
    nlohmann::json::parse(ReadWhole(this->Folder / "r.json")).at("link").get<std::string>();
  ASSERT_EQ(this->Run("'" + url + "#" + reported + "'" + view + "e.png"), 0) << this->Err;
  EXPECT_LT(ShareThatDiffers(this->Folder / "c.png", this->Folder / "e.png"), 0.002) << reported;
  EXPECT_GT(ShareThatDiffers(this->Folder / "c.png", this->Folder / "a.png"), 0.1);
  for (const auto& [link, what] : { std::pair{ "#model=other", "no model 'other'" },
         { "#model=torus&view=AAAA", "invalid value for view" },
         { "#model=a/b", "invalid value for model" } })
  {
    EXPECT_EQ(this->Run("'" + url + link + "'" + view + "d.png"), 1);
    EXPECT_NE(this->Err.find(what), std::string::npos) << this->Err;
  }
  EXPECT_EQ(this->Run("'" + url + "#model=torus' --replay zoom.jsonl" + view + "d.png"), 2);
  EXPECT_NE(this->Err.find("cannot be combined with --replay"), std::string::npos) << this->Err;
}

// Pictures of --screenshot show the lines, ends and figures of distances, whether a session
// measured them or a link to that session's view has them.
TEST_F(TestViewPictures, APictureHasTheDistancesOfItsLink)
{
  const std::string url = this->Server->Url();
  const std::string view = " --offscreen auto --size 640x480 --screenshot ";
  const std::string lines =
    "{\"turning\":\"upright\"}\n{\"select\":\"torus\"}\n{\"select\":\"torus\"}\n"
    "{\"wait\":\"idle\"}\n";
  this->Write("measure.jsonl",
    lines + "{\"tool\":\"measure\"}\n"
            "{\"t\":1,\"touches\":[{\"id\":1,\"x\":150,\"y\":240}]}\n{\"t\":1.05,\"touches\":[]}\n"
            "{\"t\":2,\"touches\":[{\"id\":1,\"x\":490,\"y\":240}]}\n{\"t\":2.05,\"touches\":[]}\n"
            "{\"wait\":\"idle\"}\n{\"screenshot\":\"step.png\"}\n");
  ASSERT_EQ(this->Run(url + " --replay measure.jsonl --report r.json" + view + "last.png"), 0)
    << this->Err;
  const std::string link =
    nlohmann::json::parse(ReadWhole(this->Folder / "r.json")).at("link").get<std::string>();
  const std::size_t begin = link.find("&distances=");
  ASSERT_NE(begin, std::string::npos) << link;
  ASSERT_EQ(this->Run("'" + url + "#" + link + "'" + view + "link.png"), 0) << this->Err;
  EXPECT_LT(ShareThatDiffers(this->Folder / "last.png", this->Folder / "link.png"), 0.002) << link;
  // The same view without the distances.
  std::string bare = link;
  bare.erase(begin, link.find('&', begin + 1) - begin);
  ASSERT_EQ(this->Run("'" + url + "#" + bare + "'" + view + "bare.png"), 0) << this->Err;
  const std::array<int, 3> yellow{ 255, 209, 102 };
  EXPECT_GT(CountOfColor(this->Folder / "link.png", yellow), 600) << "a line of 340 pixels";
  EXPECT_EQ(CountOfColor(this->Folder / "bare.png", yellow), 0);
  EXPECT_EQ(CountOfColor(this->Folder / "step.png", yellow), 0)
    << "the session's own picture shows the model alone";
  const auto box = BoxThatDiffers(this->Folder / "link.png", this->Folder / "bare.png");
  EXPECT_NEAR(box[0], 150 - 5, 3) << "the disc at one end";
  EXPECT_NEAR(box[2], 490 + 5, 3) << "and at the other";
  EXPECT_NEAR(box[1], 240 - 5, 4) << "from below";
  EXPECT_NEAR(box[3], 240 + 6 + 17, 5) << "the figure above the line";
}

}
