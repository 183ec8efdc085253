// SPDX-License-Identifier: BSD-3-Clause
// The content of a progress line; and that lines continue while nothing is reported.
#include "filters/program/ProgressReporter.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

using namespace kdstream;

TEST(ProgressReporter, DurationsAndAmountsAreShort)
{
  EXPECT_EQ(DurationText(0.4), "0 s");
  EXPECT_EQ(DurationText(119), "119 s");
  EXPECT_EQ(DurationText(200), "3 min 20 s");
  EXPECT_EQ(DurationText(7320), "2 h 2 min");
  EXPECT_EQ(BytesText(999), "999 B");
  EXPECT_EQ(BytesText(250000), "250 kB");
  EXPECT_EQ(BytesText(1.44e6), "1.4 MB");
  EXPECT_EQ(BytesText(14.3e9), "14 GB");
  EXPECT_EQ(BytesText(999999), "1.0 MB");
  EXPECT_EQ(CountText(2.14e6), "2.1 M");
  EXPECT_EQ(CountText(12), "12");
}

TEST(ProgressReporter, ReportsStepTimeRateAndRest)
{
  ProgressState state{ "levels", 0.356, 42.9, 2.14e6, "triangles",
    ProgressEstimate::Time{ 39.2, true } };
  EXPECT_EQ(ProgressText(state), "levels 35 %, 42 s, 2.1 M triangles/s, about 40 s left");
  state.left->whole = false;
  EXPECT_EQ(ProgressText(state), "levels 35 %, 42 s, 2.1 M triangles/s, about 40 s left of levels");
  state.unit = "B";
  state.left.reset();
  EXPECT_EQ(ProgressText(state), "levels 35 %, 42 s, 2.1 MB/s");
  // At the ends of a step the fraction has no meaning; the time shows that the work continues.
  EXPECT_EQ(ProgressText({ "surface", 0, 12, {}, {}, {} }), "surface, 12 s");
  EXPECT_EQ(ProgressText({ "write", 1, 12, {}, {}, {} }), "write, 12 s");
}

TEST(ProgressReporter, ABarFitsTheTerminal)
{
  const ProgressState state{ "levels", 0.5, 42, 2.14e6, "triangles", {} };
  EXPECT_EQ(ProgressBar(state, 200),
    "levels   [###############               ]  50 %  42 s  2.1 M triangles/s");
  EXPECT_EQ(ProgressBar(state, 50).size(), 50U);
}

TEST(ProgressReporter, ABarMovesWhereAStepReportsNothing)
{
  const auto bar = [](double fraction, double seconds) {
    return ProgressBar({ "surface", fraction, seconds, {}, {}, {} }, 200);
  };
  EXPECT_EQ(bar(0, 0), "surface  [######                        ]        0 s");
  EXPECT_EQ(bar(0, 1.2), "surface  [            ######            ]        1 s");
  EXPECT_EQ(bar(1, 2.4), "surface  [                        ######]        2 s");
  EXPECT_EQ(bar(1, 3.6), "surface  [            ######            ]        3 s") << "back again";
  EXPECT_EQ(bar(0, 4.8), "surface  [######                        ]        4 s");
  for (unsigned tenths = 1; tenths < 200; ++tenths)
  {
    EXPECT_NE(bar(0, 0.1 * tenths + 0.05), bar(0, 0.1 * tenths - 0.05)) << tenths;
  }
}

TEST(ProgressReporter, GoesOnWhileNothingIsReported)
{
  testing::internal::CaptureStderr();
  {
    ProgressReporter progress("kdstream-test", false);
    EXPECT_TRUE(progress("surface", 0));
    std::this_thread::sleep_for(std::chrono::milliseconds(6500));
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
    "kdstream-test: surface, 3 s\nkdstream-test: surface, 6 s\n");
}

TEST(ProgressReporter, SaysNothingIfQuietAndNothingOfShortWork)
{
  testing::internal::CaptureStderr();
  {
    ProgressReporter quiet("kdstream-test", true), shortly("kdstream-test", false);
    EXPECT_TRUE(quiet("read", 0.5));
    EXPECT_TRUE(shortly("read", 0.5));
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}
