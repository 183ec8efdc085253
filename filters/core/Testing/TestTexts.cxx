// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/Texts.h"

#include <gtest/gtest.h>

#include <string>

using namespace kdstream;

TEST(Texts, ATerminalGetsNoControlCharacters)
{
  EXPECT_EQ(WithoutControls("Venus \u00e9 \u2026"), "Venus \u00e9 \u2026");
  EXPECT_EQ(WithoutControls("\x1b]0;title\a\x1b[2J"), "?]0;title??[2J");
  EXPECT_EQ(WithoutControls(std::string("a\0b\rc\nd\te\x7f", 10)), "a?b?c?d?e?");
  EXPECT_EQ(WithoutControls("\xc2\x9b"
                            "31m"),
    "?31m"); // CSI in one character
  EXPECT_EQ(WithoutControls("\xc2\xa0"), "\xc2\xa0");
  EXPECT_EQ(WithoutControls("\x9b"
                            "a\xc3"),
    "\xef\xbf\xbd"
    "a\xef\xbf\xbd");
}
