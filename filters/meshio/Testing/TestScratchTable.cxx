// SPDX-License-Identifier: BSD-3-Clause
// ScratchTable: records come back as they were written, in any order of access.
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/meshio/ScratchTable.h"
#include "filters/meshio/Testing/RandomGenerator.h"

#include <gtest/gtest.h>

namespace kdstream::test
{

namespace
{

struct Record
{
  std::uint64_t number = 0;
  std::uint32_t twice = 0;
};

}

TEST(ScratchTable, HoldsWhatIsPutThere)
{
  const fixtures::TemporaryFolder folder;
  for (unsigned seed = 0; seed < 3; ++seed)
  {
    RandomGenerator generator(seed);
    ScratchTable<Record> table(folder / "");
    // Up to five times as many records as stay in memory.
    std::vector<std::uint64_t> expected;
    for (std::uint64_t i = 0, count = 1 + generator.Pick(600000); i < count; ++i)
    {
      expected.push_back(i + 1);
      ASSERT_TRUE(table.Append({ i + 1, std::uint32_t(2 * i) }));
      if (generator.Chance(0.2))
      {
        const std::uint64_t at = generator.Pick(expected.size());
        const Result<Record> record = table.Get(at);
        ASSERT_TRUE(record);
        ASSERT_EQ(record->number, expected[at]);
        expected[at] = generator.Pick(1000);
        ASSERT_TRUE(table.Set(at, { expected[at], record->twice }));
      }
    }
    ASSERT_EQ(table.Size(), expected.size());
    for (std::uint64_t i = 0; i < expected.size(); ++i)
    {
      const Result<Record> record = table.Get(i);
      ASSERT_TRUE(record);
      ASSERT_EQ(record->number, expected[i]);
      ASSERT_EQ(record->twice, std::uint32_t(2 * i));
    }
    EXPECT_EQ(table.Get(expected.size() + 5)->number, 0U);
  }
  EXPECT_EQ(folder.Names().size(), 0U);
}

}
