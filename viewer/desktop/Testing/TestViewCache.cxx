// SPDX-License-Identifier: BSD-3-Clause
// What kdstream-view keeps for the next time: stores that it builds of meshes, and what servers
// sent.
#include "viewer/desktop/Testing/ViewTest.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

using namespace kdstream;
using kdstream::testing::ReadText;
using kdstream::testing::ViewTest;

namespace
{

class TestViewCache : public ViewTest
{
};

std::string TetrahedronPly()
{
  return "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
         "property float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n"
         "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
}

TEST_F(TestViewCache, AMeshIsBuiltOnceAndKeptInTheCache)
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

TEST_F(TestViewCache, WhatWasSeenIsThereWithoutTheServer)
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

TEST_F(TestViewCache, AMeshIsSeenWhereNothingCanBeKept)
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
    this->Err.find("kdstream-view: warning: nest.ply/below: cannot be created: "), std::string::npos)
    << this->Err;
  EXPECT_NE(this->Err.find("the store that is made of the mesh is not kept\n"), std::string::npos);
  EXPECT_EQ(ReadText(this->Folder / "n.png"), seen);
  EXPECT_TRUE(std::filesystem::is_empty(this->Folder / "brief"));
}

TEST_F(TestViewCache, AMeshThatCannotBeBuiltIsNamedAndLeavesNothing)
{
  this->Write("bad.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n");
  const std::string look = "--offscreen auto --size 64x64 --screenshot p.png --cache ";
  EXPECT_EQ(this->Run("bad.ply " + look + "kept"), 1);
  EXPECT_EQ(this->Err.rfind("kdstream-view: error: ", 0), 0u) << this->Err;
  EXPECT_NE(this->Err.find("bad.ply: "), std::string::npos) << this->Err;
  EXPECT_TRUE(std::filesystem::is_empty(this->Folder / "kept" / "stores"));
}

}
