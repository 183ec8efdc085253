// SPDX-License-Identifier: BSD-3-Clause
// GeometricErrorBins finds an error a little below the one that sorting finds, and the same error
// if counted in parts.
#include "filters/core/levels/GeometricErrorBins.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

using namespace kdstream;

TEST(GeometricErrorBins, AreALittleBelowWhatSortingFinds)
{
  std::mt19937 random(3);
  for (std::size_t count : { 1, 2, 99, 100, 101, 5000 })
  {
    GeometricErrorBins whole, first, second;
    std::vector<double> geometricErrors;
    for (std::size_t i = 0; i < count; ++i)
    {
      const double geometricError =
        std::ldexp(double(random()) / 4294967296.0, static_cast<int>(random() % 200) - 100);
      geometricErrors.push_back(geometricError);
      whole.Add(geometricError);
      (i % 3 == 0 ? first : second).Add(geometricError);
    }
    std::sort(geometricErrors.begin(), geometricErrors.end());
    const double exact = geometricErrors[(count - 1) * 99 / 100];
    EXPECT_LE(whole.Most99(), exact * (1 + 1e-7)) << count; // counted as floats
    EXPECT_GE(whole.Most99(), exact * (1 - 1.0 / 32)) << count;
    for (std::size_t i = 0; i < first.Counts().size(); ++i)
    {
      first.Counts()[i] += second.Counts()[i];
    }
    EXPECT_EQ(first.Most99(), whole.Most99());
  }
}

TEST(GeometricErrorBins, TakeNothingZeroAndTheGreatest)
{
  GeometricErrorBins bins;
  EXPECT_EQ(bins.Most99(), 0);
  bins.Add(0);
  bins.Add(-0.0);
  EXPECT_EQ(bins.Most99(), 0);
  GeometricErrorBins greatest;
  greatest.Add(std::numeric_limits<double>::max());
  EXPECT_GT(greatest.Most99(), 1e38);
  EXPECT_TRUE(std::isfinite(greatest.Most99()));
}
