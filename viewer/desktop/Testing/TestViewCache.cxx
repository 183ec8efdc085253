// SPDX-License-Identifier: BSD-3-Clause
// What kdstream-view keeps for later runs: stores built from meshes, and data from servers.
#include "viewer/desktop/Testing/ViewTest.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

using namespace kdstream;
using kdstream::fixtures::ReadWhole;
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
  const std::string view = "--offscreen auto --size 64x64 --screenshot p.png --cache kept";
  ASSERT_EQ(this->Run("'My solid.ply' " + view), 0) << this->Err;
  EXPECT_TRUE(this->IsPicture("p.png"));
  const std::string picture = ReadWhole(this->Folder / "p.png");
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
  ASSERT_EQ(this->Run("'My solid.ply' " + view), 0) << this->Err;
  EXPECT_EQ(std::filesystem::last_write_time(store), built) << "it was there";
  EXPECT_EQ(ReadWhole(this->Folder / "p.png"), picture);
  // The store itself can be opened, and the folder that it is in.
  for (const auto& path : { store, store.parent_path() })
  {
    ASSERT_EQ(this->Run("'" + path.string() + "' " + view), 0) << this->Err;
    EXPECT_EQ(ReadWhole(this->Folder / "p.png"), picture);
  }
  // If the cache is full, another mesh replaces this one; the store that is shown stays.
  this->Write("other.ply", TetrahedronPly() + "\n");
  ASSERT_EQ(this->Run("other.ply " + view + " --cache-size 1"), 0) << this->Err;
  list();
  ASSERT_EQ(stores.size(), 1u);
  EXPECT_EQ(stores[0].filename(), "other.kds");
}

TEST_F(TestViewCache, WhatWasSeenIsThereWithoutTheServer)
{
  const std::string view = "--offscreen auto --size 200x150 --stats s.json --screenshot ";
  const auto fromCache = [this]
  {
    std::size_t count = 0;
    for (const auto& blob : nlohmann::json::parse(ReadWhole(this->Folder / "s.json")))
    {
      count += blob.at("from_cache").get<bool>() ? 1 : 0;
    }
    return count;
  };
  ASSERT_EQ(this->View(view + "a.png --cache kept"), 0) << this->Err;
  EXPECT_EQ(fromCache(), 0u);
  EXPECT_FALSE(this->Models.model->TakeRead().empty());
  ASSERT_EQ(this->View(view + "b.png --cache kept"), 0) << this->Err;
  EXPECT_GT(fromCache(), 0u);
  EXPECT_TRUE(this->Models.model->TakeRead().empty());
  ASSERT_EQ(this->View(view + "b.png"), 0) << this->Err;
  EXPECT_EQ(fromCache(), 0u) << "no cache where none is named";
  const std::string url = this->Server->Url();
  this->Server.reset();
  ASSERT_EQ(this->Run(url + " " + view + "c.png --cache kept"), 0) << this->Err;
  EXPECT_EQ(this->Err.rfind("kdstream-view: warning: " + url + ": ", 0), 0u) << this->Err;
  EXPECT_NE(this->Err.find("; only cached data is shown\n"), std::string::npos) << this->Err;
  EXPECT_EQ(ReadWhole(this->Folder / "c.png"), ReadWhole(this->Folder / "a.png"));
  // If many parts are missing, only some are named; then the number of the others is given.
  ASSERT_EQ(this->Run(url + " " + view + "e.png --detail full --cache kept"), 1);
  std::size_t lines = 0;
  for (auto at = this->Err.find(": error: "); at != std::string::npos; ++lines)
  {
    at = this->Err.find(": error: ", at + 1);
  }
  EXPECT_EQ(lines, 2u) << this->Err;
  EXPECT_NE(this->Err.find(" more errors of this kind\n"), std::string::npos) << this->Err;
  // If the cache folder cannot be made, the model is shown anyway, because the server has it.
  EXPECT_EQ(this->Run(url + " " + view + "d.png --cache s.json"), 1);
  EXPECT_NE(this->Err.find("warning: s.json: "), std::string::npos) << this->Err;
}

TEST_F(TestViewCache, AMeshIsSeenWhereNothingCanBeKept)
{
  this->Write("nest.ply", TetrahedronPly());
  std::filesystem::create_directory(this->Folder / "brief");
  const std::string view = "nest.ply --offscreen auto --size 64x64 --screenshot n.png --cache ";
  ASSERT_EQ(this->Run(view + "kept"), 0) << this->Err;
  const std::string seen = ReadWhole(this->Folder / "n.png");
  ::setenv("TMPDIR", (this->Folder / "brief").c_str(), 1);
  EXPECT_EQ(this->Run(view + "nest.ply/below"), 0) << this->Err;
  ::unsetenv("TMPDIR");
  EXPECT_NE(this->Err.find("kdstream-view: warning: nest.ply/below: cannot be created: "),
    std::string::npos)
    << this->Err;
  EXPECT_NE(this->Err.find("the store made from the mesh is not cached\n"), std::string::npos);
  EXPECT_EQ(ReadWhole(this->Folder / "n.png"), seen);
  EXPECT_TRUE(std::filesystem::is_empty(this->Folder / "brief"));
}

// The cache is a folder that others can write to. In each case the mesh is shown, and the obstacle
// is reported and left as it is.
TEST_F(TestViewCache, FilesThatOthersPlantedAreNotTouched)
{
  namespace fs = std::filesystem;
  this->Write("mesh.ply", TetrahedronPly());
  this->Write("theirs.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                            "property float y\nproperty float z\nelement face 1\n"
                            "property list uchar int vertex_indices\nend_header\n"
                            "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  const std::string view = "mesh.ply --offscreen auto --size 64x64 --screenshot p.png --cache ";
  ASSERT_EQ(this->Run(view + "honest"), 0) << this->Err;
  const std::string seen = ReadWhole(this->Folder / "p.png");
  const fs::path key = fs::directory_iterator(this->Folder / "honest/stores")->path().filename();
  ASSERT_EQ(this->Run("theirs.ply --offscreen auto --size 64x64 --screenshot p.png --cache t"), 0);
  ASSERT_NE(ReadWhole(this->Folder / "p.png"), seen);
  fs::path theirs;
  for (const auto& entry : fs::recursive_directory_iterator(this->Folder / "t"))
  {
    theirs = entry.is_regular_file() ? entry.path() : theirs;
  }
  const fs::path stores = this->Folder / "cache/stores", of = stores / key, store = of / "mesh.kds";
  const auto isReported = [&](const std::string& name, const std::string& what)
  {
    fs::remove(this->Folder / "p.png");
    ASSERT_EQ(this->Run(view + "cache"), 0) << what << ": " << this->Err;
    EXPECT_EQ(ReadWhole(this->Folder / "p.png"), seen) << what;
    EXPECT_NE(
      this->Err.find("kdstream-view: warning: cache/stores" + name + ": "), std::string::npos)
      << what << ": " << this->Err;
    EXPECT_NE(this->Err.find("; the store made from the mesh is not cached\n"), std::string::npos)
      << what << ": " << this->Err;
  };
  const auto begin = [&]
  {
    fs::remove_all(this->Folder / "cache");
    fs::create_directories(of);
    fs::permissions(this->Folder / "cache", fs::perms::all);
  };
  const std::string ofKey = "/" + key.string(), ofStore = ofKey + "/mesh.kds";

  begin();
  fs::create_symlink(this->Folder / "victim", store);
  isReported(ofStore, "a dangling link");
  EXPECT_FALSE(fs::exists(this->Folder / "victim"));
  fs::copy_file(theirs, this->Folder / "victim");
  isReported(ofStore, "a link to a store");
  EXPECT_TRUE(fs::is_symlink(store));

  begin();
  ASSERT_EQ(::mkfifo(store.c_str(), 0600), 0);
  isReported(ofStore, "a pipe");
  EXPECT_TRUE(fs::is_fifo(store));

  begin();
  fs::create_directory(store);
  isReported(ofStore, "a folder");

  begin();
  fs::create_directory(this->Folder / "away");
  fs::remove_all(stores);
  fs::create_directory_symlink("../away", stores);
  isReported("", "a link for the stores");
  EXPECT_TRUE(fs::is_empty(this->Folder / "away"));

  begin();
  fs::remove_all(of);
  fs::create_directory_symlink("../../away", of);
  isReported(ofKey, "a link for the mesh");
  EXPECT_TRUE(fs::is_empty(this->Folder / "away"));

  begin();
  fs::remove_all(stores);
  std::ofstream(stores) << "x";
  isReported("", "a file for the stores");

  if (::geteuid() != 0)
  {
    GTEST_SKIP() << "only root can give files away";
  }
  constexpr uid_t another = 1000;
  begin();
  fs::copy_file(theirs, store);
  ASSERT_EQ(::chown(store.c_str(), another, another), 0);
  isReported(ofStore, "another user's store");
  EXPECT_EQ(ReadWhole(store), ReadWhole(theirs));
  for (const fs::path& folder : { of, stores })
  {
    begin();
    fs::copy_file(theirs, store);
    ASSERT_EQ(::chown(folder.c_str(), another, another), 0);
    isReported(folder == of ? ofKey : "", "another user's folder");
    EXPECT_EQ(ReadWhole(store), ReadWhole(theirs));
  }
}

// A damaged store does no harm, because the cache can be built again.
TEST_F(TestViewCache, ADamagedStoreIsMadeAnew)
{
  this->Write("mesh.ply", TetrahedronPly());
  const std::string view =
    "mesh.ply --offscreen auto --size 64x64 --screenshot p.png --cache cache";
  ASSERT_EQ(this->Run(view), 0) << this->Err;
  const std::string seen = ReadWhole(this->Folder / "p.png");
  const auto key =
    std::filesystem::directory_iterator(this->Folder / "cache/stores")->path().filename().string();
  this->Write("cache/stores/" + key + "/mesh.kds", std::string(5000, 'x'));
  ASSERT_EQ(this->Run(view), 0) << this->Err;
  EXPECT_EQ(this->Err.rfind("kdstream-view: warning: cache/stores/" + key + "/mesh.kds: ", 0), 0u)
    << this->Err;
  EXPECT_NE(this->Err.find("; the store is made from the mesh again\n"), std::string::npos)
    << this->Err;
  EXPECT_EQ(ReadWhole(this->Folder / "p.png"), seen);
  ASSERT_EQ(this->Run(view), 0);
  EXPECT_EQ(this->Err, "");
}

TEST_F(TestViewCache, AMeshThatCannotBeBuiltIsNamedAndLeavesNothing)
{
  this->Write("bad.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n");
  const std::string view = "--offscreen auto --size 64x64 --screenshot p.png --cache ";
  EXPECT_EQ(this->Run("bad.ply " + view + "kept"), 1);
  EXPECT_EQ(this->Err.rfind("kdstream-view: error: ", 0), 0u) << this->Err;
  EXPECT_NE(this->Err.find("bad.ply: "), std::string::npos) << this->Err;
  EXPECT_TRUE(std::filesystem::is_empty(this->Folder / "kept" / "stores"));
}

}
