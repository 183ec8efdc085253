// SPDX-License-Identifier: BSD-3-Clause
// Files of stores that kdstream-build and kdstream-store write: folders, names and permissions, and
// changed texts.
#include "Testing/EndToEnd/Process.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/meshio/MeshWriter.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <csignal>
#include <set>

#include <sys/stat.h>

using namespace kdstream;
using namespace kdstream::fixtures;
using Json = nlohmann::json;
namespace fs = std::filesystem;

namespace
{

class StoreFiles : public ::testing::Test
{
protected:
  StoreFiles()
  {
    const Status status = WriteMesh(this->Folder / "in.ply", Torus(40, 20));
    EXPECT_TRUE(status) << status.GetError().message;
  }

  Outcome Build(std::vector<std::string> arguments)
  {
    arguments.insert(arguments.begin(), { "in.ply", "--quiet" });
    return RunTool(this->Folder, "build", arguments);
  }
  Outcome Store(const std::vector<std::string>& arguments)
  {
    return RunTool(this->Folder, "store", arguments);
  }
  Json Info(const std::string& store)
  {
    const Outcome outcome = this->Store({ "info", store, "--json" });
    EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
    return Json::parse(outcome.out, nullptr, false);
  }

  // All files and folders, at any depth.
  std::set<std::string> Files() const
  {
    std::set<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(this->Folder.Path))
    {
      names.insert(entry.path().lexically_relative(this->Folder.Path).string());
    }
    return names;
  }

  TemporaryFolder Folder;
};

using Names = std::set<std::string>;

}

TEST_F(StoreFiles, FoldersAreMadeAndGoAgainWhereABuildFails)
{
  EXPECT_EQ(this->Build({ "-o", "no.stl/models/a.kds", "--partitions", "3" }).exitCode, 2);
  EXPECT_EQ(this->Files(), Names{ "in.ply" });
  const Outcome noStats = this->Build({ "-o", "models/a.kds", "--stats", "no/s.json" });
  EXPECT_EQ(noStats.exitCode, 1);
  EXPECT_EQ(noStats.err.rfind("kdstream-build: error: no/s.json: ", 0), 0U) << noStats.err;
  EXPECT_EQ(this->Files(), Names{ "in.ply" });
  fs::create_directory(this->Folder / "there");
  EXPECT_EQ(this->Build({ "-o", "there/models/a.kds", "--partitions", "3" }).exitCode, 2);
  EXPECT_EQ(this->Files(), (Names{ "in.ply", "there" })) << "it was there before";

  const Outcome built = this->Build({ "-o", "there/models/2026/statue.kds" });
  EXPECT_EQ(built.exitCode, 0) << built.err;
  EXPECT_EQ(this->Files(), (Names{ "in.ply", "there", "there/models", "there/models/2026",
                             "there/models/2026/statue.kds" }));
  EXPECT_EQ(this->Store({ "verify", "there/models/2026/statue.kds" }).exitCode, 0);
  const Outcome inFile = this->Build({ "-o", "in.ply/a.kds" });
  EXPECT_EQ(inFile.exitCode, 1);
  EXPECT_EQ(inFile.err,
    "kdstream-build: error: in.ply/a.kds: cannot be created in in.ply, which is a "
    "file, not a folder\n");
  const Outcome belowFile = this->Build({ "-o", "in.ply/models/a.kds" });
  EXPECT_EQ(belowFile.exitCode, 1);
  EXPECT_EQ(belowFile.err,
    "kdstream-build: error: in.ply/models/a.kds: cannot be created in in.ply, "
    "which is a file, not a folder\n");
  const Outcome statsInFile = this->Build({ "-o", "b.kds", "--stats", "in.ply/s.json" });
  EXPECT_EQ(statsInFile.err,
    "kdstream-build: error: in.ply/s.json: cannot be created in in.ply, which "
    "is a file, not a folder\n");
}

TEST_F(StoreFiles, ExtractMakesFoldersToo)
{
  ASSERT_EQ(this->Build({ "-o", "m.kds" }).exitCode, 0);
  EXPECT_EQ(
    this->Store({ "extract", "m.kds", "--level", "99", "-o", "new/deep/x.ply" }).exitCode, 2);
  EXPECT_EQ(this->Store({ "extract", "m.kds", "--all", "-o", "new/deep/x.doc" }).exitCode, 2);
  EXPECT_EQ(this->Files(), (Names{ "in.ply", "m.kds" }));
  const Outcome extracted = this->Store({ "extract", "m.kds", "--all", "-o", "new/deep/x.ply" });
  EXPECT_EQ(extracted.exitCode, 0) << extracted.err;
  EXPECT_EQ(this->Files(), (Names{ "in.ply", "m.kds", "new", "new/deep", "new/deep/x.ply" }));
  const std::string start = "kdstream-store: wrote new/deep/x.ply: 1600 triangles, ";
  EXPECT_EQ(extracted.err.rfind(start, 0), 0U) << extracted.err;
  EXPECT_EQ(extracted.err.find('\n'), extracted.err.size() - 1) << extracted.err;
  EXPECT_EQ(extracted.out, "");
  EXPECT_EQ(this->Store({ "extract", "m.kds", "--all", "-o", "x.ply", "--quiet" }).err, "");
}

TEST_F(StoreFiles, StatisticsNeverReplaceAnotherStore)
{
  ASSERT_EQ(this->Build({ "-o", "old.kds" }).exitCode, 0);
  const std::string before = ReadWhole(this->Folder / "old.kds");
  fs::create_symlink("old.kds", this->Folder / "link.json");
  for (const std::string stats : { "old.kds", "link.json" })
  {
    const Outcome refused = this->Build({ "-o", "new.kds", "--stats", stats });
    EXPECT_EQ(refused.exitCode, 2);
    EXPECT_EQ(refused.err,
      "kdstream-build: error: " + stats + ": is a store, which would be overwritten\n");
  }
  EXPECT_TRUE(ReadWhole(this->Folder / "old.kds") == before);
  EXPECT_EQ(this->Files(), (Names{ "in.ply", "link.json", "old.kds" }));
  std::ofstream(this->Folder / "s.json") << "statistics of before";
  EXPECT_EQ(this->Build({ "-o", "new.kds", "--stats", "s.json" }).exitCode, 0);
}

TEST_F(StoreFiles, NamesThatNoServerServesAreRefused)
{
  for (const std::string& stem :
    { std::string(), std::string("my statue"), std::string("b\xC3\xBCste"), std::string("a+b"),
      std::string(129, 'x'), std::string(".."), std::string(".hidden") })
  {
    const Outcome refused = this->Build({ "-o", "models/" + stem + ".kds" });
    EXPECT_EQ(refused.exitCode, 2) << stem;
    EXPECT_EQ(refused.err,
      "kdstream-build: error: models/" + stem +
        ".kds: a server cannot serve a store of this name: before .kds it "
        "must have 1 to 128 characters of A-Z a-z 0-9 . _ -, and no dot at the start\n");
    EXPECT_EQ(this->Files(), Names{ "in.ply" });
  }
  for (const std::string& stem : { std::string("A.b-c_9"), std::string(128, 'x') })
  {
    EXPECT_EQ(this->Build({ "-o", stem + ".kds" }).exitCode, 0) << stem;
  }
}

TEST_F(StoreFiles, AStoreIsAsPrivateAsTheUmaskAndThenAsItWas)
{
  const auto permissions = [&]
  {
    struct stat state = {};
    ::stat((this->Folder / "m.kds").c_str(), &state);
    return state.st_mode & 0777;
  };
  const mode_t before = ::umask(077); // children inherit it
  EXPECT_EQ(this->Build({ "-o", "m.kds" }).exitCode, 0);
  EXPECT_EQ(permissions(), 0600U);
  ::umask(022);
  EXPECT_EQ(this->Build({ "-o", "m.kds", "--weld", "off" }).exitCode, 0);
  EXPECT_EQ(permissions(), 0600U);
  EXPECT_EQ(this->Store({ "edit", "m.kds", "--title", "t" }).exitCode, 0);
  EXPECT_EQ(permissions(), 0600U);
  fs::remove(this->Folder / "m.kds");
  EXPECT_EQ(this->Build({ "-o", "m.kds" }).exitCode, 0);
  EXPECT_EQ(permissions(), 0644U);
  ::umask(before);
}

TEST_F(StoreFiles, TextsAreChangedWithoutABuild)
{
  ASSERT_EQ(
    this->Build({ "-o", "m.kds", "--title", "Statu", "--credit", "C", "--licence", "L" }).exitCode,
    0);
  const Json before = this->Info("m.kds");
  EXPECT_EQ(before["license"], "L");
  const Outcome edited = this->Store({ "edit", "m.kds", "--title", "Statue", "--description",
    "A man on a horse", "--credit", "", "--unit", "mm" });
  EXPECT_EQ(edited.exitCode, 0) << edited.err;
  EXPECT_EQ(edited.out, "");
  EXPECT_EQ(edited.err.rfind(
              "kdstream-store: wrote m.kds: another title, description, credit and unit, ", 0),
    0U)
    << edited.err;
  EXPECT_EQ(this->Store({ "edit", "m.kds", "--title", "Statue", "--quiet" }).err, "");
  Json expected = before, after = this->Info("m.kds");
  expected["title"] = "Statue";
  expected["description"] = "A man on a horse";
  expected["credit"] = "";
  expected["unit"] = "mm";
  for (Json* info : { &expected, &after })
  {
    info->erase("store_bytes");
  }
  EXPECT_EQ(after, expected);
  EXPECT_EQ(this->Store({ "verify", "m.kds" }).exitCode, 0);
  for (const char* option : { "--license", "--licence" })
  {
    EXPECT_EQ(this->Store({ "edit", "m.kds", option, std::string("by ") + option }).exitCode, 0);
    EXPECT_EQ(this->Info("m.kds")["license"], std::string("by ") + option);
  }
  EXPECT_EQ(this->Store({ "edit", "m.kds", "--description", "" }).exitCode, 0);
  EXPECT_FALSE(this->Info("m.kds").contains("description"));
  // A link remains a link.
  fs::create_symlink("m.kds", this->Folder / "link.kds");
  EXPECT_EQ(this->Store({ "edit", "link.kds", "--title", "by a link" }).exitCode, 0);
  EXPECT_TRUE(fs::is_symlink(this->Folder / "link.kds"));
  EXPECT_EQ(this->Info("m.kds")["title"], "by a link");
  EXPECT_EQ(this->Files(), (Names{ "in.ply", "link.kds", "m.kds" }));
}

TEST_F(StoreFiles, UpAndFirstViewAreReportedGivenAndChanged)
{
  const auto infoText = [&] { return this->Store({ "info", "m.kds" }).out; };
  const auto build = [&](std::vector<std::string> arguments)
  {
    arguments.insert(arguments.begin(), { "in.ply", "-o", "m.kds" });
    return RunTool(this->Folder, "build", arguments);
  };
  const Outcome built = build({});
  ASSERT_EQ(built.exitCode, 0) << built.err;
  EXPECT_NE(built.err.find("m.kds: guessed that up is +z and front is "), std::string::npos)
    << built.err;
  EXPECT_NE(infoText().find("up                   +z (guessed)\n"), std::string::npos);
  EXPECT_EQ(this->Info("m.kds")["pose"]["guessed"], true);
  const Outcome given = build({ "--up", "0,2,0", "--view=-1,0,0" });
  ASSERT_EQ(given.exitCode, 0) << given.err;
  EXPECT_EQ(given.err.find("guessed"), std::string::npos) << given.err;
  EXPECT_EQ(this->Info("m.kds")["pose"],
    (Json{ { "up", { 0.0, 1.0, 0.0 } }, { "view", { -1.0, 0.0, 0.0 } }, { "guessed", false } }));
  EXPECT_NE(infoText().find("first view from      -x\n"), std::string::npos) << infoText();
  const Outcome edited = this->Store({ "edit", "m.kds", "--view", "0,3,4" });
  ASSERT_EQ(edited.exitCode, 0) << edited.err;
  EXPECT_NE(edited.err.find("m.kds: another view, "), std::string::npos) << edited.err;
  EXPECT_NE(infoText().find("first view from      0,0.6,0.8\n"), std::string::npos) << infoText();
  for (const char* wrong : { "0,0,0", "1,2", "1,2,3,4", "a,b,c", "1;2;3", "1,2,inf", "", "0,0,1 " })
  {
    EXPECT_EQ(this->Build({ "-o", "n.kds", "--up", wrong }).exitCode, 2) << wrong;
    const Outcome refused = this->Store({ "edit", "m.kds", "--view", wrong });
    EXPECT_EQ(refused.exitCode, 2) << wrong;
    EXPECT_EQ(refused.err.rfind("kdstream-store: error: ", 0), 0U) << refused.err;
  }
}

TEST_F(StoreFiles, EditRefusesWhatItCannotDo)
{
  ASSERT_EQ(this->Build({ "-o", "m.kds" }).exitCode, 0);
  const std::string whole = ReadWhole(this->Folder / "m.kds");
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
         { "edit", "m.kds" }, { "edit" }, { "edit", "m.kds", "--title", "a\x1B[31mb" },
         { "edit", "m.kds", "--unit", "\xFF" }, { "edit", "m.kds", "--credit" } })
  {
    const Outcome outcome = this->Store(arguments);
    EXPECT_EQ(outcome.exitCode, 2) << outcome.err;
    EXPECT_EQ(outcome.err.rfind("kdstream-store: error: ", 0), 0U) << outcome.err;
  }
  const Outcome missing = this->Store({ "edit", "no.kds", "--title", "x" });
  EXPECT_EQ(missing.exitCode, 1);
  EXPECT_EQ(missing.err, "kdstream-store: error: no.kds: no such file\n");
  EXPECT_EQ(this->Store({ "edit", "in.ply", "--title", "x" }).exitCode, 1);
  EXPECT_TRUE(ReadWhole(this->Folder / "m.kds") == whole);

  rlimit limits{};
  ::getrlimit(RLIMIT_FSIZE, &limits);
  rlimit small = limits;
  small.rlim_cur = whole.size() / 2; // children inherit it
  ::setrlimit(RLIMIT_FSIZE, &small);
  const Outcome full = this->Store({ "edit", "m.kds", "--title", "x" });
  ::setrlimit(RLIMIT_FSIZE, &limits);
  EXPECT_EQ(full.exitCode, 1);
  EXPECT_NE(full.err.find("needs " + std::to_string(whole.size()) + " bytes"), full.err.npos)
    << full.err;
  EXPECT_TRUE(ReadWhole(this->Folder / "m.kds") == whole);
  EXPECT_EQ(this->Files(), (Names{ "in.ply", "m.kds" }));
}
