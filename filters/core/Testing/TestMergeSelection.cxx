// SPDX-License-Identifier: BSD-3-Clause
// Finding the cheapest of many errors in passes, compared with sorting.
#include "filters/core/collapse/MergeSelection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

namespace kdstream
{
namespace
{

// Errors of several kinds: spread over many magnitudes, close together, and equal.
std::vector<double> Errors(std::mt19937_64& random, std::size_t count, unsigned kind)
{
  std::vector<double> errors(count);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (double& error : errors)
  {
    const double x = uniform(random);
    error = kind == 0   ? x * x * x * x * 1e-9
            : kind == 1 ? 1 + x * 1e-12
            : kind == 2 ? (x < 0.3    ? 0.0
                            : x < 0.4 ? -0.0
                                      : 0.25)
                        : static_cast<double>(static_cast<int>(x * 40));
  }
  return errors;
}

struct Outcome
{
  CheapestErrors cheapest;
  std::size_t passes = 0;
};

Outcome Find(const std::vector<double>& errors, std::uint64_t count)
{
  Outcome outcome;
  const Result<CheapestErrors> found = FindCheapest(
    [&](const auto& visit) -> Status
    {
      ++outcome.passes;
      std::for_each(errors.begin(), errors.end(), visit);
      return {};
    },
    count);
  EXPECT_TRUE(found);
  outcome.cheapest = *found;
  return outcome;
}

void ExpectAsSorted(const std::vector<double>& errors, std::uint64_t count)
{
  std::vector<double> sorted = errors;
  std::sort(sorted.begin(), sorted.end());
  const double last = sorted[count - 1];
  const auto below = static_cast<std::uint64_t>(
    std::lower_bound(sorted.begin(), sorted.end(), last) - sorted.begin());
  const Outcome outcome = Find(errors, count);
  EXPECT_EQ(outcome.cheapest.error, last) << count << " of " << errors.size();
  EXPECT_EQ(outcome.cheapest.ties, count - below) << count << " of " << errors.size();
}

TEST(MergeSelection, IsThatOfSorting)
{
  std::mt19937_64 random(20);
  for (unsigned kind = 0; kind < 4; ++kind)
  {
    for (const std::size_t size : { std::size_t{ 1 }, std::size_t{ 2 }, std::size_t{ 1000 },
           std::size_t{ 70000 }, std::size_t{ 200000 } })
    {
      const std::vector<double> errors = Errors(random, size, kind);
      for (const std::uint64_t count :
        { std::uint64_t{ 1 }, std::uint64_t{ size / 3 + 1 }, std::uint64_t{ size } })
      {
        ExpectAsSorted(errors, count);
      }
    }
  }
}

TEST(MergeSelection, TakesTwoPassesUnlessVeryManyAreNearlyEqual)
{
  std::mt19937_64 random(21);
  EXPECT_EQ(Find(Errors(random, 100000, 0), 30000).passes, 2U);
  EXPECT_EQ(Find(Errors(random, 200000, 1), 70000).passes, 4U);
}

}
}
