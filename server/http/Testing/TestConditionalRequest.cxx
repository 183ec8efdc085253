// SPDX-License-Identifier: BSD-3-Clause
#include "server/http/ConditionalRequest.h"

#include <gtest/gtest.h>

#include <string>

using namespace kdstream;

namespace
{

// The parsed range as text: "whole", "none", or "begin+length".
std::string Range(std::string_view field, std::size_t size)
{
  const auto answer = ParseRange(field, size);
  if (const auto* part = std::get_if<PartialRange>(&answer))
  {
    return std::to_string(part->begin) + "+" + std::to_string(part->length);
  }
  return std::holds_alternative<WholeRange>(answer) ? "whole" : "none";
}

}

TEST(TestConditionalRequest, OneRange)
{
  EXPECT_EQ(Range("bytes=0-0", 10), "0+1");
  EXPECT_EQ(Range("bytes=2-5", 10), "2+4");
  EXPECT_EQ(Range("bytes=2-", 10), "2+8");
  EXPECT_EQ(Range("bytes=9-", 10), "9+1");
  EXPECT_EQ(Range("bytes=2-99", 10), "2+8");
  EXPECT_EQ(Range("bytes=-3", 10), "7+3");
  EXPECT_EQ(Range("bytes=-99", 10), "0+10");
  EXPECT_EQ(Range("bytes= 2-5 ", 10), "2+4");
  EXPECT_EQ(Range("bytes=2-18446744073709551615", 10), "2+8");
  EXPECT_EQ(Range("bytes=2-99999999999999999999999", 10), "2+8");
}

TEST(TestConditionalRequest, RangesBeyondTheEnd)
{
  EXPECT_EQ(Range("bytes=10-", 10), "none");
  EXPECT_EQ(Range("bytes=10-12", 10), "none");
  EXPECT_EQ(Range("bytes=99999999999999999999999-", 10), "none");
  EXPECT_EQ(Range("bytes=-0", 10), "none");
  EXPECT_EQ(Range("bytes=0-", 0), "none");
  EXPECT_EQ(Range("bytes=-5", 0), "none");
}

TEST(TestConditionalRequest, WhatIsNotUnderstoodGivesTheWhole)
{
  for (const char* field :
    { "", "bytes", "bytes=", "bytes=-", "bytes=5-2", "bytes=a-b", "bytes=0x1-2", "bytes=1-2,4-5",
      "bytes=+1-2", "bytes=1--2", "bytes=--2", "items=1-2", "Bytes=1-2", "bytes=1 - 2" })
  {
    EXPECT_EQ(Range(field, 10), "whole") << field;
  }
}

TEST(TestConditionalRequest, Tags)
{
  const std::string tag = "\"abc\"";
  for (const char* field : { "*", " * ", "\"abc\"", "W/\"abc\"", "\"x\", \"abc\"", "\"x\",\"abc\" ",
         "W/\"x\" , W/\"abc\"", "\"a,b\", \"abc\"" })
  {
    EXPECT_TRUE(NamesTag(field, tag)) << field;
  }
  for (const char* field : { "", " ", "abc", "\"abc", "\"ab\"", "\"abcd\"", "W/abc",
         "\"x\" \"abc\"", "\"x\";\"abc\"", ",\"abc\"", "\"", "W/", "**" })
  {
    EXPECT_FALSE(NamesTag(field, tag)) << field;
  }
}

TEST(TestConditionalRequest, Gzip)
{
  for (const char* yes : { "gzip", "gzip, deflate, br", "deflate,gzip", "GZip", "x-gzip", "*",
         "br;q=1.0, gzip;q=0.8, *;q=0.1", "gzip;q=0.001", "gzip ; Q=1.000", "gzip;q=1",
         "*;q=0.5, identity;q=0.4", "identity;q=0.5, gzip;q=0.5", "identity;q=0, gzip;q=0.1",
         ", ,gzip", "br;q=x, gzip", "compress, gzip\t;\tq=0.5 " })
  {
    EXPECT_TRUE(AcceptsGzip(yes)) << yes;
  }
  for (const char* no : { "", "gzip;q=0", "gzip;q=0.", "gzip;q=0.000", "gzip; q=0", "identity",
         "br", "br, deflate", "*;q=0", "*, gzip;q=0", "gzip;q=0, *", "gzippy", "gzi", "gzip;q=2",
         "gzip;q=1.001", "gzip;q=", "gzip;q=0.5555", "gzip;q=-1", "gzip;q=.5", "gzip;q=0,5",
         "gzip;x=1", "gzip;q", "gzip gzip", "identity;q=1, gzip;q=0.5", ",,,", ";", "=" })
  {
    EXPECT_FALSE(AcceptsGzip(no)) << no;
  }
}
