// SPDX-License-Identifier: BSD-3-Clause
// kdstream-view as a user runs it: playing sessions, what it shows and writes, exit codes and error
// messages. TestViewPictures tests the pictures, TestViewCache what is kept for later runs.
#include "viewer/desktop/Testing/ViewTest.h"
#include "viewer/session/SessionFile.h"

#include <sys/stat.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <map>
#include <string>
#include <tuple>
#include <vector>

using namespace kdstream;
using kdstream::fixtures::ReadWhole;
using kdstream::testing::ViewTest;

namespace
{

// Shows the preview, zooms in on the ring, and streams a region there.
constexpr const char* walk =
  "{\"select\":\"torus\"}\n{\"wait\":\"idle\"}\n{\"screenshot\":\"preview.png\"}\n"
  "{\"t\":0,\"touches\":[{\"id\":1,\"x\":280,\"y\":150},{\"id\":2,\"x\":320,\"y\":150}]}\n"
  "{\"t\":0.1,\"touches\":[{\"id\":1,\"x\":160,\"y\":150},{\"id\":2,\"x\":440,\"y\":150}]}\n"
  "{\"t\":0.2,\"touches\":[]}\n{\"wait\":\"idle\"}\n{\"screenshot\":\"level.png\"}\n"
  "{\"t\":1,\"touches\":[{\"id\":1,\"x\":300,\"y\":150}]}\n{\"t\":1.05,\"touches\":[]}\n"
  "{\"t\":1.2,\"touches\":[{\"id\":1,\"x\":300,\"y\":150}]}\n{\"t\":1.25,\"touches\":[]}\n"
  "{\"wait\":\"idle\"}\n{\"screenshot\":\"region.png\"}\n";

class TestView : public ViewTest
{
};

TEST_F(TestView, PlaysASessionAndWritesPicturesStatisticsAndARecording)
{
  this->Write("walk.jsonl", walk);
  ASSERT_EQ(this->View("--offscreen auto --size 400x300 --detail level --replay walk.jsonl "
                       "--stats stats.json --record again.jsonl --screenshot end.png"),
    0)
    << this->Err;
  EXPECT_EQ(this->Err, "");
  for (const char* name : { "preview.png", "level.png", "region.png", "end.png" })
  {
    EXPECT_TRUE(this->IsPicture(name)) << name;
  }
  EXPECT_NE(ReadWhole(this->Folder / "preview.png"), ReadWhole(this->Folder / "level.png"));
  EXPECT_NE(ReadWhole(this->Folder / "level.png"), ReadWhole(this->Folder / "region.png"));
  EXPECT_EQ(ReadWhole(this->Folder / "region.png"), ReadWhole(this->Folder / "end.png"));

  const auto stats = nlohmann::json::parse(ReadWhole(this->Folder / "stats.json"));
  std::map<std::string, int> count;
  for (const auto& blob : stats)
  {
    ++count[blob.at("what").get<std::string>()];
    EXPECT_GT(blob.at("bytes"), 0);
    EXPECT_GT(blob.at("vertices"), 0);
    EXPECT_GE(blob.at("transmission_s"), 0.0);
    EXPECT_GT(blob.at("parsing_s"), 0.0);
    EXPECT_GT(blob.at("rendering_s"), 0.0);
    EXPECT_EQ(blob.at("from_cache"), false);
  }
  EXPECT_EQ(count["preview"], 1);
  EXPECT_GT(count["level"], 0);
  EXPECT_GT(count["partition"], 1);
  const auto played = ParseSession(std::string(walk) + "{\"screenshot\":\"end.png\"}\n");
  EXPECT_EQ(*ParseSession(ReadWhole(this->Folder / "again.jsonl")), *played);
}

TEST_F(TestView, TheSameReplayAsksForTheSameBlobsAndDrawsTheSamePictures)
{
  this->Write("walk.jsonl", walk);
  const std::string options = "--offscreen auto --size 400x300 --replay walk.jsonl";
  ASSERT_EQ(this->View(options), 0) << this->Err;
  const auto blobs = this->Models.model->TakeRead();
  const std::string picture = ReadWhole(this->Folder / "region.png");
  EXPECT_GT(blobs.size(), 5u);
  ASSERT_EQ(this->View(options), 0) << this->Err;
  EXPECT_EQ(this->Models.model->TakeRead(), blobs);
  EXPECT_EQ(ReadWhole(this->Folder / "region.png"), picture);
}

TEST_F(TestView, WhatNeedsAModelWaitsForIt)
{
  const std::string select = "{\"select\":\"torus\"}\n", wait = "{\"wait\":\"idle\"}\n";
  const std::string zoom = "{\"zoom\":3,\"x\":150,\"y\":100}\n" + wait;
  this->Write("patient.jsonl", select + wait + zoom);
  this->Write("hasty.jsonl", select + zoom);
  this->Write("alone.jsonl", zoom); // not selected, but it is the only model
  for (const std::string name : { "patient", "hasty", "alone" })
  {
    ASSERT_EQ(this->View("--offscreen auto --size 200x150 --replay " + name +
                         ".jsonl --screenshot " + name + ".png"),
      0)
      << this->Err;
    EXPECT_EQ(ReadWhole(this->Folder / (name + ".png")), ReadWhole(this->Folder / "patient.png"))
      << name;
  }
}

TEST_F(TestView, EglAndOsMesaShowTheOnlyModelInFullScreen)
{
  for (const std::string backend : { "egl", "osmesa" })
  {
    ASSERT_EQ(
      this->View("--size 200x300 --offscreen " + backend + " --screenshot " + backend + ".png"), 0)
      << this->Err;
    EXPECT_TRUE(this->IsPicture(backend + ".png"));
  }
  EXPECT_EQ(ReadWhole(this->Folder / "egl.png"), ReadWhole(this->Folder / "osmesa.png"));
}

TEST_F(TestView, AViewThatWritesNothingSaysSo)
{
  const std::string offscreen = "--offscreen auto --size 64x64 ";
  ASSERT_EQ(this->View(offscreen), 0);
  EXPECT_EQ(this->Err.rfind("kdstream-view: showed ", 0), 0U) << this->Err;
  EXPECT_NE(this->Err.find(" pieces of http://"), std::string::npos) << this->Err;
  EXPECT_NE(this->Err.find("wrote no file: use --screenshot FILE"), std::string::npos) << this->Err;
  ASSERT_EQ(this->View(offscreen + "--stats s.json"), 0);
  EXPECT_EQ(this->Err, "");
  this->Write(
    "picture.jsonl", "{\"select\":\"torus\"}\n{\"wait\":\"idle\"}\n{\"screenshot\":\"p.png\"}\n");
  ASSERT_EQ(this->View(offscreen + "--replay picture.jsonl"), 0);
  EXPECT_EQ(this->Err, "");
}

// What is shown, and what it costs, with each value of --detail.
TEST_F(TestView, DetailFollowsTheViewOrIsOneForAll)
{
  std::map<std::string, nlohmann::json> reports;
  std::map<std::string, std::string> pictures;
  for (const std::string detail : { "view", "level", "full" })
  {
    ASSERT_EQ(this->View("--offscreen auto --size 1200x900 --detail " + detail +
                         " --report report.json --screenshot p.png"),
      0)
      << this->Err;
    reports[detail] = nlohmann::json::parse(ReadWhole(this->Folder / "report.json"));
    pictures[detail] = ReadWhole(this->Folder / "p.png");
    const nlohmann::json& report = reports[detail];
    EXPECT_GT(report.at("bytes"), 0);
    EXPECT_GT(report.at("blobs"), 0);
    EXPECT_LE(report.at("bytes_wasted"), report.at("bytes"));
    EXPECT_GT(report.at("seconds_to_first"), 0.0);
    EXPECT_GE(report.at("seconds_to_settled"), report.at("seconds_to_first"));
    EXPECT_GT(report.at("peak_rss_bytes"), 1'000'000);
  }
  const auto triangles = kdstream::testing::ServedTorus().Description().triangles;
  EXPECT_EQ(reports["full"].at("peak_triangles"), triangles);
  EXPECT_LT(reports["level"].at("peak_triangles"), triangles);
  EXPECT_NE(pictures["level"], pictures["full"]);

  // With a budget that the preview uses up.
  ASSERT_EQ(this->View("--offscreen auto --size 1200x900 --triangles 1000 --report report.json "
                       "--screenshot p.png"),
    0);
  const auto least = nlohmann::json::parse(ReadWhole(this->Folder / "report.json"));
  EXPECT_LT(least.at("peak_triangles"), reports["view"].at("peak_triangles"));
  EXPECT_EQ(this->View("--offscreen auto --view-memory 1M --screenshot p.png"), 2);
  EXPECT_NE(this->Err.find("'1M' is less than 16M"), std::string::npos) << this->Err;
}

TEST_F(TestView, MoreRingsStreamMore)
{
  this->Write("walk.jsonl", walk);
  std::size_t last = 0;
  for (const std::string rings : { "1", "2" })
  {
    ASSERT_EQ(
      this->View("--offscreen auto --size 400x300 --replay walk.jsonl --rings " + rings), 0);
    const std::size_t blobs = this->Models.model->TakeRead().size();
    EXPECT_GT(blobs, last);
    last = blobs;
  }
}

TEST_F(TestView, ADamagedBlobIsAnErrorLineAndTheRestIsShown)
{
  this->Models.model->damaged = protocol::BlobId::LevelPiece(12, 2);
  this->Models.model->damaged->level =
    static_cast<std::uint8_t>(kdstream::testing::ServedTorus().Description().depths.finest);
  ASSERT_TRUE(kdstream::testing::ServedTorus().Has(*this->Models.model->damaged));
  this->Write("zoom.jsonl", walk);
  EXPECT_EQ(this->View("--offscreen auto --size 400x300 --detail level --replay zoom.jsonl"), 1);
  EXPECT_EQ(this->Err.rfind("kdstream-view: error: http://127.0.0.1:", 0), 0u) << this->Err;
  EXPECT_NE(this->Err.find(protocol::BlobName(*this->Models.model->damaged)), std::string::npos);
  EXPECT_TRUE(this->IsPicture("region.png"));
  // Pictures that were written before the failure are complete.
  const auto incomplete = [](const std::string& name)
  {
    return "kdstream-view: warning: " + name +
           ": the picture is incomplete: a part of the model could not be loaded\n";
  };
  EXPECT_EQ(this->Err.find(incomplete("preview.png")), std::string::npos) << this->Err;
  EXPECT_NE(this->Err.find(incomplete("level.png")), std::string::npos) << this->Err;
  EXPECT_NE(this->Err.find(incomplete("region.png")), std::string::npos) << this->Err;
}

// An empty picture could be taken for a picture of the model.
TEST_F(TestView, APictureOfNothingIsNotWritten)
{
  const TreeDepths& depths = kdstream::testing::ServedTorus().Description().depths;
  this->Models.model->damaged =
    protocol::BlobId::LevelPiece(static_cast<std::uint8_t>(PreviewLevel(depths)), 1);
  ASSERT_TRUE(kdstream::testing::ServedTorus().Has(*this->Models.model->damaged));
  this->Write(
    "picture.jsonl", "{\"select\":\"torus\"}\n{\"wait\":\"idle\"}\n{\"screenshot\":\"p.png\"}\n");
  for (const std::string replay : { "", " --replay picture.jsonl" })
  {
    EXPECT_EQ(this->View("--offscreen auto --size 64x64 --screenshot none.png "
                         "--stats s.json --record r.jsonl" +
                         replay),
      1);
    EXPECT_NE(
      this->Err.find(
        "kdstream-view: error: none.png: is not written: no part of the model could be shown\n"),
      std::string::npos)
      << this->Err;
    EXPECT_EQ(this->Err.find("error: p.png: is not written") == std::string::npos, replay.empty());
    EXPECT_FALSE(std::filesystem::exists(this->Folder / "none.png"));
    EXPECT_FALSE(std::filesystem::exists(this->Folder / "p.png"));
    EXPECT_TRUE(std::filesystem::remove(this->Folder / "s.json")) << "the rest is written";
    EXPECT_TRUE(std::filesystem::remove(this->Folder / "r.jsonl"));
  }
}

TEST_F(TestView, WhatCannotBeShownIsSaidOnce)
{
  this->Models.model->described = kdstream::testing::ServedTorus().Description();
  this->Models.model->described->levels.clear();
  EXPECT_EQ(this->View("--offscreen auto --size 400x300 --report r.json"), 1);
  EXPECT_EQ(std::count(this->Err.begin(), this->Err.end(), '\n'), 1) << this->Err;
  EXPECT_NE(this->Err.find("torus cannot be shown: it has no levels of detail"), std::string::npos)
    << this->Err;
}

TEST_F(TestView, WrongUsageEndsWithTwoAndFailedWorkWithOne)
{
  this->Write("bad.jsonl", "{\"wait\":\"idle\"}\n{\"wait\":\"long\"}\n");
  this->Write("jpg.jsonl", "{\"wait\":\"idle\"}\n{\"screenshot\":\"w.jpg\"}\n");
  this->Write("folder.jsonl", "{\"screenshot\":\"no/w.png\"}\n");
  this->Write("empty.jsonl", "");
  this->Write("blank.jsonl", "\n \n");
  const std::string offscreen = "--offscreen auto --size 64x64 ";
  const std::vector<std::tuple<std::string, int, std::string>> cases = {
    { offscreen + "--replay jpg.jsonl", 1,
      " error: jpg.jsonl: line 2: 'w.jpg' must end in .png: pictures are written as PNG" },
    { offscreen + "--replay folder.jsonl", 1,
      " error: folder.jsonl: line 1: no/w.png: cannot create a file in no: No such file" },
    { offscreen + "--replay empty.jsonl", 1, " error: empty.jsonl: is empty" },
    { offscreen + "--replay blank.jsonl", 1, " error: blank.jsonl: has no steps" },
    { "", 1,
      " error: no window can be opened: X11: the environment variable DISPLAY is not set; "
      "use --offscreen auto to draw without a window" },
    { "--offscreen window", 2, "window" },
    { "--offscreen auto --size 0x5", 2, "0x5" },
    { "--offscreen auto --size 64x64x3", 2, "64x64x3" },
    { offscreen + "--rings 4", 2, "rings" },
    { offscreen + "--cache-size lots", 2, "--cache-size" },
    { offscreen + "--colour-by own --colour-map red", 2, "colour-map" },
    { offscreen + "--light dark", 2, "--light" },
    { offscreen + "--model nobody", 1, "'nobody'" },
    { offscreen + "--replay missing.jsonl", 1, "missing.jsonl" },
    { offscreen + "--replay bad.jsonl", 1, "bad.jsonl: line 2: " },
    { offscreen + "--screenshot no/such/folder.png", 1, "no/such/folder.png" },
    { offscreen + "--screenshot v.jpg", 2, "'v.jpg' must end in .png" },
    { offscreen + "--screenshot png", 2, "'png' must end in .png" },
    { offscreen + "--stats no/such/file", 1, "no/such/file" },
    { offscreen + "--stats a.json --report ./a.json", 2, "two outputs cannot have the same file" },
  };
  for (const auto& [options, code, what] : cases)
  {
    EXPECT_EQ(this->View(options), code) << options;
    EXPECT_EQ(this->Err.rfind("kdstream-view: error: ", 0), 0u) << this->Err;
    EXPECT_NE(this->Err.find(what), std::string::npos) << this->Err;
    EXPECT_EQ(std::count(this->Err.begin(), this->Err.end(), '\n'), 1) << this->Err;
  }
  EXPECT_FALSE(std::filesystem::exists(this->Folder / "w.jpg"));
  EXPECT_EQ(this->Run("nowhere " + offscreen), 1);
  EXPECT_EQ(this->Err, "kdstream-view: error: nowhere: there is no such file, and a server's "
                       "address must be http://HOST:PORT or https://HOST:PORT\n");
  EXPECT_EQ(this->View("--ca m.pem " + offscreen), 2);
  EXPECT_NE(this->Err.find("--ca needs an https server"), std::string::npos) << this->Err;
  EXPECT_EQ(this->Run("https://127.0.0.1 --ca m.pem " + offscreen), 1);
  EXPECT_NE(this->Err.find("m.pem: cannot be read"), std::string::npos) << this->Err;
  ASSERT_EQ(::mkfifo((this->Folder / "pipe.kds").c_str(), 0600), 0);
  EXPECT_EQ(this->Run("pipe.kds " + offscreen), 1); // nobody ever writes to it
  EXPECT_EQ(this->Err, "kdstream-view: error: pipe.kds: is neither a file nor a folder\n");
  EXPECT_EQ(this->View("--replay pipe.kds " + offscreen), 1);
  EXPECT_EQ(this->Err, "kdstream-view: error: pipe.kds: is a named pipe, not a file\n");
  std::filesystem::remove(this->Folder / "pipe.kds");
  EXPECT_EQ(this->Run(". " + offscreen), 1);
  EXPECT_EQ(this->Err, "kdstream-view: error: .: this folder has no stores (.kds)\n");
  this->Write("m.kds", "SQLite format 3");
  EXPECT_EQ(this->Run("m.kds " + offscreen), 1);
  EXPECT_EQ(this->Err.rfind("kdstream-view: error: m.kds: ", 0), 0U) << this->Err;
  EXPECT_EQ(std::count(this->Err.begin(), this->Err.end(), '\n'), 1) << this->Err;
  const std::string url = this->Server->Url();
  this->Server.reset();
  EXPECT_EQ(this->Run(url + " " + offscreen), 1);
  EXPECT_NE(this->Err.find("cannot be reached"), std::string::npos) << this->Err;
}

TEST_F(TestView, PrintsItsOptionsAndVersion)
{
  EXPECT_EQ(this->Run("--help"), 0);
  for (const char* word : { "--replay", "--offscreen", "--rings", "--stats", "--size", "--record",
         "--colour-by", "--light", "own (the model", "Example", "WxH" })
  {
    EXPECT_NE(this->Out.find(word), std::string::npos) << word;
  }
  EXPECT_EQ(this->Run("--version"), 0);
  EXPECT_FALSE(this->Out.empty());
}

}
