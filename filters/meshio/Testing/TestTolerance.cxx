// SPDX-License-Identifier: BSD-3-Clause
// Tolerance: counts by kind, how they are reported, and how they are sent to another process.
#include "Testing/Fixtures/ErrorAt.h"
#include "filters/meshio/Tolerance.h"

#include <gtest/gtest.h>

namespace kdstream::test
{

TEST(Tolerance, CountsAndReports)
{
  Tolerance tolerance;
  EXPECT_TRUE(tolerance.Check(true));
  EXPECT_EQ(tolerance.Summary(), "");
  EXPECT_TRUE(tolerance.Check(true));
  tolerance.Count(Lapse::FaceTooSmall, 0, "nowhere");
  EXPECT_TRUE(tolerance.Check(true));
  tolerance.Count(Lapse::FaceTooSmall, 1, "face 3");
  tolerance.Count(Lapse::FaceTooSmall, 2, "face 9");
  tolerance.Count(Lapse::PointNotFinite, 1);
  tolerance.Tell("a reading");
  EXPECT_EQ(tolerance.Warnings(),
    (std::vector<std::string>{ "1 point is not finite and is dropped",
      "3 faces have fewer than three corners and are dropped; the first: face 3", "a reading" }));
  EXPECT_EQ(tolerance.Summary(), "1 point dropped, 3 faces too small");
  EXPECT_TRUE(tolerance.Check(false));
  EXPECT_TRUE(fixtures::FailsAt(tolerance.Check(true), ErrorCode::InvalidInput, "1 point"));
}

TEST(Tolerance, OnlyAReadingIsAllowed)
{
  Tolerance tolerance;
  tolerance.Tell("it could be either");
  EXPECT_TRUE(tolerance.Check(true));
  EXPECT_EQ(tolerance.Warnings().size(), 1U);
}

TEST(Tolerance, GoesBetweenProcessesAsLines)
{
  Tolerance tolerance;
  for (std::size_t k = 0; k < lapseKinds; ++k)
  {
    tolerance.Count(static_cast<Lapse>(k), k + 1, k % 2 == 0 ? "line 3: odd\nplace" : "");
  }
  tolerance.Tell("columns are so");
  const Tolerance back =
    Tolerance::FromLines("other line\n" + tolerance.ToLines() + "forgiven x 3\n");
  EXPECT_EQ(back.Warnings(), tolerance.Warnings());
  EXPECT_EQ(
    Tolerance::FromLines("forgiven points_not_finite x\nforgiven\nreading").Warnings().size(), 0U);
}

TEST(Tolerance, PartsOfAFileAddUp)
{
  Tolerance all;
  all.Count(Lapse::PointNotFinite, 2, "vertex 1");
  all.Tell("first");
  const Tolerance before = all;
  all.Count(Lapse::PointNotFinite, 3, "vertex 7");
  all.Count(Lapse::NotCounted, 5, "byte 9");
  all.Tell("second");
  const Tolerance since = all.Since(before);
  EXPECT_EQ(since.Of(Lapse::PointNotFinite), 3U);
  EXPECT_EQ(since.Warnings().size(), 3U);
  EXPECT_EQ(since.Warnings().back(), "second");
  Tolerance sum = before;
  sum.Add(since);
  EXPECT_EQ(sum.Warnings(), all.Warnings());
}

}
