// SPDX-License-Identifier: BSD-3-Clause
// Tests readers with damaged files: makes seeded mutations of good files, and reads each one at
// once and in chunks.
#pragma once

#include "filters/meshio/Testing/RandomGenerator.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace kdstream::test
{

// Maker: RandomObjMaker, for example. read(bytes, limit) returns whether the file is a mesh. lines:
// see Mutate. largest: passed to Maker::Make.
template <class Maker, class Read>
void SurviveMutations(const Read& read, const std::vector<std::string>& lines, unsigned seeds = 200,
  std::uint64_t largest = 10)
{
  int accepted = 0;
  int refused = 0;
  for (unsigned seed = 0; seed < seeds; ++seed)
  {
    Maker maker(seed);
    RandomGenerator& generator = maker.Generator();
    const std::string good = maker.Make(1 + generator.Pick(largest)).bytes;
    ASSERT_TRUE(read(good, SIZE_MAX)) << "seed " << seed;
    for (int round = 0; round < 100; ++round)
    {
      std::string bytes = good;
      for (std::uint64_t count = 1 + generator.Pick(3); count > 0 && !bytes.empty(); --count)
      {
        Mutate(bytes, generator, lines);
      }
      const bool whole = read(bytes, SIZE_MAX);
      ASSERT_EQ(whole, read(bytes, 1 + generator.Pick(5)))
        << "seed " << seed << ", round " << round;
      ++(whole ? accepted : refused);
    }
  }
  EXPECT_GT(accepted, 1000) << "too few mutants are meshes: the promises were not tested";
  EXPECT_GT(refused, 1000) << "too few mutants are refused: the errors were not tested";
}

}
