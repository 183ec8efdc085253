// SPDX-License-Identifier: BSD-3-Clause
// kdstream-view as a person runs it: pictures, statistics, recordings, exit codes and error lines.
#include "server/http/HttpServer.h"
#include "viewer/client/Testing/TorusCatalog.h"
#include "viewer/desktop/Testing/PicturesCompared.h"
#include "viewer/session/SessionFile.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

using namespace kdstream;
using kdstream::testing::BoxThatDiffers;
using kdstream::testing::CountOfColor;
using kdstream::testing::ShareThatDiffers;
using kdstream::testing::TorusCatalog;

namespace
{

std::string program; // kdstream-view

std::string ReadText(const std::filesystem::path& file)
{
  std::ifstream input(file, std::ios::binary);
  return { std::istreambuf_iterator<char>(input), {} };
}

// Browses, zooms in on the ring, streams a region there.
constexpr const char* walk =
  "{\"select\":\"torus\"}\n{\"wait\":\"idle\"}\n{\"screenshot\":\"preview.png\"}\n"
  "{\"t\":0,\"touches\":[{\"id\":1,\"x\":280,\"y\":150},{\"id\":2,\"x\":320,\"y\":150}]}\n"
  "{\"t\":0.1,\"touches\":[{\"id\":1,\"x\":160,\"y\":150},{\"id\":2,\"x\":440,\"y\":150}]}\n"
  "{\"t\":0.2,\"touches\":[]}\n{\"wait\":\"idle\"}\n{\"screenshot\":\"level.png\"}\n"
  "{\"t\":1,\"touches\":[{\"id\":1,\"x\":300,\"y\":150}]}\n{\"t\":1.05,\"touches\":[]}\n"
  "{\"t\":1.2,\"touches\":[{\"id\":1,\"x\":300,\"y\":150}]}\n{\"t\":1.25,\"touches\":[]}\n"
  "{\"wait\":\"idle\"}\n{\"screenshot\":\"region.png\"}\n";

class TestView : public ::testing::Test
{
protected:
  TestView()
  {
    std::string name = (std::filesystem::temp_directory_path() / "kdstream-view-XXXXXX").string();
    this->Folder = ::mkdtemp(name.data());
    this->Server = std::move(*HttpServer::Start(this->Models, {}));
  }
  ~TestView() override { std::filesystem::remove_all(this->Folder); }

  // Runs kdstream-view with this server's URL in the test's folder; the exit code.
  int View(const std::string& options) { return this->Run(this->Server->Url() + " " + options); }
  int Run(const std::string& arguments)
  {
    const std::string command =
      "cd '" + this->Folder.string() + "' && '" + program + "' " + arguments + " >out 2>err";
    const int status = std::system(command.c_str());
    this->Out = ReadText(this->Folder / "out");
    this->Err = ReadText(this->Folder / "err");
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  void Write(const std::string& name, const std::string& text)
  {
    std::ofstream(this->Folder / name) << text;
  }
  bool IsPicture(const std::string& name)
  {
    return ReadText(this->Folder / name).substr(1, 3) == "PNG";
  }

  std::filesystem::path Folder;
  TorusCatalog Models;
  std::unique_ptr<HttpServer> Server;
  std::string Out, Err;
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
  EXPECT_NE(ReadText(this->Folder / "preview.png"), ReadText(this->Folder / "level.png"));
  EXPECT_NE(ReadText(this->Folder / "level.png"), ReadText(this->Folder / "region.png"));
  EXPECT_EQ(ReadText(this->Folder / "region.png"), ReadText(this->Folder / "end.png"));

  const auto stats = nlohmann::json::parse(ReadText(this->Folder / "stats.json"));
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
  EXPECT_EQ(*ParseSession(ReadText(this->Folder / "again.jsonl")), *played);
}

TEST_F(TestView, TheSameReplayAsksForTheSameBlobsAndDrawsTheSamePictures)
{
  this->Write("walk.jsonl", walk);
  const std::string options = "--offscreen auto --size 400x300 --replay walk.jsonl";
  ASSERT_EQ(this->View(options), 0) << this->Err;
  const auto blobs = this->Models.model->TakeRead();
  const std::string picture = ReadText(this->Folder / "region.png");
  EXPECT_GT(blobs.size(), 5u);
  ASSERT_EQ(this->View(options), 0) << this->Err;
  EXPECT_EQ(this->Models.model->TakeRead(), blobs);
  EXPECT_EQ(ReadText(this->Folder / "region.png"), picture);
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
  EXPECT_EQ(ReadText(this->Folder / "egl.png"), ReadText(this->Folder / "osmesa.png"));
}

TEST_F(TestView, LightShowsReliefUnlessItIsPlain)
{
  const auto look = [this](const std::string& light)
  {
    EXPECT_EQ(this->View("--size 200x300 --offscreen auto --screenshot p.png" + light), 0);
    return ReadText(this->Folder / "p.png");
  };
  const std::string usual = look("");
  EXPECT_EQ(look(" --light relief"), usual);
  EXPECT_NE(look(" --light plain"), usual);
}

TEST_F(TestView, ALookThatWritesNothingSaysSo)
{
  const std::string offscreen = "--offscreen auto --size 64x64 ";
  ASSERT_EQ(this->View(offscreen), 0);
  EXPECT_EQ(this->Err.rfind("kdstream-view: showed ", 0), 0U) << this->Err;
  EXPECT_NE(this->Err.find(" pieces of http://"), std::string::npos) << this->Err;
  EXPECT_NE(this->Err.find("wrote nothing: --screenshot FILE"), std::string::npos) << this->Err;
  ASSERT_EQ(this->View(offscreen + "--stats s.json"), 0);
  EXPECT_EQ(this->Err, "");
  this->Write(
    "picture.jsonl", "{\"select\":\"torus\"}\n{\"wait\":\"idle\"}\n{\"screenshot\":\"p.png\"}\n");
  ASSERT_EQ(this->View(offscreen + "--replay picture.jsonl"), 0);
  EXPECT_EQ(this->Err, "");
}

// By the view, with one level, and all: what is shown and what it took.
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
    reports[detail] = nlohmann::json::parse(ReadText(this->Folder / "report.json"));
    pictures[detail] = ReadText(this->Folder / "p.png");
    const nlohmann::json& report = reports[detail];
    EXPECT_GT(report.at("bytes"), 0);
    EXPECT_GT(report.at("blobs"), 0);
    EXPECT_LE(report.at("bytes_wasted"), report.at("bytes"));
    EXPECT_GT(report.at("seconds_to_first"), 0.0);
    EXPECT_GE(report.at("seconds_to_settled"), report.at("seconds_to_first"));
    EXPECT_GT(report.at("peak_rss_bytes"), 1'000'000);
  }
  const auto triangles = kdstream::testing::Torus().Description().triangles;
  EXPECT_EQ(reports["full"].at("peak_triangles"), triangles);
  EXPECT_LT(reports["level"].at("peak_triangles"), triangles);
  EXPECT_NE(pictures["level"], pictures["full"]);

  // A budget that the preview fills.
  ASSERT_EQ(this->View("--offscreen auto --size 1200x900 --triangles 1000 --report report.json "
                       "--screenshot p.png"),
    0);
  const auto least = nlohmann::json::parse(ReadText(this->Folder / "report.json"));
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
    static_cast<std::uint8_t>(kdstream::testing::Torus().Description().depths.finest);
  ASSERT_TRUE(kdstream::testing::Torus().Has(*this->Models.model->damaged));
  this->Write("zoom.jsonl", walk);
  EXPECT_EQ(this->View("--offscreen auto --size 400x300 --detail level --replay zoom.jsonl"), 1);
  EXPECT_EQ(this->Err.rfind("kdstream-view: error: http://127.0.0.1:", 0), 0u) << this->Err;
  EXPECT_NE(this->Err.find(protocol::BlobName(*this->Models.model->damaged)), std::string::npos);
  EXPECT_TRUE(this->IsPicture("region.png"));
  // Pictures from before are whole.
  const auto incomplete = [](const std::string& name)
  {
    return "kdstream-view: warning: " + name +
           ": is incomplete: a part of the model could not be loaded\n";
  };
  EXPECT_EQ(this->Err.find(incomplete("preview.png")), std::string::npos) << this->Err;
  EXPECT_NE(this->Err.find(incomplete("level.png")), std::string::npos) << this->Err;
  EXPECT_NE(this->Err.find(incomplete("region.png")), std::string::npos) << this->Err;
}

// A picture of nothing would pass for one of the model.
TEST_F(TestView, APictureOfNothingIsNotWritten)
{
  const TreeDepths& depths = kdstream::testing::Torus().Description().depths;
  this->Models.model->damaged =
    protocol::BlobId::LevelPiece(static_cast<std::uint8_t>(PreviewLevel(depths)), 1);
  ASSERT_TRUE(kdstream::testing::Torus().Has(*this->Models.model->damaged));
  this->Write(
    "picture.jsonl", "{\"select\":\"torus\"}\n{\"wait\":\"idle\"}\n{\"screenshot\":\"p.png\"}\n");
  for (const std::string replay : { "", " --replay picture.jsonl" })
  {
    EXPECT_EQ(this->View("--offscreen auto --size 64x64 --screenshot none.png "
                         "--stats s.json --record r.jsonl" +
                         replay),
      1);
    EXPECT_NE(this->Err.find("kdstream-view: error: none.png: is not written: nothing of the model "
                             "could be shown\n"),
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
  this->Models.model->described = kdstream::testing::Torus().Description();
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
      " error: jpg.jsonl: line 2: 'w.jpg' does not end in .png, and pictures are written as PNG" },
    { offscreen + "--replay folder.jsonl", 1,
      " error: folder.jsonl: line 1: no/w.png: cannot create a file in no: No such file" },
    { offscreen + "--replay empty.jsonl", 1, " error: empty.jsonl: is empty" },
    { offscreen + "--replay blank.jsonl", 1, " error: blank.jsonl: has no steps" },
    { "", 1,
      " error: no window can be opened: X11: the environment variable DISPLAY is not set; "
      "--offscreen auto draws without one" },
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
    { offscreen + "--screenshot v.jpg", 2, "'v.jpg' does not end in .png" },
    { offscreen + "--screenshot png", 2, "'png' does not end in .png" },
    { offscreen + "--stats no/such/file", 1, "no/such/file" },
    { offscreen + "--stats a.json --report ./a.json", 2, "two outputs cannot be written to one" },
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
  EXPECT_EQ(this->Err, "kdstream-view: error: nowhere: there is no such file, and the address of a "
                       "server is http://HOST:PORT or https://HOST:PORT\n");
  EXPECT_EQ(this->View("--ca m.pem " + offscreen), 2);
  EXPECT_NE(this->Err.find("--ca is of no use without https"), std::string::npos) << this->Err;
  EXPECT_EQ(this->Run("https://127.0.0.1 --ca m.pem " + offscreen), 1);
  EXPECT_NE(this->Err.find("m.pem: cannot be read"), std::string::npos) << this->Err;
  EXPECT_EQ(this->Run(". " + offscreen), 1);
  EXPECT_EQ(this->Err, "kdstream-view: error: .: no stores (.kds) are in this folder\n");
  this->Write("m.kds", "SQLite format 3");
  EXPECT_EQ(this->Run("m.kds " + offscreen), 1);
  EXPECT_EQ(this->Err.rfind("kdstream-view: error: m.kds: ", 0), 0U) << this->Err;
  EXPECT_EQ(std::count(this->Err.begin(), this->Err.end(), '\n'), 1) << this->Err;
  const std::string url = this->Server->Url();
  this->Server.reset();
  EXPECT_EQ(this->Run(url + " " + offscreen), 1);
  EXPECT_NE(this->Err.find("cannot be reached"), std::string::npos) << this->Err;
}

std::string TetrahedronPly()
{
  return "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
         "property float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n"
         "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
}

TEST_F(TestView, AMeshIsBuiltOnceAndKeptInTheCache)
{
  this->Write("My solid.ply", TetrahedronPly());
  const std::string look = "--offscreen auto --size 64x64 --screenshot p.png --cache kept";
  ASSERT_EQ(this->Run("'My solid.ply' " + look), 0) << this->Err;
  EXPECT_TRUE(this->IsPicture("p.png"));
  const std::string picture = ReadText(this->Folder / "p.png");
  std::vector<std::filesystem::path> stores;
  const auto list = [&]
  {
    stores.clear();
    for (const auto& entry : std::filesystem::recursive_directory_iterator(this->Folder / "kept"))
    {
      if (entry.is_regular_file())
      {
        stores.push_back(entry.path());
      }
    }
  };
  list();
  ASSERT_EQ(stores.size(), 1u);
  EXPECT_EQ(stores[0].filename(), "My_solid.kds");
  const auto built = std::filesystem::last_write_time(stores[0]);
  const auto store = stores[0];
  ASSERT_EQ(this->Run("'My solid.ply' " + look), 0) << this->Err;
  EXPECT_EQ(std::filesystem::last_write_time(store), built) << "it was there";
  EXPECT_EQ(ReadText(this->Folder / "p.png"), picture);
  // The store itself, and the folder that it is in.
  for (const auto& path : { store, store.parent_path() })
  {
    ASSERT_EQ(this->Run("'" + path.string() + "' " + look), 0) << this->Err;
    EXPECT_EQ(ReadText(this->Folder / "p.png"), picture);
  }
  // Another mesh takes its place where the cache is full; what is shown stays.
  this->Write("other.ply", TetrahedronPly() + "\n");
  ASSERT_EQ(this->Run("other.ply " + look + " --cache-size 1"), 0) << this->Err;
  list();
  ASSERT_EQ(stores.size(), 1u);
  EXPECT_EQ(stores[0].filename(), "other.kds");
}

TEST_F(TestView, WhatWasSeenIsThereWithoutTheServer)
{
  const std::string look = "--offscreen auto --size 200x150 --stats s.json --screenshot ";
  const auto fromCache = [this]
  {
    std::size_t count = 0;
    for (const auto& blob : nlohmann::json::parse(ReadText(this->Folder / "s.json")))
    {
      count += blob.at("from_cache").get<bool>() ? 1 : 0;
    }
    return count;
  };
  ASSERT_EQ(this->View(look + "a.png --cache kept"), 0) << this->Err;
  EXPECT_EQ(fromCache(), 0u);
  EXPECT_FALSE(this->Models.model->TakeRead().empty());
  ASSERT_EQ(this->View(look + "b.png --cache kept"), 0) << this->Err;
  EXPECT_GT(fromCache(), 0u);
  EXPECT_TRUE(this->Models.model->TakeRead().empty());
  ASSERT_EQ(this->View(look + "b.png"), 0) << this->Err;
  EXPECT_EQ(fromCache(), 0u) << "no cache where none is named";
  const std::string url = this->Server->Url();
  this->Server.reset();
  ASSERT_EQ(this->Run(url + " " + look + "c.png --cache kept"), 0) << this->Err;
  EXPECT_EQ(this->Err.rfind("kdstream-view: warning: " + url + ": ", 0), 0u) << this->Err;
  EXPECT_NE(this->Err.find("; what was seen before is shown\n"), std::string::npos) << this->Err;
  EXPECT_EQ(ReadText(this->Folder / "c.png"), ReadText(this->Folder / "a.png"));
  // Of much that was not seen, some is told, and how much more.
  ASSERT_EQ(this->Run(url + " " + look + "e.png --detail full --cache kept"), 1);
  std::size_t lines = 0;
  for (auto at = this->Err.find(": error: "); at != std::string::npos; ++lines)
  {
    at = this->Err.find(": error: ", at + 1);
  }
  EXPECT_EQ(lines, 2u) << this->Err;
  EXPECT_NE(this->Err.find(" more such errors\n"), std::string::npos) << this->Err;
  // A folder that cannot be is no reason to show nothing, where there is a server.
  EXPECT_EQ(this->Run(url + " " + look + "d.png --cache s.json"), 1);
  EXPECT_NE(this->Err.find("warning: s.json: "), std::string::npos) << this->Err;
}

TEST_F(TestView, AMeshIsSeenWhereNothingCanBeKept)
{
  this->Write("nest.ply", TetrahedronPly());
  std::filesystem::create_directory(this->Folder / "brief");
  const std::string look = "nest.ply --offscreen auto --size 64x64 --screenshot n.png --cache ";
  ASSERT_EQ(this->Run(look + "kept"), 0) << this->Err;
  const std::string seen = ReadText(this->Folder / "n.png");
  ::setenv("TMPDIR", (this->Folder / "brief").c_str(), 1);
  EXPECT_EQ(this->Run(look + "nest.ply/below"), 0) << this->Err;
  ::unsetenv("TMPDIR");
  EXPECT_NE(
    this->Err.find("kdstream-view: warning: nest.ply/below: cannot be made: "), std::string::npos)
    << this->Err;
  EXPECT_NE(this->Err.find("the store that is made of the mesh is not kept\n"), std::string::npos);
  EXPECT_EQ(ReadText(this->Folder / "n.png"), seen);
  EXPECT_TRUE(std::filesystem::is_empty(this->Folder / "brief"));
}

// A cloud with an intensity and classes, as PLY.
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

// What is not geometry travels, and is shown.
TEST_F(TestView, ColoursByAnArray)
{
  this->Write("cloud.ply", CloudWithArrays());
  const std::string look = "cloud.ply --offscreen auto --size 200x200 --cache kept --screenshot ";
  ASSERT_EQ(this->Run(look + "own.png"), 0) << this->Err;
  ASSERT_EQ(this->Run(look + "a.png --colour-by reflectance --report r.json"), 0) << this->Err;
  EXPECT_GT(ShareThatDiffers(this->Folder / "a.png", this->Folder / "own.png"), 0.1);
  ASSERT_EQ(this->Run(look + "b.png --color-by reflectance --colour-range 0,14.75"), 0);
  EXPECT_GT(ShareThatDiffers(this->Folder / "b.png", this->Folder / "own.png"), 0.1);
  ASSERT_EQ(this->Run(look + "c.png --colour-by reflectance --colour-map diverging"), 0);
  EXPECT_GT(ShareThatDiffers(this->Folder / "c.png", this->Folder / "a.png"), 0.1);
  ASSERT_EQ(this->Run(look + "d.png --colour-by classification"), 0) << this->Err;
  EXPECT_GT(ShareThatDiffers(this->Folder / "d.png", this->Folder / "a.png"), 0.1);
  EXPECT_NE(ReadText(this->Folder / "r.json").find("&colours=by:reflectance"), std::string::npos);
  EXPECT_EQ(this->Run(look + "e.png --colour-by nothing"), 1);
  EXPECT_NE(this->Err.find("the model has no array of numbers 'nothing' to be coloured by; it has "
                           "'reflectance', 'classification'"),
    std::string::npos)
    << this->Err;
  EXPECT_EQ(this->Run(look + "e.png --colour-by reflectanse"), 1);
  EXPECT_NE(this->Err.find("it has 'reflectance', 'classification'; did you mean reflectance?\n"),
    std::string::npos)
    << this->Err;
  EXPECT_FALSE(std::filesystem::exists(this->Folder / "e.png"));
  EXPECT_EQ(this->Run(look + "e.png --colour-map cividis"), 2) << this->Err;
  EXPECT_EQ(this->Run(look + "e.png --colour-by reflectance --colour-range 2,1"), 2) << this->Err;
}

// Only where colours are those of an array, only in --screenshot, and in its corner.
TEST_F(TestView, APictureHasALegend)
{
  this->Write("cloud.ply", CloudWithArrays());
  this->Write("session.jsonl",
    "{\"select\":\"cloud\"}\n{\"select\":\"cloud\"}\n{\"wait\":\"idle\"}\n"
    "{\"screenshot\":\"step.png\"}\n");
  const std::string look = "cloud.ply --offscreen auto --size 640x480 --cache kept --screenshot ";
  for (const std::string array : { "reflectance", "classification" })
  {
    const std::string by = " --colour-by " + array;
    ASSERT_EQ(this->Run(look + "with.png" + by), 0) << this->Err;
    ASSERT_EQ(this->Run(look + "without.png --legend off" + by), 0) << this->Err;
    const double share = ShareThatDiffers(this->Folder / "with.png", this->Folder / "without.png");
    EXPECT_GT(share, 0.01) << array;
    EXPECT_LT(share, 0.2) << array;
    // Words, and the map's upper end or the class "ground", which no lamp shades.
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
    ASSERT_EQ(this->Run(look + "last.png --replay session.jsonl" + by), 0) << this->Err;
    EXPECT_LT(ShareThatDiffers(this->Folder / "step.png", this->Folder / "last.png"), 0.2);
    EXPECT_GT(ShareThatDiffers(this->Folder / "step.png", this->Folder / "last.png"), 0.01)
      << "the session's own picture shows the model alone";
  }
  for (const std::string colors : { "own", "partition" })
  {
    const std::string by = " --colour-by " + colors;
    ASSERT_EQ(this->Run(look + "with.png" + by), 0) << this->Err;
    ASSERT_EQ(this->Run(look + "without.png --legend off" + by), 0) << this->Err;
    EXPECT_EQ(ReadText(this->Folder / "with.png"), ReadText(this->Folder / "without.png"));
  }
  EXPECT_EQ(this->Run("cloud.ply --offscreen auto --size 60x40 --cache kept --screenshot tiny.png "
                      "--colour-by classification"),
    0)
    << this->Err;
}

TEST_F(TestView, ALinkOpensTheViewThatItTells)
{
  const std::string url = this->Server->Url();
  const std::string look = " --offscreen auto --size 200x150 --screenshot ";
  ASSERT_EQ(this->Run(url + " --colour-by partition --detail level" + look + "a.png"), 0);
  ASSERT_EQ(
    this->Run("'" + url + "/#model=torus&colours=partition&detail=level'" + look + "b.png"), 0)
    << this->Err;
  EXPECT_EQ(ReadText(this->Folder / "b.png"), ReadText(this->Folder / "a.png"));
  // What one report tells, shows the same elsewhere.
  this->Write("zoom.jsonl",
    "{\"turning\":\"upright\"}\n{\"select\":\"torus\"}\n{\"select\":\"torus\"}\n"
    "{\"wait\":\"idle\"}\n{\"zoom\":2,\"x\":120,\"y\":70}\n{\"wait\":\"idle\"}\n");
  ASSERT_EQ(this->Run(url + " --replay zoom.jsonl --report r.json" + look + "c.png"), 0);
  const std::string told =
    nlohmann::json::parse(ReadText(this->Folder / "r.json")).at("link").get<std::string>();
  ASSERT_EQ(this->Run("'" + url + "#" + told + "'" + look + "e.png"), 0) << this->Err;
  EXPECT_LT(ShareThatDiffers(this->Folder / "c.png", this->Folder / "e.png"), 0.002) << told;
  EXPECT_GT(ShareThatDiffers(this->Folder / "c.png", this->Folder / "a.png"), 0.1);
  for (const auto& [link, what] : { std::pair{ "#model=other", "no model 'other'" },
         { "#model=torus&view=AAAA", "about its view" }, { "#model=a/b", "about its model" } })
  {
    EXPECT_EQ(this->Run("'" + url + link + "'" + look + "d.png"), 1);
    EXPECT_NE(this->Err.find(what), std::string::npos) << this->Err;
  }
  EXPECT_EQ(this->Run("'" + url + "#model=torus' --replay zoom.jsonl" + look + "d.png"), 2);
  EXPECT_NE(this->Err.find("does not go with --replay"), std::string::npos) << this->Err;
}

// Lines, ends and figures of what was measured: in --screenshot, of a session or of its link.
TEST_F(TestView, APictureHasTheDistancesOfItsLink)
{
  const std::string url = this->Server->Url();
  const std::string look = " --offscreen auto --size 640x480 --screenshot ";
  const std::string lines =
    "{\"turning\":\"upright\"}\n{\"select\":\"torus\"}\n{\"select\":\"torus\"}\n"
    "{\"wait\":\"idle\"}\n";
  this->Write("measure.jsonl",
    lines + "{\"tool\":\"measure\"}\n"
            "{\"t\":1,\"touches\":[{\"id\":1,\"x\":150,\"y\":240}]}\n{\"t\":1.05,\"touches\":[]}\n"
            "{\"t\":2,\"touches\":[{\"id\":1,\"x\":490,\"y\":240}]}\n{\"t\":2.05,\"touches\":[]}\n"
            "{\"wait\":\"idle\"}\n{\"screenshot\":\"step.png\"}\n");
  ASSERT_EQ(this->Run(url + " --replay measure.jsonl --report r.json" + look + "last.png"), 0)
    << this->Err;
  const std::string link =
    nlohmann::json::parse(ReadText(this->Folder / "r.json")).at("link").get<std::string>();
  const std::size_t begin = link.find("&distances=");
  ASSERT_NE(begin, std::string::npos) << link;
  ASSERT_EQ(this->Run("'" + url + "#" + link + "'" + look + "link.png"), 0) << this->Err;
  EXPECT_LT(ShareThatDiffers(this->Folder / "last.png", this->Folder / "link.png"), 0.002) << link;
  // The same view without them.
  std::string bare = link;
  bare.erase(begin, link.find('&', begin + 1) - begin);
  ASSERT_EQ(this->Run("'" + url + "#" + bare + "'" + look + "bare.png"), 0) << this->Err;
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

TEST_F(TestView, AMeshThatCannotBeBuiltIsNamedAndLeavesNothing)
{
  this->Write("bad.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n");
  const std::string look = "--offscreen auto --size 64x64 --screenshot p.png --cache ";
  EXPECT_EQ(this->Run("bad.ply " + look + "kept"), 1);
  EXPECT_EQ(this->Err.rfind("kdstream-view: error: ", 0), 0u) << this->Err;
  EXPECT_NE(this->Err.find("bad.ply: "), std::string::npos) << this->Err;
  EXPECT_TRUE(std::filesystem::is_empty(this->Folder / "kept" / "stores"));
}

TEST_F(TestView, TellsItsOptionsAndVersion)
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

int main(int argc, char** argv)
{
  ::testing::InitGoogleTest(&argc, argv);
  program = argc > 1 ? argv[1] : "kdstream-view";
  ::unsetenv("XDG_CACHE_HOME"); // nothing is kept but where a test says
  ::unsetenv("HOME");
  ::unsetenv("DISPLAY"); // a window would wait for somebody
  return RUN_ALL_TESTS();
}
