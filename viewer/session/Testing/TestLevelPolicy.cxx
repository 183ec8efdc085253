// SPDX-License-Identifier: BSD-3-Clause
// The level of detail for a zoom: its error is small enough on the screen, finer zoom never gives a
// coarser level, and nothing flickers.
#include "viewer/session/model/LevelPolicy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

using kdstream::LevelFacts;
using kdstream::LevelPolicy;
using kdstream::LevelPolicyOptions;

namespace
{

// Levels 0 … finest; each has half the error of the next coarser one, and twice its triangles.
std::vector<LevelFacts> Halving(unsigned finest)
{
  std::vector<LevelFacts> levels;
  for (unsigned d = 0; d <= finest; ++d)
  {
    levels.push_back({ 1.0 / static_cast<double>(1u << d), 2u << d });
  }
  return levels;
}

LevelPolicyOptions Strict()
{
  return { 1, 1.25, 1u << 30 };
}

TEST(TestLevelPolicy, ChoosesTheCoarsestThatIsFineEnough)
{
  const LevelPolicy policy(Halving(16), Strict());
  EXPECT_EQ(policy.PreviewLevel(), 11u);
  EXPECT_EQ(policy.Choose(1), 11u);    // never coarser than the preview
  EXPECT_EQ(policy.Choose(2048), 11u); // 2^-11 * 2048 = 1 point
  EXPECT_EQ(policy.Choose(2049), 12u);
  EXPECT_EQ(policy.Choose(1 << 15), 15u);
  EXPECT_EQ(policy.Choose(1e9), 16u); // the finest, as none is fine enough
  EXPECT_EQ(LevelPolicy(Halving(3)).PreviewLevel(), 3u);
  EXPECT_EQ(LevelPolicy(Halving(0)).Choose(1e9), 0u);
}

TEST(TestLevelPolicy, KeepsToTheTriangleBudget)
{
  LevelPolicyOptions options = Strict();
  options.triangleBudget = 2u << 14;
  EXPECT_EQ(LevelPolicy(Halving(16), options).Choose(1e9), 14u);
  options.triangleBudget = 1; // the preview is always allowed
  EXPECT_EQ(LevelPolicy(Halving(16), options).Choose(1e9), 11u);
}

TEST(TestLevelPolicy, IsMonotoneInZoomWhateverTheGeometricErrors)
{
  std::mt19937 random(11);
  for (int trial = 0; trial < 200; ++trial)
  {
    std::vector<LevelFacts> levels(1 + random() % 25);
    for (LevelFacts& level : levels)
    {
      level = { static_cast<double>(random() % 1000) / 1000, random() % 3'000'000 };
    }
    const LevelPolicy policy(levels);
    unsigned last = 0;
    for (double scale = 0.01; scale < 1e6; scale *= 1.07)
    {
      const unsigned level = policy.Choose(scale);
      EXPECT_GE(level, last);
      EXPECT_GE(level, policy.PreviewLevel());
      EXPECT_LT(level, levels.size());
      last = level;
    }
  }
}

TEST(TestLevelPolicy, DoesNotFlickerAtABorder)
{
  const LevelPolicy policy(Halving(16), Strict());
  // Zooms to and fro by 20 % around the scale at which level 12 becomes 13.
  for (const unsigned start : { 12u, 13u })
  {
    unsigned level = start;
    for (int i = 0; i < 100; ++i)
    {
      level = policy.Choose(4096 * (i % 2 == 0 ? 0.9 : 1.1), level);
      EXPECT_EQ(level, start);
    }
  }
  // A larger zoom changes the level, in both directions.
  EXPECT_EQ(policy.Choose(4096 * 1.3, 12), 13u);
  EXPECT_EQ(policy.Choose(4096 / 1.3, 13), 12u);
  EXPECT_EQ(policy.Choose(1e9, 11), 16u);
  EXPECT_EQ(policy.Choose(1, 16), 11u);
}

TEST(TestLevelPolicy, WithHistoryChangesAtMostOnceOnTheWayThroughABorder)
{
  const LevelPolicy policy(Halving(16), Strict());
  unsigned level = 11, changes = 0;
  for (double scale = 3000; scale < 6000; scale *= 1.01)
  {
    const unsigned next = policy.Choose(scale, level);
    EXPECT_GE(next, level);
    changes += next != level ? 1 : 0;
    level = next;
  }
  EXPECT_EQ(level, 13u);
  EXPECT_EQ(changes, 2u);
}

}
