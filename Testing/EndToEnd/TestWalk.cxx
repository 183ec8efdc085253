// SPDX-License-Identifier: BSD-3-Clause
// A walk through all programs with the real scan: kdstream-build, kdstream-serve, kdstream-view and
// the demo session, with EGL and with OSMesa.
#include "Testing/EndToEnd/Process.h"
#include "Testing/Fixtures/RunningProgram.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <map>
#include <set>

using namespace kdstream::fixtures;
using Json = nlohmann::json;

TEST(Walk, FromAScanToThreePictures)
{
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "models");
  const Outcome built = RunTool(folder, "build",
    { KDSTREAM_DRAGON, "-o", "models/dragon.kds", "--title", "Stanford dragon", "--stats",
      "build.json" });
  ASSERT_EQ(built.exitCode, 0) << built.err << "\n(Data/fetch-dragon fetches the dragon)";
  const Json build = Json::parse(ReadWhole(folder / "build.json"));
  std::string session = ReadWhole(KDSTREAM_DEMO_SESSION);
  for (std::size_t at = session.find("MODEL"); at != std::string::npos; at = session.find("MODEL"))
  {
    session.replace(at, 5, "dragon");
  }
  std::ofstream(folder / "session.jsonl") << session;

  FolderServer server(KDSTREAM_PROGRAMS, folder / "models");
  std::map<std::string, std::map<std::string, std::string>> pictures; // by backend, then by name
  for (const std::string backend : { "egl", "osmesa" })
  {
    SCOPED_TRACE(backend);
    const Outcome viewed = RunTool(folder, "view",
      { server.Url, "--model", "dragon", "--offscreen", backend, "--size", "1080x1440", "--replay",
        "session.jsonl", "--stats", "view.json" });
    ASSERT_EQ(viewed.exitCode, 0) << viewed.err;
    EXPECT_EQ(viewed.out + viewed.err, "");
    for (const std::string name : { "preview.png", "level.png", "region.png" })
    {
      pictures[backend][name] = ReadWhole(folder / name);
      EXPECT_TRUE(pictures[backend][name].starts_with("\x89PNG")) << name;
      std::filesystem::remove(folder / name);
    }

    std::set<std::string> ids;
    std::map<std::string, unsigned> kinds;
    for (const Json& entry : Json::parse(ReadWhole(folder / "view.json")))
    {
      EXPECT_TRUE(ids.insert(entry["id"]).second) << entry["id"] << " was fetched twice";
      ++kinds[entry["what"]];
      for (const char* key : { "vertices", "triangles", "bytes", "transmission_s", "parsing_s",
             "rendering_s", "from_cache" })
      {
        EXPECT_TRUE(entry.contains(key)) << key;
      }
    }
    EXPECT_EQ(kinds["preview"], 1U);
    EXPECT_TRUE(ids.contains("levels/11/1"));
    EXPECT_GT(kinds["level"], 8U);
    EXPECT_GT(kinds["partition"], 8U);
    EXPECT_LT(kinds["partition"], build["partitions"].get<unsigned>() / 2)
      << "a region, not the whole";
  }
  EXPECT_TRUE(pictures["egl"] == pictures["osmesa"]) << "the backends draw different pictures";
  const auto& drawn = pictures["egl"];
  EXPECT_TRUE(drawn.at("preview.png") != drawn.at("level.png"));
  EXPECT_TRUE(drawn.at("level.png") != drawn.at("region.png"));
  EXPECT_EQ(server.Stop(), 0);
}

TEST(Walk, ADamagedPartitionCostsNothingElse)
{
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "models");
  ASSERT_EQ(RunTool(folder, "build", { KDSTREAM_DRAGON, "-o", "models/dragon.kds" }).exitCode, 0);
  std::string store = ReadWhole(folder / "models/dragon.kds");
  const std::size_t blob = store.find("KDP\x08", store.size() * 9 / 10);
  ASSERT_NE(blob, std::string::npos);
  store[blob + 1000] ^= 1;
  std::ofstream(folder / "models/dragon.kds", std::ios::binary) << store;
  const Outcome verified = RunTool(folder, "store", { "verify", "models/dragon.kds" });
  EXPECT_EQ(verified.exitCode, 1);
  EXPECT_NE(verified.err.find("partitions/"), std::string::npos) << verified.err;
  FolderServer server(KDSTREAM_PROGRAMS, folder / "models");
  const Outcome viewed = RunTool(folder, "view",
    { server.Url, "--offscreen", "egl", "--size", "300x300", "--screenshot", "level.png" });
  EXPECT_EQ(viewed.exitCode, 0) << viewed.err;
  EXPECT_TRUE(std::filesystem::exists(folder / "level.png"));
}
