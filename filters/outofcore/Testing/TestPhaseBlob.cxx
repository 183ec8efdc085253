// SPDX-License-Identifier: BSD-3-Clause
// The values that a finished phase keeps beside its files can be read again; damaged ones are
// refused.
#include "Testing/Fixtures/ErrorAt.h"
#include "filters/outofcore/Testing/BuildFolders.h"
#include "filters/outofcore/files/BucketFile.h"

using namespace kdstream;
using namespace kdstream::testing;

namespace
{

class TestPhaseBlob : public BuildFolderTest
{
};

}

TEST_F(TestPhaseBlob, BucketsComeBack)
{
  constexpr std::size_t buckets = 5;
  BlobWriter blob;
  BuildFolder folder = this->Open(false);
  auto made = std::move(
    *RecordBuckets<std::uint64_t>::Create(folder.Files(), "numbers", buckets, numberCount, 300));
  for (std::uint64_t i = 0; i < numberCount; ++i)
  {
    ASSERT_TRUE(made.Add(i * i % (buckets - 1), i)); // the last one stays empty
  }
  ASSERT_TRUE(made.Finish());
  PhaseFile files[] = { { "buckets", made.Save(blob) } };
  ASSERT_TRUE(folder.Finish("buckets", blob, files));

  BlobReader reader = folder.BlobOf("buckets");
  const auto back = RecordBuckets<std::uint64_t>::Restore(
    std::move(*folder.TakeFile("buckets", "buckets")), reader);
  ASSERT_TRUE(back);
  EXPECT_TRUE(reader.Finish());
  ASSERT_EQ(back->BucketCount(), buckets);
  std::size_t found = 0;
  for (std::size_t b = 0; b < buckets; ++b)
  {
    std::uint64_t next = 0;
    EXPECT_TRUE(back->ForEach(b,
      [&](std::uint64_t i) -> Status
      {
        EXPECT_EQ(i * i % (buckets - 1), b);
        EXPECT_GE(i, next);
        next = i + 1;
        ++found;
        return {};
      }));
  }
  EXPECT_EQ(found, numberCount);

  const std::vector<std::byte>& whole = blob.Bytes();
  for (std::size_t length = 0; length < whole.size(); ++length)
  {
    BlobReader shorter(std::span<const std::byte>(whole).first(length));
    EXPECT_FALSE(RecordBuckets<std::uint64_t>::Restore(
      std::move(*folder.TakeFile("buckets", "buckets")), shorter));
  }
  // Damaged numbers: of records in a block, and of records in the file.
  for (const std::size_t place : { 0U, 16U })
  {
    std::vector<std::byte> wrong = whole;
    wrong[place + 1] = std::byte{ 77 };
    BlobReader damaged(wrong);
    EXPECT_FALSE(RecordBuckets<std::uint64_t>::Restore(
      std::move(*folder.TakeFile("buckets", "buckets")), damaged));
  }
}

TEST_F(TestPhaseBlob, ReportsWhatIsMissing)
{
  BlobWriter writer;
  writer.Add(std::uint64_t{ 1 } << 61); // would be the length of a list
  writer.Add(7.5F);
  const std::vector<std::byte> bytes = writer.Bytes();
  BlobReader list(bytes);
  EXPECT_TRUE(list.ReadList<double>().empty());
  EXPECT_FALSE(list.Good());
  EXPECT_EQ(list.Read<float>(), 0) << "nothing is read after an error";
  EXPECT_TRUE(fixtures::FailsAt(list.Finish(), ErrorCode::Damaged));
  BlobReader left(bytes);
  EXPECT_EQ(left.Read<std::uint64_t>(), std::uint64_t{ 1 } << 61);
  EXPECT_TRUE(fixtures::FailsAt(left.Finish(), ErrorCode::Damaged));
  EXPECT_EQ(left.Read<float>(), 7.5F);
  EXPECT_TRUE(left.Finish());
}
