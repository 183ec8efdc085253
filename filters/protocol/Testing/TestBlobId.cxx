// SPDX-License-Identifier: BSD-3-Clause
#include "filters/protocol/Testing/RandomMessages.h"

#include <gtest/gtest.h>

using namespace kdstream;
using namespace kdstream::protocol;

TEST(TestBlobId, NamesAreAsDocumented)
{
  EXPECT_EQ(BlobName(BlobId::TreePage(1)), "tree/1");
  EXPECT_EQ(BlobName(BlobId::PartitionBoxes(9)), "boxes/9");
  EXPECT_EQ(BlobName(BlobId::LevelPiece(7, 1)), "levels/7/1");
  EXPECT_EQ(BlobName(BlobId::Partition(0)), "partitions/0");
  EXPECT_EQ(BlobName(BlobId::Texture(7)), "textures/7");
  EXPECT_EQ(BlobName(BlobId::LevelTexture(7, 1)), "level-textures/7/1");
}

TEST(TestBlobId, EveryValidNameComesBack)
{
  RandomMessages random(1);
  for (int i = 0; i < 2000; ++i)
  {
    const auto blob = random.Blob();
    ASSERT_TRUE(IsValid(blob));
    const auto parsed = ParseBlobName(BlobName(blob));
    ASSERT_TRUE(parsed) << BlobName(blob);
    EXPECT_EQ(*parsed, blob);
  }
}

TEST(TestBlobId, RefusesWhatIsNotABlob)
{
  for (const char* name :
    { "", "/", "tree", "tree/", "tree//1", "tree/1/", "/tree/1", "trees/1", "levels/7",
      "levels/7/1/1", "textures/7/1", "level-textures/7/1/1", "partitions", "Tree/1" })
  {
    const auto blob = ParseBlobName(name);
    EXPECT_FALSE(blob) << name;
  }
}

TEST(TestBlobId, RefusesNumbersOutOfRangeOrInDisguise)
{
  for (const char* name : { "tree/0", "tree/01", "tree/+1", "tree/-1", "tree/ 1", "tree/1 ",
         "tree/0x1", "tree/1e1", "tree/2147483648", "tree/4294967297", "tree/18446744073709551617",
         "tree/99999999999999999999999999", "tree/%31", "tree/1.0", "levels/31/1", "levels/07/1",
         "levels/7/0", "levels//1", "levels/256/1", "partitions/1073741824", "partitions/00",
         "partitions/-0", "partitions/", "textures/1073741824", "textures/x", "level-textures/31/1",
         "level-textures/7/0", "boxes/0", "boxes/2147483648" })
  {
    const auto blob = ParseBlobName(name);
    ASSERT_FALSE(blob) << name;
    EXPECT_EQ(blob.GetError().code, ErrorCode::InvalidArgument) << name;
  }
  EXPECT_TRUE(ParseBlobName("tree/2147483647"));
  EXPECT_TRUE(ParseBlobName("partitions/1073741823"));
  EXPECT_TRUE(ParseBlobName("textures/1073741823"));
  EXPECT_TRUE(ParseBlobName("levels/30/1"));
}

TEST(TestBlobId, MessagesHoldNoControlCharacters)
{
  const auto blob = ParseBlobName(std::string("tree/\r\nSet-Cookie: x") + std::string(5000, 'y'));
  ASSERT_FALSE(blob);
  EXPECT_EQ(blob.GetError().message.find('\n'), std::string::npos);
  EXPECT_LT(blob.GetError().message.size(), 200u);
}
