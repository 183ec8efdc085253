// SPDX-License-Identifier: BSD-3-Clause
// GeometricErrorList gives the same figures as sorting all errors, however many are in a file.
#include "filters/store/GeometricErrorList.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

using namespace kdstream;
namespace fs = std::filesystem;

namespace
{

std::vector<float> Some(std::size_t count, unsigned kind, std::uint32_t seed)
{
  std::mt19937 random(seed);
  std::vector<float> values(count);
  for (float& value : values)
  {
    const auto any = static_cast<float>(random());
    value = kind == 0            ? any / 4294967296.0F              // all different
            : kind == 1          ? static_cast<float>(random() % 3) // most of them equal
            : random() % 50 == 0 ? any * any * any * any * 1e-3F    // spikes, some infinite
                                 : any * 1e-42F;                    // down to the smallest numbers
  }
  return values;
}

GeometricErrorList::Summary Sorted(std::vector<float> values)
{
  std::sort(values.begin(), values.end());
  return { values[(values.size() - 1) * 99 / 100], values.back() };
}

}

TEST(GeometricErrorList, IsSortingThemAll)
{
  for (const std::size_t count : { 1, 2, 99, 100, 101, 102, 200, 201, 1000, 70001 })
  {
    for (const unsigned kind : { 0U, 1U, 2U })
    {
      for (const std::size_t inMemory : { 1, 7, 100, 4096, 1 << 20 })
      {
        if (count / inMemory > 10000)
        {
          continue; // would make a system call for each error
        }
        SCOPED_TRACE(std::to_string(count) + " of kind " + std::to_string(kind) + ", " +
                     std::to_string(inMemory) + " in memory");
        GeometricErrorList list(fs::temp_directory_path(), inMemory);
        std::mt19937 random(5);
        for (std::uint32_t seed = 1; seed <= 3; ++seed) // several rounds with the same list
        {
          const std::vector<float> values = Some(count, kind, seed);
          for (std::size_t at = 0; at < count;)
          {
            const std::size_t part = std::min<std::size_t>(count - at, random() % 300);
            ASSERT_TRUE(list.Add(std::span(values).subspan(at, part)));
            at += part;
          }
          const auto found = list.Finish();
          ASSERT_TRUE(found) << found.GetError().message;
          const GeometricErrorList::Summary expected = Sorted(values);
          ASSERT_EQ(found->at99, expected.at99);
          ASSERT_EQ(found->largest, expected.largest);
        }
      }
    }
  }
}

TEST(GeometricErrorList, NoneIsZero)
{
  GeometricErrorList list(fs::temp_directory_path());
  const auto found = list.Finish();
  ASSERT_TRUE(found);
  EXPECT_EQ(found->at99, 0.0F);
  EXPECT_EQ(found->largest, 0.0F);
}

TEST(GeometricErrorList, AFolderThatIsNotThereIsNamed)
{
  GeometricErrorList list("/proc/nowhere", 2);
  EXPECT_TRUE(list.Add(std::vector<float>{ 1, 2 }));
  const Status status = list.Add(std::vector<float>{ 3 });
  ASSERT_FALSE(status);
  EXPECT_EQ(status.GetError().code, ErrorCode::InputOutput);
  EXPECT_NE(status.GetError().message.find("/proc/nowhere"), std::string::npos);
}
