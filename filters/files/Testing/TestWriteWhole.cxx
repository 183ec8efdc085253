// SPDX-License-Identifier: BSD-3-Clause
// Writing to an output that a user names: a file is replaced as a whole; devices and descriptors
// are written to, never replaced.
#include "filters/files/WriteWhole.h"

#include "Testing/Fixtures/TemporaryFolder.h"

#include <gtest/gtest.h>

#include <cerrno>
#include <cstring>

#include <array>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

using namespace kdstream;
using fixtures::ReadWhole;
using fixtures::TemporaryFolder;
namespace fs = std::filesystem;

TEST(WriteWhole, AnOutputIsAFileOrWhatIsThere)
{
  const TemporaryFolder folder;
  ASSERT_TRUE(WriteToOutput(folder / "a", "one"));
  ASSERT_TRUE(WriteToOutput(folder / "a", "2"));
  EXPECT_EQ(ReadWhole(folder / "a"), "2");
  ASSERT_TRUE(WriteToOutput("/dev/null", "x"));
  struct stat state = {};
  ASSERT_EQ(::stat("/dev/null", &state), 0);
  EXPECT_TRUE(S_ISCHR(state.st_mode));
  const Status full = WriteToOutput("/dev/full", "x");
  ASSERT_FALSE(full);
  EXPECT_NE(full.GetError().message.find(std::strerror(ENOSPC)), std::string::npos);
  EXPECT_FALSE(WriteToOutput(folder.Path, "x"));
  EXPECT_FALSE(WriteToOutput(folder / "none/a", "x"));
}

TEST(WriteWhole, ADescriptorIsWrittenToAfterWhatIsThere)
{
  std::array<int, 2> pipe{};
  ASSERT_EQ(::pipe(pipe.data()), 0);
  const auto nameOf = [](int descriptor) { return "/dev/fd/" + std::to_string(descriptor); };
  ASSERT_TRUE(WriteToOutput(nameOf(pipe[1]), "piped"));
  std::array<char, 10> got{};
  EXPECT_EQ(::read(pipe[0], got.data(), got.size()), 5);
  const TemporaryFolder folder;
  std::ofstream(folder / "log") << "before ";
  const int log = ::open((folder / "log").c_str(), O_WRONLY);
  ASSERT_TRUE(WriteToOutput(nameOf(log), "after"));
  EXPECT_EQ(ReadWhole(folder / "log"), "before after");
  for (const int descriptor : { pipe[0], pipe[1], log })
  {
    ::close(descriptor);
  }
  EXPECT_TRUE(NamesDescriptor("/dev/stdout"));
  EXPECT_FALSE(NamesDescriptor("/dev/shm/stdout"));
}

TEST(WriteWhole, BytesAreCompared)
{
  const TemporaryFolder folder;
  const std::string bytes(200'000, 'b');
  ASSERT_TRUE(WriteWhole(folder / "a", bytes));
  EXPECT_TRUE(HasBytes(folder / "a", bytes));
  for (const std::size_t at : { std::size_t{ 0 }, std::size_t{ 65'536 }, bytes.size() - 1 })
  {
    std::string other = bytes;
    other[at] = 'c';
    EXPECT_FALSE(HasBytes(folder / "a", other));
  }
  EXPECT_FALSE(HasBytes(folder / "a", bytes.substr(1)));
  EXPECT_FALSE(HasBytes(folder / "none", ""));
  ASSERT_TRUE(WriteWhole(folder / "empty", ""));
  EXPECT_TRUE(HasBytes(folder / "empty", ""));
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0); // no process writes to it
  EXPECT_FALSE(HasBytes(folder / "pipe", ""));
}

TEST(WriteWhole, AFileThatIsThereIsNotWrittenAnew)
{
  const TemporaryFolder folder;
  std::ofstream(folder / "victim") << "precious";
  fs::create_symlink("victim", folder / "a");
  fs::create_symlink("nowhere", folder / "b");
  EXPECT_FALSE(WriteAnew(folder / "a", "x"));
  EXPECT_FALSE(WriteAnew(folder / "b", "x"));
  EXPECT_TRUE(WriteAnew(folder / "c", "x"));
  EXPECT_FALSE(WriteAnew(folder / "c", "y"));
  EXPECT_EQ(ReadWhole(folder / "victim"), "precious");
  EXPECT_FALSE(fs::exists(folder / "nowhere"));
}

TEST(WriteWhole, AFileIsReadWholeOrNotThere)
{
  const TemporaryFolder folder;
  const std::string bytes(200000, 'x');
  ASSERT_TRUE(WriteWhole(folder / "a", bytes));
  const auto read = ReadWholeFile(folder / "a");
  ASSERT_TRUE(read);
  EXPECT_EQ(*read, bytes);
  const auto none = ReadWholeFile(folder / "b");
  ASSERT_FALSE(none);
  EXPECT_EQ(none.GetError().code, ErrorCode::NotFound);
  const auto directory = ReadWholeFile(folder.Path);
  ASSERT_FALSE(directory);
  EXPECT_EQ(directory.GetError().code, ErrorCode::InputOutput);
  EXPECT_TRUE(ReadWholeFile(folder / "a", Links::Follow, bytes.size()));
  // A device without an end.
  const auto endless = ReadWholeFile("/dev/zero");
  ASSERT_FALSE(endless);
  EXPECT_EQ(endless.GetError().code, ErrorCode::LimitExceeded);
  const auto large = ReadWholeFile(folder / "a", Links::Follow, bytes.size() - 1);
  ASSERT_FALSE(large);
  EXPECT_EQ(large.GetError().code, ErrorCode::LimitExceeded);
}
