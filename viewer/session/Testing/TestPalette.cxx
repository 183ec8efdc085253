// SPDX-License-Identifier: BSD-3-Clause
#include "viewer/session/appearance/Palette.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <set>

namespace kdstream
{
namespace
{

int Distance(const Color& a, const Color& b)
{
  return std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]);
}

TEST(Palette, GivesPartitionsDifferentColors)
{
  std::set<Color> colors;
  for (std::uint32_t partition = 0; partition < 256; ++partition)
  {
    colors.insert(PartitionColor(partition));
    EXPECT_GT(Distance(PartitionColor(partition), PartitionColor(partition + 1)), 60) << partition;
  }
  EXPECT_GT(colors.size(), 250u);
}

TEST(Palette, TakesAnyPartition)
{
  const Color color = PartitionColor(0xffffffffu);
  EXPECT_GT(*std::max_element(color.begin(), color.end()), 100);
}

TEST(Palette, TellsResolutionsApart)
{
  for (unsigned depth = 0; depth < Resolution::maximumLevel; ++depth)
  {
    const Color color = ResolutionColor(Resolution::Level(depth));
    EXPECT_GT(Distance(color, ResolutionColor(Resolution::Level(depth + 1))), 30) << depth;
    EXPECT_GT(Distance(color, ResolutionColor(Resolution::Original())), 30) << depth;
  }
}

}
}
