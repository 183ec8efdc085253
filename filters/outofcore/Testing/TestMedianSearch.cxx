// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/HardPoints.h"
#include "filters/baselines/stores/Baselines.h"
#include "filters/outofcore/Testing/SpillTools.h"
#include "filters/outofcore/tree/MedianSearch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

using namespace kdstream;
using kdstream::testing::MakeSpillFolder;
using namespace kdstream::fixtures;

namespace
{

const char* const allMethods[] = { "histogram", "heaps", "torben", "sort" };

// Keys in memory, passed on in small blocks, to three slots in turn.
class KeysInMemory : public KeySource
{
public:
  explicit KeysInMemory(const std::vector<Vec3>& points)
  {
    for (std::size_t i = 0; i < points.size(); ++i)
    {
      this->Keys.push_back({ OrderedBits(points[i][0]), i });
    }
  }

  std::size_t Slots() const override { return 3; }
  Status Pass(const Filter& filter, const Take& take) override
  {
    ++this->Passes;
    constexpr std::size_t block = 100;
    for (std::size_t begin = 0; begin < this->Keys.size(); begin += block)
    {
      std::vector<OrderKey> some(this->Keys.begin() + std::ptrdiff_t(begin),
        this->Keys.begin() + std::ptrdiff_t(std::min(this->Keys.size(), begin + block)));
      some.resize(filter(begin / block % 3, some));
      KDSTREAM_TRY(take(some));
    }
    return this->GoOn();
  }
  Status OwnPass() override
  {
    ++this->Passes;
    return {};
  }
  Status GoOn() const override
  {
    return this->Passes <= this->MostPasses ? Status{} : Error{ ErrorCode::Cancelled, "cancelled" };
  }

  std::vector<OrderKey> Keys;
  std::uint64_t Passes = 0;
  std::uint64_t MostPasses = ~std::uint64_t{ 0 };
};

MedianSearch SearchOf(const KeysInMemory& keys, std::uint64_t rank, std::uint64_t memory)
{
  const auto [least, greatest] = std::minmax_element(keys.Keys.begin(), keys.Keys.end());
  MedianSearch search;
  search.rank = rank;
  search.known = { { least->coordinate, 0 }, { greatest->coordinate, greatestId }, 0,
    keys.Keys.size() };
  for (const OrderKey& key : keys.Keys)
  {
    search.mean += ValueOfOrderedBits(key.coordinate) / double(keys.Keys.size());
  }
  search.memory = memory;
  return search;
}

}

TEST(MedianSearch, OrderedBitsAreInTheOrderOfDoubles)
{
  const double inOrder[] = { -INFINITY, -1e300, -1.5, -1, -5e-324, 0, 5e-324, 1, 1.5, 1e300,
    INFINITY };
  for (std::size_t i = 1; i < std::size(inOrder); ++i)
  {
    EXPECT_LT(OrderedBits(inOrder[i - 1]), OrderedBits(inOrder[i]));
    EXPECT_EQ(ValueOfOrderedBits(OrderedBits(inOrder[i])), inOrder[i]);
  }
  EXPECT_EQ(OrderedBits(0.0), OrderedBits(-0.0));
}

TEST(MedianSearch, EveryMethodFindsEveryRankOfHardInput)
{
  SpillFolder folder = MakeSpillFolder();
  for (const HardPoints& hard : AllHardPoints({ 1, 2, 3, 64, 1500 }))
  {
    KeysInMemory keys(hard.points);
    std::vector<OrderKey> sorted = keys.Keys;
    std::sort(sorted.begin(), sorted.end());
    const std::uint64_t n = sorted.size();
    for (const char* name : allMethods)
    {
      const MedianMethod method = MedianMethodOfName(name);
      for (const std::uint64_t memory : { 64U, 800U, 100000U })
      {
        for (const std::uint64_t rank : { n / 2, std::uint64_t{ 0 }, n - 1, n / 10 })
        {
          SCOPED_TRACE(hard.name + ", " + std::to_string(n) + ", rank " + std::to_string(rank) +
                       ", memory " + std::to_string(memory) + ", " + name);
          const auto range = method(keys, SearchOf(keys, rank, memory), folder);
          ASSERT_TRUE(range);
          ASSERT_EQ(range->below, rank);
          ASSERT_EQ(range->inside, 1U);
          ASSERT_TRUE(range->first <= sorted[rank] && sorted[rank] <= range->last);
        }
      }
    }
  }
  EXPECT_EQ(folder.Counts().bytesOnDisk, 0U);
}

TEST(MedianSearch, HistogramEndsWhereTheRangeCanBeKept)
{
  SpillFolder folder = MakeSpillFolder();
  for (const HardPoints& hard : AllHardPoints({ 3000 }))
  {
    SCOPED_TRACE(hard.name);
    KeysInMemory keys(hard.points);
    std::vector<OrderKey> sorted = keys.Keys;
    std::sort(sorted.begin(), sorted.end());
    MedianSearch search = SearchOf(keys, 1500, 4096);
    search.keepable = 200;
    const auto range = FindMedianByHistogram(keys, search, folder);
    ASSERT_TRUE(range);
    EXPECT_LE(range->inside, 200U);
    EXPECT_LE(range->below, 1500U);
    EXPECT_GT(range->below + range->inside, 1500U);
    for (std::size_t i = 0; i < sorted.size(); ++i)
    {
      const bool inside = i >= range->below && i < range->below + range->inside;
      ASSERT_EQ(inside, range->first <= sorted[i] && sorted[i] <= range->last) << i;
    }
  }
}

TEST(MedianSearch, PassesAreAsFewAsTheHeaderSays)
{
  SpillFolder folder = MakeSpillFolder();
  for (const HardPoints& hard : AllHardPoints({ 10000 }))
  {
    SCOPED_TRACE(hard.name);
    const auto passes = [&](MedianMethod method, std::uint64_t memory, double share)
    {
      KeysInMemory keys(hard.points);
      MedianSearch search = SearchOf(keys, 5000, memory);
      search.heapShare = share;
      EXPECT_TRUE(method(keys, search, folder));
      return keys.Passes;
    };
    const std::uint64_t plenty = 1 << 20;
    EXPECT_LE(passes(FindMedianByHistogram, plenty, 0), 6U);
    EXPECT_EQ(passes(FindMedianByHeaps, plenty, 0), 1U);
    EXPECT_LE(passes(FindMedianByHeaps, plenty, 0.1), 20U);
    EXPECT_LE(passes(FindMedianByTorben, plenty, 0), 2100U);
    EXPECT_EQ(passes(FindMedianBySort, plenty, 0), 2U);
    // Runs of 256 keys, merged seven at a time: first 40 runs, then 6.
    EXPECT_EQ(passes(FindMedianBySort, 4096, 0), 3U);
  }
}

TEST(MedianSearch, StopsWhenCancelled)
{
  SpillFolder folder = MakeSpillFolder();
  const HardPoints hard = AllHardPoints({ 10000 }).front();
  for (const char* name : allMethods)
  {
    const MedianMethod method = MedianMethodOfName(name);
    KeysInMemory keys(hard.points);
    keys.MostPasses = 0;
    const auto range = method(keys, SearchOf(keys, 5000, 4096), folder);
    ASSERT_FALSE(range);
    EXPECT_EQ(range.GetError().code, ErrorCode::Cancelled);
    EXPECT_EQ(folder.Counts().bytesOnDisk, 0U);
  }
}

TEST(MedianSearch, MethodsHaveNames)
{
  EXPECT_EQ(MedianMethodOfName("auto"), FindMedianByHistogram);
  EXPECT_EQ(MedianMethodOfName("histogram"), FindMedianByHistogram);
  EXPECT_EQ(MedianMethodOfName("heaps"), FindMedianByHeaps);
  EXPECT_EQ(MedianMethodOfName("torben"), FindMedianByTorben);
  EXPECT_EQ(MedianMethodOfName("sort"), FindMedianBySort);
  EXPECT_FALSE(MedianMethodOfName("mean"));
}
