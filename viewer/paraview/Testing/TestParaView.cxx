// SPDX-License-Identifier: BSD-3-Clause
// Tests the plugin in ParaView itself: pvbatch reads the dragon from a store and from a server, on
// one process and on several. plugin.py asks the questions, and this file has the expected answers.
#include "Testing/Fixtures/RunningProgram.h"
#include "filters/Parallel/Testing/RunRanks.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

using namespace kdstream::fixtures;
using Json = nlohmann::json;

namespace
{

// The answers to the questions: by question, then by rank.
using Answers = std::map<std::string, std::map<int, Json>>;

struct Session
{
  Answers answers;
  std::string errors;
};

std::uint64_t Sum(const std::map<int, Json>& ofRanks, const char* key)
{
  std::uint64_t sum = 0;
  for (const auto& [rank, answer] : ofRanks)
  {
    sum += answer.at(key).get<std::uint64_t>();
  }
  return sum;
}

class TestParaView : public ::testing::Test
{
protected:
  static void SetUpTestSuite()
  {
    Folder = std::make_unique<TemporaryFolder>();
    std::filesystem::create_directory(*Folder / "models");
    const Outcome built = RunTool(*Folder, "build", { KDSTREAM_DRAGON, "-o", "models/dragon.kds" });
    ASSERT_EQ(built.exitCode, 0) << built.err << "\n(Data/fetch-dragon fetches the dragon)";
    Store = (*Folder / "models/dragon.kds").string();
    Info = Json::parse(RunTool(*Folder, "store", { "info", Store, "--json" }).out);
    ::setenv("LIBGL_ALWAYS_SOFTWARE", "1", 1);
    ::setenv("HOME", Folder->Path.c_str(), 1); // ParaView keeps settings there
  }
  static void TearDownTestSuite() { Folder.reset(); }

  // Runs plugin.py in pvbatch on this number of processes.
  static Session Ask(unsigned ranks, std::vector<std::string> arguments)
  {
    // -noreset: ParaView opens a first connection and closes it again. Without -noreset, Xvfb would
    // then restart, and might miss the second connection.
    std::vector<std::string> command{ "-a", "-s", "-screen 0 1280x1024x24 +extension GLX -noreset",
      KDSTREAM_MPIRUN };
    std::vector<std::string> batch{ KDSTREAM_PVBATCH, "--sym", KDSTREAM_SCRIPT, KDSTREAM_PLUGIN };
    batch.insert(batch.end(), arguments.begin(), arguments.end());
    const std::vector<std::string> job = Ranks(ranks, batch);
    command.insert(command.end(), job.begin(), job.end());
    const Outcome outcome = RunProgram(*Folder, KDSTREAM_XVFB_RUN, command);
    EXPECT_EQ(outcome.exitCode, 0) << outcome.out << outcome.err;
    EXPECT_EQ(outcome.err.find("ERR|") != std::string::npos,
      arguments[0] == "broken" || arguments[0] == "failing")
      << outcome.err;
    Session session{ {}, outcome.err };
    for (unsigned rank = 0; rank < ranks; ++rank)
    {
      const std::filesystem::path file = *Folder / ("answers." + std::to_string(rank));
      std::ifstream lines(file);
      for (std::string line; std::getline(lines, line);)
      {
        const Json answer = Json::parse(line);
        session.answers[answer.at("what")][static_cast<int>(rank)] = answer;
      }
      std::filesystem::remove(file);
    }
    return session;
  }

  static void ExpectOriginal(const std::map<int, Json>& ofRanks, unsigned notWelded = 0)
  {
    EXPECT_EQ(Sum(ofRanks, "vertices"), Info["vertices"].get<std::uint64_t>() + notWelded);
    EXPECT_EQ(Sum(ofRanks, "triangles"), Info["triangles"].get<std::uint64_t>());
  }

  // Checks the original and a level, as one mesh and as partitions: each rank has its share, and
  // together they are complete.
  static void ExpectContents(const Answers& answers, unsigned ranks)
  {
    const Json level = *std::find_if(Info["levels"].begin(), Info["levels"].end(),
      [](const Json& each) { return each["depth"] == 14; });
    for (const std::string type : { "Partitions", "One Mesh" })
    {
      SCOPED_TRACE(type + " on " + std::to_string(ranks));
      ExpectOriginal(answers.at("original, " + type));
      EXPECT_EQ(Sum(answers.at("level 14, " + type), "vertices"), level["vertices"]);
      EXPECT_EQ(Sum(answers.at("level 14, " + type), "triangles"), level["triangles"]);
      for (const char* const what : { "original, ", "level 14, " })
      {
        const auto& ofRanks = answers.at(what + type);
        ASSERT_EQ(ofRanks.size(), ranks);
        for (const auto& [rank, answer] : ofRanks)
        {
          EXPECT_GT(answer["vertices"].get<double>(), 0.8 * level["vertices"].get<double>() / ranks)
            << what << rank;
        }
      }
    }
    for (const auto& [rank, answer] : answers.at("original, Partitions"))
    {
      EXPECT_EQ(answer["partitions"], Info["partitions"].get<unsigned>() / ranks);
    }
  }

  // 2 and 4 processes must cut a file in the same way as one process cuts the whole mesh: the
  // digests of the partitions are compared.
  static void ExpectTogether(const std::string& whole, const std::string& file, unsigned fewest)
  {
    const auto one = Ask(1, { "distributed", whole }).answers.at("distributed").at(0);
    ASSERT_GT(one["digests"].size(), fewest);
    for (const unsigned ranks : { 2U, 4U })
    {
      SCOPED_TRACE(ranks);
      const auto ofRanks = Ask(ranks, { "distributed", file }).answers.at("distributed");
      ASSERT_EQ(ofRanks.size(), ranks);
      Json all = Json::object();
      for (const auto& [rank, answer] : ofRanks)
      {
        EXPECT_EQ(answer["partitions"], one["partitions"]);
        EXPECT_EQ(answer["digests"].size(), one["digests"].size() / ranks) << rank;
        all.update(answer["digests"]);
      }
      EXPECT_EQ(all, one["digests"]);
    }
  }

  static inline std::unique_ptr<TemporaryFolder> Folder;
  static inline std::string Store;
  static inline Json Info; // printed by kdstream-store
};

}

TEST_F(TestParaView, ProcessesHaveAllOfAStoreOnce)
{
  for (const unsigned ranks : { 1U, 2U, 4U })
  {
    ExpectContents(Ask(ranks, { "store", Store }).answers, ranks);
  }
}

TEST_F(TestParaView, AServerGivesWhatTheStoreGives)
{
  const FolderServer server(KDSTREAM_PROGRAMS, *Folder / "models");
  const Answers fetched = Ask(2, { "server", server.Url }).answers;
  ExpectContents(fetched, 2);
  const Answers read = Ask(2, { "parts_of_store", Store }).answers;
  for (const char* const what : { "partitions", "region", "view" })
  {
    EXPECT_EQ(fetched.at(what), read.at(what)) << what;
  }
  EXPECT_EQ(Sum(read.at("partitions"), "partitions"), 2U);
  EXPECT_GT(Sum(read.at("region"), "partitions"), 2U);
  EXPECT_LT(Sum(read.at("region"), "partitions"), Info["partitions"].get<unsigned>() / 2);
  EXPECT_GT(Sum(read.at("view"), "triangles"), 10000U);
  EXPECT_LT(Sum(read.at("view"), "triangles"), 60000U);
}

TEST_F(TestParaView, ThePanelHasWhatTheModelHas)
{
  ASSERT_EQ(RunTool(*Folder, "generate", { "vase", "vase.ply" }).exitCode, 0);
  ASSERT_EQ(RunTool(*Folder, "build", { "vase.ply", "-o", "vase.kds" }).exitCode, 0);
  const std::string store = (*Folder / "vase.kds").string();
  const Json info = Json::parse(RunTool(*Folder, "store", { "info", store, "--json" }).out);
  const Answers answers = Ask(1, { "panel", store }).answers;
  const auto& levels = answers.at("levels").at(0);
  EXPECT_EQ(levels["least"], -1);
  EXPECT_EQ(levels["most"], info["finest_depth"]);
  EXPECT_LT(Sum(answers.at("at first"), "triangles"), 6000U) << "not the preview";
  Json names = Json::array();
  for (const Json& array : info["attributes"])
  {
    names.push_back(array["name"]);
  }
  ASSERT_FALSE(names.empty());
  EXPECT_EQ(answers.at("arrays").at(0)["names"], names);
  EXPECT_EQ(answers.at("all arrays").at(0)["names"], names);
  EXPECT_EQ(answers.at("no arrays").at(0)["names"], Json::array());
}

TEST_F(TestParaView, FiltersCutAndSimplify)
{
  const Answers answers = Ask(1, { "filters", Store, KDSTREAM_DRAGON }).answers;
  for (const std::string of : { "store", "mesh", "blocks", "group", "multiblock" })
  {
    SCOPED_TRACE(of);
    for (const std::string what : { "", " in partitions", " with its partitions" })
    {
      if (!answers.contains(of + what)) // composite data are only counted after the filter
      {
        continue;
      }
      ExpectOriginal(answers.at(of + what), of == "mesh" ? Info["welded"].get<unsigned>() : 0);
    }
    EXPECT_EQ(answers.at(of + " in partitions").at(0)["partitions"], Info["partitions"]);
    const auto triangles = Sum(answers.at(of + " simplified"), "triangles");
    EXPECT_GT(triangles, 19000U);
    EXPECT_LE(triangles, 20000U);
  }
  EXPECT_EQ(Sum(answers.at("clusters"), "vertices"), Info["partitions"]);
  EXPECT_GT(Sum(answers.at("cells"), "vertices"), 10000U);
  EXPECT_EQ(answers.at("cells").at(0)["vertices"], answers.at("cells again").at(0)["vertices"]);
}

// All processes build one tree. Together they have the partitions that a single process makes, bit
// for bit.
TEST_F(TestParaView, ProcessesCutOneMeshTogether)
{
  ExpectTogether(KDSTREAM_DRAGON, KDSTREAM_DRAGON, 100);
}

// The same if each process has only a part of the mesh, and ids say which points are the same.
TEST_F(TestParaView, ProcessesCutTheirPartsTogether)
{
  constexpr int side = 150;
  std::ofstream ply(*Folder / "numbered.ply");
  ply << "ply\nformat ascii 1.0\nelement vertex " << side * side
      << "\nproperty float x\nproperty float y\nproperty float z\nproperty int GlobalIds\n"
      << "element face " << 2 * (side - 1) * (side - 1)
      << "\nproperty list uchar int vertex_indices\nproperty int GlobalIds\nend_header\n";
  for (int i = 0; i < side * side; ++i)
  {
    ply << i % side << " " << i / side << " " << i * i % 7 << " " << i << "\n";
  }
  for (int i = 0, face = 0; i < side * (side - 1); ++i)
  {
    if (i % side < side - 1)
    {
      ply << "3 " << i << " " << i + 1 << " " << i + side << " " << face++ << "\n";
      ply << "3 " << i + 1 << " " << i + side + 1 << " " << i + side << " " << face++ << "\n";
    }
  }
  ply.close();
  const Outcome built =
    RunTool(*Folder, "build", { "numbered.ply", "-o", "numbered.kds", "--precision", "lossless" });
  ASSERT_EQ(built.exitCode, 0) << built.err;
  ExpectTogether((*Folder / "numbered.ply").string(), (*Folder / "numbered.kds").string(), 15);
}

// If ParaView replaced the filter's executive by its own, the other processes would wait forever.
TEST_F(TestParaView, ProcessesFailTogether)
{
  for (const unsigned ranks : { 2U, 4U })
  {
    SCOPED_TRACE(ranks);
    const auto [answers, errors] =
      Ask(ranks, { "failing", Store, (*Folder / "none.kds").string() });
    EXPECT_NE(errors.find("none.kds: "), std::string::npos) << errors;
    EXPECT_NE(errors.find("its input could not be made (rank 1 on "), std::string::npos) << errors;
    EXPECT_EQ(Sum(answers.at("failed"), "vertices"), 0U);
    ASSERT_EQ(answers.at("code").size(), ranks);
    for (const auto& [rank, answer] : answers.at("code"))
    {
      EXPECT_NE(answer["code"], 0) << rank;
    }
    EXPECT_EQ(Sum(answers.at("mended"), "triangles"), Info["triangles"].get<std::uint64_t>());
  }
}

TEST_F(TestParaView, PartitionsHaveColours)
{
  std::filesystem::create_directories(KDSTREAM_PICTURES);
  const std::string file = std::string(KDSTREAM_PICTURES) + "/paraview.png";
  const Answers answers = Ask(1, { "picture", Store, file }).answers;
  const Json& picture = answers.at("picture").at(0);
  EXPECT_GT(picture["shown"], 0.2) << file;
  EXPECT_LT(picture["shown"], 0.6) << file;
  EXPECT_GT(picture["vivid"], 0.4) << file;
  // From ParaView 5.12 on, all partitions of a data set are one block, of one colour.
  EXPECT_GE(picture["hues"], picture["coloursPartitions"].get<bool>() ? 4 : 1)
    << file << ": of the six orders of red, green and blue";
}

TEST_F(TestParaView, ErrorsNameTheFileAndTheServer)
{
  std::ofstream(*Folder / "broken.kds") << "no store";
  const FolderServer server(KDSTREAM_PROGRAMS, *Folder / "models");
  const auto [answers, errors] =
    Ask(1, { "broken", (*Folder / "broken.kds").string(), server.Url + "/nowhere" });
  EXPECT_EQ(answers.count("not offered"), 1U);
  EXPECT_NE(errors.find("broken.kds: "), std::string::npos) << errors;
  EXPECT_NE(errors.find(server.Url + "/nowhere: "), std::string::npos) << errors;
}
