// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/Eventually.h"
#include "server/session/BlobCache.h"

#include <gtest/gtest.h>

#include <atomic>
#include <new>
#include <vector>

using namespace kdstream;
using protocol::BlobId;

namespace
{

class Cache : public testing::Test
{
protected:
  BlobCache cache{ 1000 };
  BlobCache::Model model = this->cache.AddModel();
  std::atomic<std::size_t> reads{ 0 };

  // A blob of this size, each byte of which is `number`.
  BlobBytes Get(std::uint32_t number, std::size_t bytes = 100)
  {
    const auto blob = this->cache.Get(this->model, BlobId::Partition(number),
      [&]() -> Result<BlobBytes>
      {
        ++this->reads;
        return std::make_shared<const std::vector<std::uint8_t>>(
          bytes, static_cast<std::uint8_t>(number));
      });
    EXPECT_TRUE(blob);
    EXPECT_EQ((*blob)->at(0), number);
    return *blob;
  }
};

}

TEST_F(Cache, WhatWasAskedForLastIsKept)
{
  for (std::uint32_t number = 0; number < 10; ++number)
  {
    this->Get(number);
  }
  EXPECT_EQ(this->cache.Use().bytes, 1000u);
  this->Get(0);
  EXPECT_EQ(this->reads, 10u);
  this->Get(10); // replaces 1, which is now the oldest
  EXPECT_EQ(this->cache.Use().bytes, 1000u);
  this->Get(0);
  this->Get(2);
  EXPECT_EQ(this->reads, 11u);
  EXPECT_FALSE(this->cache.Find(this->model, BlobId::Partition(1)));
  this->Get(1);
  EXPECT_EQ(this->reads, 12u);
  EXPECT_EQ(this->cache.Use().misses, 12u);
  EXPECT_EQ(this->cache.Use().hits, 3u);
}

TEST_F(Cache, WhatSomebodyHoldsIsFoundThoughItIsNotKept)
{
  const auto held = this->Get(0, 5000); // larger than the whole cache
  EXPECT_EQ(this->cache.Use().bytes, 0u);
  EXPECT_EQ(this->Get(0), held);
  EXPECT_EQ(this->reads, 1u);
  for (std::uint32_t number = 1; number < 200; ++number)
  {
    this->Get(number, 999);
  }
  EXPECT_EQ(this->cache.Find(this->model, BlobId::Partition(0)), held);
}

// A disk may block the thread that reads, so nobody waits for it.
TEST_F(Cache, NobodyWaitsForWhoeverReadsTheSame)
{
  BlobBytes second;
  const auto first = this->cache.Get(this->model, BlobId::Partition(7),
    [&]() -> Result<BlobBytes>
    {
      second = this->Get(7); // another read of the same blob
      return std::make_shared<const std::vector<std::uint8_t>>(100, 7);
    });
  ASSERT_TRUE(first);
  EXPECT_EQ(this->reads, 1u);
  EXPECT_EQ(*first, second) << "the blob is in memory once";
  EXPECT_EQ(this->cache.Use().bytes, 100u);
}

TEST_F(Cache, FailuresAreNotKept)
{
  const BlobId id = BlobId::Partition(3);
  const auto failed = this->cache.Get(this->model, id,
    []() -> Result<BlobBytes> {
      return Error{ ErrorCode::InputOutput, "not now" };
    });
  EXPECT_FALSE(failed);
  EXPECT_THROW(
    (void)this->cache.Get(this->model, id, []() -> Result<BlobBytes> { throw std::bad_alloc(); }),
    std::bad_alloc);
  this->Get(3);
  EXPECT_EQ(this->reads, 1u);
}

TEST_F(Cache, ModelsAreApartAndForgotten)
{
  const auto other = this->cache.AddModel();
  const auto mine = this->Get(1);
  EXPECT_FALSE(this->cache.Find(other, BlobId::Partition(1)));
  this->cache.RemoveModel(other);
  EXPECT_TRUE(this->cache.Find(this->model, BlobId::Partition(1)));
  this->cache.RemoveModel(this->model);
  EXPECT_FALSE(this->cache.Find(this->model, BlobId::Partition(1)));
  EXPECT_EQ(this->cache.Use().bytes, 0u);
}
