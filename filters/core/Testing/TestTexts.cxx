// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/Texts.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

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

TEST(Texts, BytesThatAreNotPlainAreWrittenInHexadecimalAndReadAgain)
{
  const std::string text = "a/b c%\xc3\xa4-Z0";
  EXPECT_EQ(PercentEncoded(text, "/"), "a/b%20c%25%C3%A4%2DZ0");
  EXPECT_EQ(PercentEncoded(text, "-"), "a%2Fb%20c%25%C3%A4-Z0");
  EXPECT_EQ(PercentDecoded(PercentEncoded(text, "")), text);
}

TEST(Texts, Base64IsThatOfRfc4648)
{
  const std::pair<std::string, std::string> pairs[] = { { "", "" }, { "f", "Zg" }, { "fo", "Zm8" },
    { "foo", "Zm9v" }, { "foob", "Zm9vYg" }, { "\xfb\xff", "-_8" } };
  for (const auto& [text, base64] : pairs)
  {
    const std::vector<std::uint8_t> bytes(text.begin(), text.end());
    EXPECT_EQ(Base64Url(bytes), base64);
    EXPECT_EQ(Base64Decoded(base64), bytes);
    EXPECT_EQ(Base64Decoded(" " + base64 + "\r\n=="), bytes);
  }
  EXPECT_EQ(Base64Decoded("+/8="), Base64Decoded("-_8"));
  EXPECT_FALSE(Base64Decoded("Zm9*"));
}

TEST(Texts, BlanksAreTrimmedOnlyAtTheEnds)
{
  EXPECT_EQ(Trimmed(" \ta b\t "), "a b");
  EXPECT_EQ(Trimmed("\n a \n", " \n"), "a");
  EXPECT_EQ(Trimmed("\n a"), "\n a");
  EXPECT_EQ(Trimmed(" \t"), "");
  EXPECT_EQ(Trimmed(""), "");
}
