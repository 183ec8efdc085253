// SPDX-License-Identifier: BSD-3-Clause
// Builds that are killed and resumed. Which build may resume another: TestBuildFingerprint.
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/outofcore/Testing/BuildFolders.h"

#include <csignal>
#include <fstream>
#include <optional>

#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

using namespace kdstream;
using namespace kdstream::testing;
namespace fs = std::filesystem;

namespace
{

// A second phase: leaves the squares of the numbers, and the numbers again.
Status Square(BuildFolder& folder)
{
  const auto size = folder.BlobOf("numbers").Read<std::uint64_t>();
  Result<SpillFile> numbers = folder.TakeFile("numbers", "numbers");
  Result<SpillFile> nothing = folder.TakeFile("numbers", "nothing");
  Result<SpillFile> squares = folder.Files().CreateFile("squares", size * sizeof(std::uint64_t));
  Result<SpillFile> scratch = folder.Files().CreateFile("scratch", 10);
  if (!numbers || !nothing || nothing->IsOpen() || !squares || !scratch)
  {
    return Error{ ErrorCode::InputOutput, "files of squares" };
  }
  std::vector<std::uint64_t> values = ReadBack<std::uint64_t>(*numbers);
  for (std::uint64_t& value : values)
  {
    value *= value;
  }
  Status status = WriteRecords<std::uint64_t>(*squares, 0, std::span<const std::uint64_t>(values));
  BlobWriter blob;
  blob.AddList(std::vector<double>{ 1.5, -2 });
  blob.AddText("squares");
  PhaseFile files[] = { { "squares", std::move(*squares) }, { "numbers", std::move(*numbers) } };
  return status ? folder.Finish("squares", blob, files, { { "numbers", "" } }) : status;
}

Status Sum(BuildFolder& folder)
{
  Result<SpillFile> numbers = folder.TakeFile("squares", "numbers");
  Result<SpillFile> squares = folder.TakeFile("squares", "squares");
  if (!numbers || !squares)
  {
    return !numbers ? numbers.GetError() : squares.GetError();
  }
  std::vector<std::uint64_t> sums = ReadBack<std::uint64_t>(*numbers);
  const std::vector<std::uint64_t> values = ReadBack<std::uint64_t>(*squares);
  std::transform(sums.begin(), sums.end(), values.begin(), sums.begin(), std::plus<>());
  PhaseFile files[] = { { "sums", Spilled(folder.Files(), sums) } };
  return folder.Finish("sums", {}, files, { { "squares", "squares" }, { "squares", "numbers" } });
}

// A build of three phases. Returns the sums that it makes, or an error.
Result<std::vector<std::uint64_t>> Build(BuildFolder& folder)
{
  Status status = folder.Finished("numbers") ? Status{} : MakeNumbers(folder);
  if (status && !folder.Finished("squares"))
  {
    status = Square(folder);
  }
  if (status && !folder.Finished("sums"))
  {
    status = Sum(folder);
  }
  KDSTREAM_TRY(status);
  BlobReader blob = folder.BlobOf("squares");
  EXPECT_EQ(blob.ReadList<double>(), (std::vector<double>{ 1.5, -2 }));
  EXPECT_EQ(blob.ReadText(), "squares");
  EXPECT_TRUE(blob.Finish());
  const Result<SpillFile> sums = folder.TakeFile("sums", "sums");
  return sums ? ReadBack<std::uint64_t>(*sums)
              : Result<std::vector<std::uint64_t>>(sums.GetError());
}

std::vector<std::uint64_t> Expected()
{
  std::vector<std::uint64_t> sums(numberCount);
  for (std::size_t i = 0; i < numberCount; ++i)
  {
    sums[i] = (i + 1) * (i + 2);
  }
  return sums;
}

class TestBuildFolder : public BuildFolderTest
{
protected:
  // Runs the first `phases` phases, and leaves their files.
  void Leave(std::size_t phases) const
  {
    BuildFolder folder = this->Open(false);
    Status status = MakeNumbers(folder);
    if (status && phases > 1)
    {
      status = Square(folder);
    }
    if (status && phases > 2)
    {
      status = Sum(folder);
    }
    ASSERT_TRUE(status);
    folder.Keep(true);
  }
  // Runs a build in a process of its own, which is killed before the k-th operation on its files.
  // Returns whether it was killed.
  bool BuildAndKill(std::size_t k) const
  {
    const pid_t child = fork();
    if (child == 0)
    {
      bool good = false;
      {
        std::size_t operations = 0;
        Result<BuildFolder> folder = BuildFolder::Open(this->Path(), "same", true,
          [&](FileOperation)
          {
            if (operations++ == k)
            {
              kill(getpid(), SIGKILL);
            }
          });
        good = folder && Build(*folder);
      }
      _exit(good ? 0 : 1);
    }
    int state = 0;
    waitpid(child, &state, 0);
    EXPECT_TRUE(WIFSIGNALED(state) ? WTERMSIG(state) == SIGKILL : WEXITSTATUS(state) == 0);
    return WIFSIGNALED(state);
  }
};

}

TEST_F(TestBuildFolder, GoesOnFromTheLastFinishedPhaseWhereverItWasKilled)
{
  std::vector<std::size_t> finished;
  for (std::size_t k = 0; this->BuildAndKill(k); ++k)
  {
    ASSERT_LT(k, 200U);
    BuildFolder folder = this->Open(true);
    finished.push_back(folder.FinishedPhases());
    const auto result = Build(folder);
    ASSERT_TRUE(result) << "killed before operation " << k << ": " << result.GetError().message;
    EXPECT_EQ(*result, Expected());
    EXPECT_EQ(folder.Files().Counts().bytesOnDisk, numberCount * sizeof(std::uint64_t));
    EXPECT_EQ(EntriesOf(this->Path()).size(), 2U) << "journal and sums";
    {
      const BuildFolder gone = std::move(folder);
    }
    ASSERT_TRUE(EntriesOf(this->Parent.Path()).empty()) << "killed before operation " << k;
  }
  EXPECT_TRUE(EntriesOf(this->Parent.Path()).empty());
  // No finished phase may be repeated, up to the point where the journal is removed. After that
  // only the folder and the lock are left.
  ASSERT_GT(finished.size(), 20U);
  const auto most = std::max_element(finished.begin(), finished.end());
  EXPECT_EQ(*most, 3U);
  EXPECT_TRUE(std::is_sorted(finished.begin(), finished.end() - 2));
  EXPECT_EQ(*(finished.end() - 3), 3U);
  EXPECT_EQ(finished.back(), 0U);
}

TEST_F(TestBuildFolder, MayBeKilledAgainAndAgain)
{
  for (const std::size_t step : { 6U, 7U, 11U, 17U })
  {
    // Opening the folder again costs a few operations too.
    std::size_t kills = 0;
    for (std::size_t k = step; this->BuildAndKill(k); k += step)
    {
      ++kills;
    }
    EXPECT_GT(kills, 0U);
    EXPECT_TRUE(EntriesOf(this->Parent.Path()).empty());
  }
}

TEST_F(TestBuildFolder, ABuildThatDoesNotResumeThrowsAwayWhatIsThere)
{
  this->Leave(2);
  {
    BuildFolder folder = this->Open(false, "other");
    EXPECT_EQ(folder.FinishedPhases(), 0U);
    EXPECT_TRUE(EntriesOf(this->Path()).empty());
    folder.Keep(true);
  }
  EXPECT_EQ(this->FinishedPhases(), 0U) << "the journal went too";
}

TEST_F(TestBuildFolder, ReportsWhatCouldBeResumedAndTouchesNothing)
{
  const auto lastPhaseIn = [](const fs::path& path)
  {
    const std::optional<LeftBuild> left = BuildFolder::LeftIn(path);
    return left ? left->lastPhase : std::string();
  };
  EXPECT_EQ(lastPhaseIn(this->Path()), "") << "there is no folder";
  EXPECT_TRUE(EntriesOf(this->Parent.Path()).empty());
  this->Leave(2);
  const std::vector<fs::path> before = EntriesOf(this->Path());
  EXPECT_EQ(lastPhaseIn(this->Path()), "squares");
  EXPECT_EQ(BuildFolder::LeftIn(this->Path())->fingerprint, "same");
  EXPECT_EQ(EntriesOf(this->Path()), before);
  {
    BuildFolder running = this->Open(true);
    EXPECT_EQ(lastPhaseIn(this->Path()), "") << "a build is running";
    running.Keep(true);
  }
  EXPECT_EQ(lastPhaseIn(this->Path()), "squares");
  fs::permissions(this->Path(), fs::perms::others_write, fs::perm_options::add);
  EXPECT_EQ(lastPhaseIn(this->Path()), "") << "others may write there";
  fs::permissions(this->Path(), fs::perms::others_write, fs::perm_options::remove);
  EXPECT_EQ(this->FinishedPhases(), 2U);
}

TEST_F(TestBuildFolder, GoesUnlessItIsKept)
{
  this->Leave(1);
  EXPECT_EQ(EntriesOf(this->Parent.Path()).size(), 1U) << "no lock";
  {
    BuildFolder folder = this->Open(true);
    EXPECT_EQ(folder.FinishedPhases(), 1U);
    EXPECT_EQ(folder.Files().Counts().bytesOnDisk, numberCount * sizeof(std::uint64_t));
    const SpillFile scratch = std::move(*folder.Files().CreateFile("scratch", 0));
    EXPECT_EQ(EntriesOf(this->Path()).size(), 3U);
  }
  EXPECT_TRUE(EntriesOf(this->Parent.Path()).empty());
}

TEST_F(TestBuildFolder, RemovesWhatTheJournalDoesNotName)
{
  this->Leave(2);
  std::ofstream(this->Path() / "77") << "of a phase that was not finished";
  fs::create_directory(this->Path() / "folder");
  std::ofstream(this->Path() / "folder" / "file") << "whoever made it";
  BuildFolder folder = this->Open(true);
  EXPECT_EQ(folder.FinishedPhases(), 2U);
  EXPECT_EQ(EntriesOf(this->Path()).size(), 3U) << "journal, numbers, squares";
}

TEST_F(TestBuildFolder, APhaseWithoutItsFilesIsNotFinished)
{
  for (std::size_t phases = 1; phases <= 3; ++phases)
  {
    // Each file in turn is shortened, lengthened or removed.
    for (int damage = 0; damage < 3; ++damage)
    {
      this->Leave(phases);
      std::size_t files = EntriesOf(this->Path()).size();
      for (std::size_t i = 0; i < files; ++i)
      {
        const fs::path file = EntriesOf(this->Path())[i];
        if (file.filename() == "journal")
        {
          continue;
        }
        damage == 2 ? static_cast<void>(fs::remove(file))
                    : fs::resize_file(file, damage == 0 ? 7999 : 8001);
        BuildFolder folder = this->Open(true);
        EXPECT_LT(folder.FinishedPhases(), phases);
        const auto result = Build(folder);
        ASSERT_TRUE(result) << result.GetError().message;
        EXPECT_EQ(*result, Expected());
        {
          const BuildFolder gone = std::move(folder);
        }
        this->Leave(phases);
      }
    }
  }
}

TEST_F(TestBuildFolder, ADamagedJournalCountsAsNone)
{
  this->Leave(2);
  const fs::path journal = this->Path() / "journal";
  const std::string whole = fixtures::ReadWhole(journal);
  for (std::size_t i = 0; i < whole.size(); i += 3)
  {
    std::string flipped = whole;
    flipped[i] = char(flipped[i] ^ (1 << (i % 8)));
    for (const std::string& damaged : { whole.substr(0, i), flipped, whole + "x" })
    {
      EXPECT_FALSE(DecodeJournal(std::as_bytes(std::span(damaged))));
    }
  }
  EXPECT_TRUE(DecodeJournal(std::as_bytes(std::span(whole))));
  std::ofstream(journal, std::ios::binary) << whole.substr(0, whole.size() - 1);
  EXPECT_EQ(this->FinishedPhases(), 0U);
}

TEST_F(TestBuildFolder, OneBuildOfAStoreAtATime)
{
  std::optional<BuildFolder> first(this->Open(true));
  const Result<BuildFolder> second = BuildFolder::Open(this->Path(), "same", true);
  ASSERT_TRUE(fixtures::FailsAt(second, ErrorCode::LimitExceeded, this->Path().string() + ".lock"));
  EXPECT_EQ(second.GetError().file, "") << "the folder is not at fault";
  std::optional<SpillFile> file(std::move(*first->Files().CreateFile("points", 0)));
  first.reset();
  EXPECT_FALSE(BuildFolder::Open(this->Path(), "same", true)) << "a file is still open";
  file.reset();
  EXPECT_TRUE(BuildFolder::Open(this->Path(), "same", true));
  EXPECT_TRUE(EntriesOf(this->Parent.Path()).empty());
}

TEST_F(TestBuildFolder, FilesOfFinishedPhasesAreOnlyRead)
{
  BuildFolder folder = this->Open(false);
  ASSERT_TRUE(MakeNumbers(folder));
  SpillFile numbers = std::move(*folder.TakeFile("numbers", "numbers"));
  const Status status = numbers.Write(0, std::vector<std::byte>(8));
  ASSERT_FALSE(status);
  EXPECT_NE(status.GetError().message.find("belongs to a finished phase"), std::string::npos);
  EXPECT_EQ(folder.TakeFile("numbers", "letters").GetError().code, ErrorCode::NotFound);
  EXPECT_EQ(folder.TakeFile("letters", "numbers").GetError().code, ErrorCode::NotFound);
  ASSERT_TRUE(folder.Finish("next", {}, {}, { { "numbers", "numbers" } }));
  EXPECT_EQ(folder.TakeFile("numbers", "numbers").GetError().code, ErrorCode::NotFound);
  EXPECT_EQ(ReadBack<std::uint64_t>(numbers).size(), numberCount) << "as long as it is open";
}

TEST_F(TestBuildFolder, AFullDiskDoesNotFinishAPhase)
{
  BuildFolder folder = this->Open(false);
  const auto oldHandler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit old = {};
  getrlimit(RLIMIT_FSIZE, &old);
  const rlimit limit{ 100, old.rlim_max };
  setrlimit(RLIMIT_FSIZE, &limit);
  BlobWriter blob;
  blob.AddText(std::string(1000, 'x'));
  const Status status = folder.Finish("large", blob);
  setrlimit(RLIMIT_FSIZE, &old);
  std::signal(SIGXFSZ, oldHandler);
  ASSERT_FALSE(status);
  EXPECT_NE(status.GetError().message.find("entries of the journal need "), std::string::npos)
    << status.GetError().message;
  EXPECT_FALSE(folder.Finished("large"));
  EXPECT_TRUE(folder.Finish("large", blob));
}

TEST_F(TestBuildFolder, TakesNoFolderOfSomebodyElse)
{
  fs::create_directory(this->Path());
  fs::permissions(this->Path(), fs::perms::all);
  EXPECT_FALSE(BuildFolder::Open(this->Path(), "same", true));
  EXPECT_TRUE(fs::exists(this->Path()));
  fs::remove(this->Path());
  fs::create_directory_symlink("/tmp", this->Path());
  EXPECT_FALSE(BuildFolder::Open(this->Path(), "same", true));
  const Result<BuildFolder> nowhere = BuildFolder::Open("/nowhere/at/all", "same", true);
  ASSERT_FALSE(nowhere);
  EXPECT_TRUE(fixtures::FailsAt(nowhere, ErrorCode::InputOutput));
}

TEST_F(TestBuildFolder, HasAPathOfItsOwnForEachStore)
{
  const fs::path store = BuildFolder::PathFor("/models/a/dragon.kds", "");
  EXPECT_EQ(store.parent_path(), "/models/a");
  EXPECT_EQ(store.filename().string().substr(0, 12), ".dragon.kds.");
  EXPECT_EQ(store.extension(), ".build");
  const fs::path elsewhere = BuildFolder::PathFor("/models/a/dragon.kds", "/scratch");
  EXPECT_EQ(elsewhere, "/scratch" / store.filename());
  EXPECT_NE(elsewhere, BuildFolder::PathFor("/models/b/dragon.kds", "/scratch"));
  EXPECT_EQ(elsewhere, BuildFolder::PathFor("/models/b/../a/dragon.kds", "/scratch"));
  EXPECT_EQ(BuildFolder::PathFor("dragon.kds", ""),
    BuildFolder::PathFor(fs::current_path() / "dragon.kds", ""));
  EXPECT_LT(BuildFolder::PathFor(std::string(255, 'x'), "").filename().string().size(), 250U);
}
