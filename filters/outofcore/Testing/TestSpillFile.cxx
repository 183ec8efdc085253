// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/ErrorAt.h"
#include "filters/outofcore/Testing/SpillTools.h"
#include "filters/outofcore/files/RecordFile.h"
#include "filters/outofcore/files/SpillFile.h"

#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <numeric>

#include <sys/resource.h>

using namespace kdstream;
using kdstream::testing::MakeSpillFolder;
namespace fs = std::filesystem;

namespace
{

std::size_t EntriesOf(const fs::path& folder)
{
  return static_cast<std::size_t>(
    std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

// While this exists, no file of this process may grow beyond a limit.
class FileSizeLimit
{
public:
  explicit FileSizeLimit(rlim_t bytes)
  {
    this->OldHandler = std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &this->Old);
    const rlimit limit{ bytes, this->Old.rlim_max };
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit()
  {
    setrlimit(RLIMIT_FSIZE, &this->Old);
    std::signal(SIGXFSZ, this->OldHandler);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

private:
  rlimit Old = {};
  void (*OldHandler)(int) = nullptr;
};

}

TEST(SpillFile, FolderGoesWithAllThatIsInIt)
{
  fs::path path;
  {
    const SpillFolder parent = MakeSpillFolder();
    SpillFolder folder = std::move(*SpillFolder::Create(parent.Path()));
    path = folder.Path();
    EXPECT_EQ(path.parent_path(), parent.Path());
    Result<SpillFile> file = folder.CreateFile("points", 100);
    ASSERT_TRUE(file);
    EXPECT_EQ(EntriesOf(path), 1U);
    const SpillFolder moved = std::move(folder);
    EXPECT_TRUE(fs::exists(path));
  }
  EXPECT_FALSE(fs::exists(path));
  EXPECT_FALSE(fs::exists(path.parent_path()));
}

TEST(SpillFile, RemovedFilesGiveTheirBytesBack)
{
  SpillFolder folder = MakeSpillFolder();
  {
    SpillFile first = std::move(*folder.CreateFile("points", 0));
    const std::vector<std::byte> bytes(1000);
    ASSERT_TRUE(first.Write(0, bytes));
    ASSERT_TRUE(first.Write(500, bytes)); // overwrites 500 of them
    EXPECT_EQ(first.Size(), 1500U);
    SpillFile second = std::move(*folder.CreateFile("points", 0));
    ASSERT_TRUE(second.Write(0, bytes));
    EXPECT_EQ(folder.Counts().bytesOnDisk, 2500U);
    second = SpillFile();
    EXPECT_EQ(EntriesOf(folder.Path()), 1U);
    EXPECT_EQ(folder.Counts().bytesOnDisk, 1500U);
  }
  EXPECT_EQ(EntriesOf(folder.Path()), 0U);
  const SpillCounts counts = folder.Counts();
  EXPECT_EQ(counts.bytesOnDisk, 0U);
  EXPECT_EQ(counts.peakBytesOnDisk, 2500U);
  EXPECT_EQ(counts.bytesWritten, 3000U);
}

TEST(SpillFile, RecordsComeBackInAnyBlockSize)
{
  SpillFolder folder = MakeSpillFolder();
  std::vector<std::uint64_t> numbers(1000);
  std::iota(numbers.begin(), numbers.end(), 7U);
  for (const std::size_t blockBytes : { 1U, 8U, 24U, 4096U, 1U << 20 })
  {
    SpillFile file = std::move(*folder.CreateFile("numbers", 8000));
    RecordWriter<std::uint64_t> writer(file, 0, blockBytes);
    for (const std::uint64_t number : numbers)
    {
      writer.Append(number);
    }
    EXPECT_EQ(writer.Position(), numbers.size());
    ASSERT_TRUE(writer.Finish());
    EXPECT_EQ(file.Size(), 8000U);
    RecordReader<std::uint64_t> reader(file, 3, 990, blockBytes);
    std::vector<std::uint64_t> back;
    for (auto block = reader.Next(); block && !block->empty(); block = reader.Next())
    {
      back.insert(back.end(), block->begin(), block->end());
    }
    EXPECT_EQ(back, std::vector<std::uint64_t>(numbers.begin() + 3, numbers.begin() + 990));
  }
}

TEST(SpillFile, AllBlocksOfRecordsAreVisitedUpToAnError)
{
  SpillFolder folder = MakeSpillFolder();
  SpillFile file = std::move(*folder.CreateFile("numbers", 0));
  std::vector<std::uint64_t> numbers(300000); // more than two blocks
  std::iota(numbers.begin(), numbers.end(), 7U);
  ASSERT_TRUE(WriteRecords<std::uint64_t>(file, 0, std::span<const std::uint64_t>(numbers)));
  std::vector<std::uint64_t> back;
  const auto append = [&](std::span<const std::uint64_t> block)
  {
    EXPECT_LE(block.size_bytes(), spillBlockBytes);
    back.insert(back.end(), block.begin(), block.end());
  };
  EXPECT_TRUE(ForEachBlockOf<std::uint64_t>(file, 5, 5, append));
  EXPECT_TRUE(back.empty());
  EXPECT_TRUE(ForEachBlockOf<std::uint64_t>(file, 5, 299990, append));
  EXPECT_EQ(back, std::vector<std::uint64_t>(numbers.begin() + 5, numbers.begin() + 299990));
  const Status status = ForEachBlockOf<std::uint64_t>(file, 299990, 300001, append);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.GetError().code, ErrorCode::InputOutput);
}

TEST(SpillFile, SaysWhereAFileEndsTooEarly)
{
  SpillFolder folder = MakeSpillFolder();
  SpillFile file = std::move(*folder.CreateFile("points", 100));
  ASSERT_TRUE(file.Write(0, std::vector<std::byte>(100)));
  std::vector<std::byte> bytes(60);
  EXPECT_TRUE(file.Read(40, bytes));
  const Status status = file.Read(50, bytes);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.GetError().code, ErrorCode::InputOutput);
  EXPECT_NE(
    status.GetError().message.find("10 bytes at offset 100 cannot be read: the file ends before"),
    std::string::npos)
    << status.GetError().message;
}

TEST(SpillFile, AFullDiskSaysWhatWasNeeded)
{
  SpillFolder folder = MakeSpillFolder();
  const std::uint64_t exbibyte = std::uint64_t{ 1 } << 60;
  const Result<SpillFile> large = folder.CreateFile("points of the tree", exbibyte);
  ASSERT_FALSE(large);
  EXPECT_EQ(large.GetError().code, ErrorCode::DiskFull);
  EXPECT_NE(large.GetError().message.find(
              "points of the tree need 1152921504606846976 bytes, of which 0 are written; "),
    std::string::npos)
    << large.GetError().message;
  EXPECT_EQ(EntriesOf(folder.Path()), 0U);

  const FileSizeLimit limit(50000);
  SpillFile file = std::move(*folder.CreateFile("keys", 40000));
  RecordWriter<std::uint32_t> writer(file, 0, 16384);
  for (std::uint32_t i = 0; i < 20000; ++i)
  {
    writer.Append(i);
  }
  const Status status = writer.Finish();
  ASSERT_FALSE(status);
  EXPECT_NE(status.GetError().message.find("keys need "), std::string::npos);
  EXPECT_NE(status.GetError().message.find("of which 50000 are written"), std::string::npos)
    << status.GetError().message;
}

TEST(SpillFile, SaysThatNoFolderCanBeMade)
{
  const Result<SpillFolder> folder = SpillFolder::Create("/nowhere/at/all");
  ASSERT_TRUE(fixtures::FailsAt(folder, ErrorCode::InputOutput));
  EXPECT_EQ(folder.GetError().file, "/nowhere/at/all");
}
