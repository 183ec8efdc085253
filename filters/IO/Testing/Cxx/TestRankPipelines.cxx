// SPDX-License-Identifier: BSD-3-Clause
// Pipelines on several processes. RankPipelines compares their results with those of one process;
// RankFaults makes one process fail.
#include "filters/Parallel/Testing/RunRanks.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

namespace
{

using namespace kdstream::fixtures;

class RankPipelines : public ::testing::TestWithParam<unsigned>
{
protected:
  static void SetUpTestSuite() { ::setenv("VTK_SMP_MAX_THREADS", "1", 1); }
  void Expect(std::vector<std::string> arguments, const char* program = "RankPipelines")
  {
    std::filesystem::create_directory(this->Folder / "one");
    std::vector<std::string> command{ std::string(KDSTREAM_PROGRAMS) + "/" + program, arguments[0],
      this->Folder.Path.string() };
    command.insert(command.end(), arguments.begin() + 1, arguments.end());
    const Outcome outcome =
      RunProgram(this->Folder, KDSTREAM_MPIRUN, Ranks(this->GetParam(), command));
    EXPECT_EQ(outcome.exitCode, 0) << outcome.out << outcome.err;
  }

  TemporaryFolder Folder;
};

TEST_P(RankPipelines, PartitionsAreThoseOfTheWholeMeshByGlobalIds)
{
  this->Expect({ "ids" });
}

TEST_P(RankPipelines, PartitionsAreThoseOfTheSharesInTurn)
{
  this->Expect({ "turn" });
}

TEST_P(RankPipelines, GhostsAreNotCounted)
{
  this->Expect({ "ghosts" });
}

TEST_P(RankPipelines, BlocksAreOneMesh)
{
  this->Expect({ "blocks" });
}

TEST_P(RankPipelines, AnErrorOfOneIsAnErrorOfAll)
{
  this->Expect({ "error" });
}

TEST_P(RankPipelines, TextsAreLeftOutWithAWarning)
{
  this->Expect({ "texts" });
}

TEST_P(RankPipelines, AnErrorOfOnesInputIsAnErrorOfAll)
{
  this->Expect({ "input" });
}

TEST_P(RankPipelines, TheFileNameOfTheFirstCounts)
{
  this->Expect({ "name" });
}

TEST_P(RankPipelines, IdsThatEachRankCountsAreNotBelieved)
{
  this->Expect({ "restart" });
}

TEST_P(RankPipelines, ArraysOfCellsAreOfThoseThatHaveCells)
{
  this->Expect({ "arrays" });
}

TEST_P(RankPipelines, EachRankHasItsPiece)
{
  this->Expect({ "pieces" });
}

TEST_P(RankPipelines, TheStoreIsThatOfOneProcess)
{
  this->Expect({ "store" });
}

TEST_P(RankPipelines, TheStoreIsThatOfAllParts)
{
  this->Expect({ "parts" });
}

// Failures of one rank, or unusual ids. The number of ranks matters little.
class RankFaults : public RankPipelines
{
protected:
  void ExpectOfAll(const char* what) { this->Expect({ what }, "RankFaults"); }
};

TEST_P(RankFaults, NoInputOrAnother)
{
  this->ExpectOfAll("inputs");
}

TEST_P(RankFaults, NoInputAfterAnotherFilter)
{
  this->ExpectOfAll("behind");
}

TEST_P(RankFaults, NoInputInParaView)
{
  this->ExpectOfAll("paraview");
}

TEST_P(RankFaults, OtherOptions)
{
  this->ExpectOfAll("options");
}

TEST_P(RankFaults, MemoryEnds)
{
  this->ExpectOfAll("memory");
}

TEST_P(RankFaults, AllIdsComeToTheSame)
{
  this->Expect({ "stray" });
}

TEST_P(RankFaults, SharesAreAlikeWhateverTheIds)
{
  this->ExpectOfAll("shares");
}

TEST_P(RankFaults, NoFolder)
{
  this->ExpectOfAll("folders");
}

TEST_P(RankPipelines, TheDragon)
{
  if (this->GetParam() == 3)
  {
    GTEST_SKIP() << "on 2 and 4, that is enough";
  }
  if (!std::filesystem::exists(KDSTREAM_DRAGON))
  {
    GTEST_SKIP() << "Data/fetch-dragon fetches the dragon";
  }
  this->Expect({ "file", KDSTREAM_DRAGON });
}

INSTANTIATE_TEST_SUITE_P(Ranks, RankFaults, ::testing::Values(3U),
  [](const auto& ranks) { return "On" + std::to_string(ranks.param); });

INSTANTIATE_TEST_SUITE_P(Ranks, RankPipelines, ::testing::Values(2U, 3U, 4U),
  [](const auto& ranks) { return "On" + std::to_string(ranks.param); });

}
