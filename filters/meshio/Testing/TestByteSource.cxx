// SPDX-License-Identifier: BSD-3-Clause
// ByteSource: reads a file in blocks correctly, from any position.
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/meshio/ByteSource.h"

#include <gtest/gtest.h>

#include <random>

#include <sys/stat.h>

namespace kdstream::test
{

namespace
{

std::string RandomBytes(std::size_t size)
{
  std::mt19937_64 random(3);
  std::string bytes(size, '\0');
  for (char& byte : bytes)
  {
    byte = static_cast<char>(random());
  }
  return bytes;
}

}

TEST(ByteSource, GivesTheBytesOfTheFileWhateverTheSteps)
{
  const fixtures::TemporaryFolder folder;
  const std::string bytes = RandomBytes(5 * ByteSource::blockSize / 2);
  const auto file = folder.Write("bytes", bytes);
  std::mt19937_64 random(1);
  for (int round = 0; round < 20; ++round)
  {
    Result<ByteSource> opened = ByteSource::Open(file);
    ASSERT_TRUE(opened);
    ByteSource source = std::move(*opened);
    EXPECT_EQ(source.Size(), bytes.size());
    for (int step = 0; step < 200; ++step)
    {
      const std::size_t wanted = random() % (random() % 2 == 0 ? 100 : ByteSource::blockSize + 1);
      const Result<std::string_view> ahead = source.Peek(wanted);
      ASSERT_TRUE(ahead);
      const std::size_t at = static_cast<std::size_t>(source.Position());
      ASSERT_GE(ahead->size(), std::min(wanted, bytes.size() - at));
      ASSERT_EQ(*ahead, std::string_view(bytes).substr(at, ahead->size()));
      EXPECT_EQ(source.Remaining(), bytes.size() - at);
      if (random() % 10 == 0)
      {
        const std::uint64_t target = random() % (bytes.size() + 1);
        source.Seek(target);
        EXPECT_EQ(source.Position(), target);
      }
      else
      {
        source.Consume(random() % (ahead->size() + 1));
      }
    }
  }
}

TEST(ByteSource, EndsWithAFileThatIsCutOrGrowsWhileItIsRead)
{
  const fixtures::TemporaryFolder folder;
  const auto file = folder.Write("bytes", RandomBytes(ByteSource::blockSize + 1000));
  Result<ByteSource> cut = ByteSource::Open(file);
  Result<ByteSource> grown = ByteSource::Open(file);
  ASSERT_TRUE(cut && grown);
  std::filesystem::resize_file(file, 10);
  cut->Seek(4);
  EXPECT_EQ(cut->Peek(100)->size(), 6U);
  std::filesystem::resize_file(file, 3 * ByteSource::blockSize);
  grown->Seek(ByteSource::blockSize);
  EXPECT_EQ(grown->Peek(ByteSource::blockSize)->size(), 1000U);
  grown->Consume(1000);
  EXPECT_TRUE(grown->Peek(1)->empty());
  EXPECT_EQ(grown->Remaining(), 0U);
}

TEST(ByteSource, RefusesWhatIsNotARegularFile)
{
  const fixtures::TemporaryFolder folder;
  const Result<ByteSource> missing = ByteSource::Open(folder / "missing.ply");
  ASSERT_FALSE(missing);
  EXPECT_TRUE(fixtures::FailsAt(missing, ErrorCode::NotFound));

  const Result<ByteSource> directory = ByteSource::Open(folder / ".");
  ASSERT_FALSE(directory);
  EXPECT_TRUE(fixtures::FailsAt(directory, ErrorCode::InvalidInput));

  const auto pipe = folder / "pipe.ply";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const Result<ByteSource> fifo = ByteSource::Open(pipe);
  ASSERT_FALSE(fifo) << "and it does not wait for a writer";
  EXPECT_TRUE(fixtures::FailsAt(fifo, ErrorCode::InvalidInput));

  const Result<ByteSource> nameTooLong = ByteSource::Open(std::string(5000, 'x'));
  ASSERT_FALSE(nameTooLong);
  EXPECT_TRUE(fixtures::FailsAt(nameTooLong, ErrorCode::InputOutput));
}

}
