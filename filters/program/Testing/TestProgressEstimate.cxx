// SPDX-License-Identifier: BSD-3-Clause
// Rates and remaining times are reported once they can be known, and are then right.
#include "filters/program/ProgressEstimate.h"

#include <gtest/gtest.h>

using namespace kdstream;

namespace
{

std::vector<StepShare> Shares()
{
  return { { "read", 0.1 }, { "levels", 0.5 }, { "encode", 0.4 } };
}

}

TEST(ProgressEstimate, EstimatesNothingBeforeThereIsEnough)
{
  ProgressEstimate estimate;
  estimate.Add("levels", 0.1, 100);
  EXPECT_FALSE(estimate.Rate()) << "a step that begins with some done";
  EXPECT_FALSE(estimate.Left());
  estimate.Add("levels", 0.4, 100.2);
  EXPECT_FALSE(estimate.Rate()) << "a moment";
  EXPECT_FALSE(estimate.Left());
  estimate.Add("levels", 0.401, 102);
  EXPECT_TRUE(estimate.Rate());
  estimate.Add("encode", 0, 200);
  estimate.Add("encode", 0.01, 260);
  EXPECT_FALSE(estimate.Rate()) << "hardly anything is done";
  EXPECT_FALSE(estimate.Left());
}

TEST(ProgressEstimate, MeasuresAStepFromWhereItBegan)
{
  ProgressEstimate estimate;
  estimate.Add("read", 1, 5);
  estimate.Add("encode", 0.42, 10);
  estimate.Add("encode", 0.52, 12);
  ASSERT_TRUE(estimate.Rate());
  EXPECT_NEAR(*estimate.Rate(), 0.05, 1e-12);
  ASSERT_TRUE(estimate.Left());
  EXPECT_NEAR(estimate.Left()->seconds, 0.48 / 0.05, 1e-9);
  EXPECT_FALSE(estimate.Left()->whole);
  // The step begins again, as when a build in memory is replaced by one out of core.
  estimate.Add("encode", 0, 13);
  EXPECT_FALSE(estimate.Rate());
  estimate.Add("encode", 0.5, 18);
  EXPECT_NEAR(*estimate.Rate(), 0.1, 1e-12);
}

TEST(ProgressEstimate, EstimatesTheTimeOfAllStepsByTheirShares)
{
  ProgressEstimate estimate(Shares());
  estimate.Add("read", 0, 0);
  estimate.Add("read", 0.4, 10);
  EXPECT_FALSE(estimate.Left()) << "4 % of the whole";
  estimate.Add("levels", 0, 20);
  estimate.Add("levels", 0.2, 40); // 20 % of the whole
  ASSERT_TRUE(estimate.Left());
  EXPECT_TRUE(estimate.Left()->whole);
  EXPECT_NEAR(estimate.Left()->seconds, 160, 1e-9);
  EXPECT_NEAR(*estimate.Rate(), 0.01, 1e-12);
  estimate.Add("encode", 1, 100);
  EXPECT_FALSE(estimate.Left()) << "done";
}

TEST(ProgressEstimate, MeasuresTheWholeFromWhereItBegan)
{
  ProgressEstimate resumed(Shares());
  resumed.Add("levels", 0.8, 0); // 50 %
  resumed.Add("encode", 0, 1);   // 60 %
  EXPECT_FALSE(resumed.Left()) << "a moment";
  resumed.Add("encode", 0.25, 10); // 70 %
  ASSERT_TRUE(resumed.Left());
  EXPECT_NEAR(resumed.Left()->seconds, 15, 1e-9);

  ProgressEstimate converted(Shares());
  converted.Add("convert", 0, 0);
  converted.Add("convert", 0.5, 100);
  ASSERT_TRUE(converted.Left());
  EXPECT_FALSE(converted.Left()->whole);
  converted.Add("read", 0, 200);
  converted.Add("levels", 0.8, 210); // 50 %
  EXPECT_NEAR(converted.Left()->seconds, 10, 1e-9) << "the time before is of something else";
}
