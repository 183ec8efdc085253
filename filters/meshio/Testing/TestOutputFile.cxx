// SPDX-License-Identifier: BSD-3-Clause
// OutputFile: the file appears whole or not at all, and the first error is reported.
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/meshio/OutputFile.h"

#include <gtest/gtest.h>

#include <csignal>
#include <cstdint>

#include <sys/resource.h>
#include <sys/stat.h>

namespace kdstream::test
{

TEST(OutputFile, AppearsWholeUnderItsName)
{
  const fixtures::TemporaryFolder folder;
  const auto file = folder.Write("out.bin", "the old content");
  {
    OutputFile output;
    ASSERT_TRUE(output.Open(file));
    for (int i = 0; i < 300000; ++i)
    {
      output.WriteText(static_cast<float>(i) * 0.1F);
      output.Write("\n");
      output.WriteLittleEndian(static_cast<std::uint32_t>(i));
    }
    EXPECT_EQ(fixtures::ReadWhole(file), "the old content") << "nothing is seen before Finish";
    ASSERT_TRUE(output.Finish());
  }
  EXPECT_EQ(folder.Names().size(), 1U);
  const std::string bytes = fixtures::ReadWhole(file);
  std::size_t at = 0;
  for (int i = 0; i < 300000; ++i)
  {
    const std::size_t end = bytes.find('\n', at);
    ASSERT_NE(end, std::string::npos);
    ASSERT_EQ(std::stof(bytes.substr(at, end - at)), static_cast<float>(i) * 0.1F);
    for (int k = 0; k < 4; ++k)
    {
      ASSERT_EQ(static_cast<unsigned char>(bytes[end + 1 + static_cast<std::size_t>(k)]),
        (i >> (8 * k)) & 255);
    }
    at = end + 5;
  }
  EXPECT_EQ(at, bytes.size());
}

TEST(OutputFile, GetsThePermissionsOfANewFile)
{
  const fixtures::TemporaryFolder folder;
  const mode_t before = umask(027);
  OutputFile output;
  ASSERT_TRUE(output.Open(folder / "out.bin"));
  ASSERT_TRUE(output.Finish());
  umask(before);
  struct stat status = {};
  ASSERT_EQ(stat((folder / "out.bin").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0640U);
}

TEST(OutputFile, LeavesNothingWhenItIsNotFinished)
{
  const fixtures::TemporaryFolder folder;
  const auto file = folder.Write("out.bin", "old");
  {
    OutputFile output;
    ASSERT_TRUE(output.Open(file));
    output.Write(std::string(3 << 20, 'x'));
  }
  EXPECT_EQ(folder.Names().size(), 1U);
  EXPECT_EQ(fixtures::ReadWhole(file), "old");
}

TEST(OutputFile, KeepsThePermissionsOfWhatItReplaces)
{
  const fixtures::TemporaryFolder folder;
  const auto file = folder.Write("out.bin", "private");
  ASSERT_EQ(chmod(file.c_str(), 0600), 0);
  OutputFile output;
  ASSERT_TRUE(output.Open(file));
  output.Write("mine");
  ASSERT_TRUE(output.Finish());
  struct stat status = {};
  ASSERT_EQ(stat(file.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600U);
  EXPECT_EQ(fixtures::ReadWhole(file), "mine");
}

TEST(OutputFile, SaysWhyItCannotBeOpened)
{
  const fixtures::TemporaryFolder folder;
  OutputFile missing;
  const Status noFolder = missing.Open(folder / "no/out.bin");
  ASSERT_FALSE(noFolder);
  EXPECT_TRUE(fixtures::FailsAt(noFolder, ErrorCode::InputOutput));

  OutputFile special;
  const Status device = special.Open("/dev/null");
  ASSERT_FALSE(device);
  EXPECT_TRUE(fixtures::FailsAt(device, ErrorCode::InputOutput));
  OutputFile onFolder;
  EXPECT_FALSE(onFolder.Open(folder / "."));
}

// A limit on the file size simulates a full disk.
TEST(OutputFile, SaysThatTheDiskIsFullAndRemovesItsFile)
{
  const fixtures::TemporaryFolder folder;
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  rlimit small = before;
  small.rlim_cur = 1 << 20;
  const auto oldHandler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  Status finished;
  {
    OutputFile output;
    EXPECT_TRUE(output.Open(folder / "out.bin"));
    for (int i = 0; i < 5; ++i)
    {
      output.Write(std::string(1 << 20, 'x'));
    }
    finished = output.Finish();
  }
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, oldHandler);
  ASSERT_FALSE(finished);
  EXPECT_TRUE(fixtures::FailsAt(finished, ErrorCode::DiskFull));
  EXPECT_EQ(folder.Names().size(), 0U);
}

}
