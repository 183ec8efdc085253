// SPDX-License-Identifier: BSD-3-Clause
// JSON read and written, compared with strtod and nlohmann's library.
#include "Testing/Fixtures/Sanitized.h"
#include "filters/core/Texts.h"
#include "filters/model/Json.h"
#include "filters/model/JsonWriter.h"
#include "filters/model/ModelJson.h"
#include "filters/model/Testing/RandomModels.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>

using namespace kdstream;

namespace
{

std::uint64_t Bits(double value)
{
  return std::bit_cast<std::uint64_t>(value);
}

std::string Write(double value)
{
  JsonWriter writer;
  writer.Put(value);
  return writer.Text();
}

double Read(const std::string& text)
{
  const auto json = ParseJson(text);
  EXPECT_TRUE(json && json->IsNumber()) << text;
  return json && json->IsNumber() ? json->GetDouble() : std::nan("");
}

}

TEST(TestJson, DoublesComeBackBitForBit)
{
  std::mt19937_64 random(1);
  for (int i = 0; i < fixtures::Rounds(40000); ++i)
  {
    double value = std::bit_cast<double>(random());
    if (i % 4 == 1)
    {
      value = static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(random())));
    }
    else if (i % 4 == 2) // subnormal
    {
      value = std::bit_cast<double>(random() >> (12 + random() % 52));
    }
    if (!std::isfinite(value))
    {
      EXPECT_EQ(Write(value), "null");
      continue;
    }
    const std::string text = Write(value);
    ASSERT_LE(text.size(), 25u);
    ASSERT_EQ(Bits(std::strtod(text.c_str(), nullptr)), Bits(value)) << text;
    ASSERT_EQ(Bits(Read(text)), Bits(value)) << text;
  }
  for (const double value : { 0.0, -0.0, 1.0, 5e-324, 1.7976931348623157e308, 0.1, 1e21, 1e23 })
  {
    EXPECT_EQ(Bits(Read(Write(value))), Bits(value));
  }
  EXPECT_EQ(Write(640.0), "640.0");
}

TEST(TestJson, IntegersAreExact)
{
  EXPECT_EQ(ParseJson("18446744073709551615")->GetUint64(), 18446744073709551615ull);
  EXPECT_EQ(
    ParseJson("-9223372036854775808")->GetInt64(), std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(ParseJson("9007199254740993")->GetUint64(), 9007199254740993ull);
  EXPECT_FALSE(ParseJson("18446744073709551616")->IsUint64());
  EXPECT_FALSE(ParseJson("-9223372036854775809")->IsInt64());
  EXPECT_EQ(Read("18446744073709551616"), 18446744073709551616.0);
  EXPECT_EQ(Read("-18446744073709551615"), -18446744073709551615.0);
  EXPECT_EQ(Bits(Read("-0")), Bits(-0.0));
  JsonWriter writer;
  writer.Put(std::uint64_t{ 18446744073709551615ull });
  EXPECT_EQ(writer.Text(), "18446744073709551615");
}

TEST(TestJson, TheLastOfTwoMembersCounts)
{
  const auto json = ParseJson(R"({"a":1,"b":2,"a":3})");
  ASSERT_TRUE(json);
  EXPECT_EQ(FindMember(*json, "a")->GetInt(), 3);
  EXPECT_EQ(FindMember(*json, "b")->GetInt(), 2);
  EXPECT_EQ(FindMember(*json, "c"), nullptr);
  EXPECT_EQ(FindMember(*ParseJson("{}"), "a"), nullptr);
}

TEST(TestJson, RefusesWhatIsNotJson)
{
  using namespace std::string_view_literals;
  for (const std::string_view text : { ""sv, " "sv, "{"sv, "[1,]"sv, "{\"a\":1,}"sv, "{} {}"sv,
         "{}\0"sv, "{}\0x"sv, "\"\0\""sv, "01"sv, "+1"sv, ".5"sv, "1."sv, "NaN"sv, "Infinity"sv,
         "1e999"sv, "1.8e308"sv, "\"\xE0\x9F\x80\""sv, "\"\xF4\x90\x80\x80\""sv, "// x\n1"sv,
         "'a'"sv, "\"\xFF\""sv, "\"\xC0\x80\""sv, "\"\xED\xA0\x80\""sv, "\"\xF5\x80\x80\x80\""sv,
         "\"\xE2\x82\""sv, "\"a\nb\""sv, "\"\\x41\""sv, "\"\\uD800\""sv, "\xFF\xFE{\0}\0"sv })
  {
    const auto json = ParseJson(text);
    EXPECT_FALSE(json) << text;
  }
  const auto wrong = ParseJson("[1, 2, x]");
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.GetError().message.find("byte 7"), std::string::npos);
  // Half of a surrogate pair is accepted here; readers check for it.
  const auto half = ParseJson(R"("\uDC00")");
  EXPECT_FALSE(half && IsUtf8(TextOf(*half)));
}

namespace
{

nlohmann::json Copy(const JsonValue& value)
{
  if (value.IsArray())
  {
    nlohmann::json copy = nlohmann::json::array();
    for (const JsonValue& each : value.GetArray())
    {
      copy.push_back(Copy(each));
    }
    EXPECT_EQ(copy.size(), value.Size());
    return copy;
  }
  if (value.IsObject())
  {
    nlohmann::json copy = nlohmann::json::object();
    for (const JsonMember& each : value.GetObject())
    {
      copy[std::string(TextOf(each.name))] = Copy(each.value);
    }
    return copy;
  }
  return value.IsString()   ? nlohmann::json(TextOf(value))
         : value.IsBool()   ? nlohmann::json(value.GetBool())
         : value.IsUint64() ? nlohmann::json(value.GetUint64())
         : value.IsInt64()  ? nlohmann::json(value.GetInt64())
         : value.IsNumber() ? nlohmann::json(value.GetDouble())
                            : nlohmann::json();
}

}

TEST(TestJson, TakesWhatNlohmannTakes)
{
  RandomModels random(5);
  unsigned taken = 0, refused = 0;
  for (int i = 0; i < fixtures::Rounds(3000); ++i)
  {
    std::string text = WriteStoredModel(random.Model());
    text = i % 5 == 0 ? text : random.Mutated(i % 5 == 1 ? text.substr(0, 40) + "}" : text);
    const auto expected = nlohmann::json::parse(text, nullptr, false);
    const auto found = ParseJson(text);
    ASSERT_EQ(found.HasValue(), !expected.is_discarded()) << text;
    ASSERT_TRUE(!found || Copy(*found) == expected) << text;
    ++(found ? taken : refused);
  }
  EXPECT_GT(taken, unsigned(fixtures::Rounds(500)));
  EXPECT_GT(refused, unsigned(fixtures::Rounds(500)));
  for (const std::string text :
    { R"(["\u00e9\u20ac\ud83d\ude00\u0000\/\b\f\"",{"":{}},[],[[]], -0.5e-3 , 1E+2,null])",
      "\t\r\n {\"a\":[1,{\"b\":[2,{}]}],\"c\":3} ", R"("\ud83d")", R"("\ud83dx")",
      R"("\ud83d\u0041")", R"("\u12g4")", R"("\u12)", R"("\)", R"(")", "[1 2]", "{\"a\" 1}",
      "{\"a\":}", "{1:2}", "tru", "truex", "-", "1e", "1e+", "- 1", "[}", "{]", "\f1" })
  {
    const auto expected = nlohmann::json::parse(text, nullptr, false);
    const auto found = ParseJson(text);
    EXPECT_EQ(found.HasValue(), !expected.is_discarded()) << text;
    EXPECT_TRUE(!found || Copy(*found) == expected) << text;
  }
}

TEST(TestJson, NestingCostsNoStack)
{
  const std::size_t depth = 2000000;
  const auto json = ParseJson(std::string(depth, '[') + std::string(depth, ']'));
  ASSERT_TRUE(json);
  EXPECT_TRUE(json->IsArray());
  EXPECT_FALSE(ParseJson(std::string(depth, '[')));
}

TEST(TestJson, TextIsEscapedAndRepaired)
{
  std::mt19937_64 random(3);
  for (int i = 0; i < fixtures::Rounds(20000); ++i)
  {
    std::string text;
    for (auto bytes = random() % 12; bytes > 0; --bytes)
    {
      text += "\xE2\x82\xAC\xF0\x9F\x98\x80\xED\xA0\xC0\"\\\n\x01\x7Fz"[random() % 16];
    }
    JsonWriter writer;
    writer.Put(text);
    const auto back = nlohmann::json::parse(writer.Text(), nullptr, false);
    ASSERT_TRUE(back.is_string()) << writer.Text();
    bool whole = true;
    try
    {
      (void)nlohmann::json(text).dump();
    }
    catch (const nlohmann::json::exception&)
    {
      whole = false;
    }
    ASSERT_EQ(IsUtf8(text), whole);
    ASSERT_EQ(back == text, whole) << writer.Text();
  }
}

TEST(TestJson, IndentedTextIsWhatNlohmannWrites)
{
  const nlohmann::json expected{ { "a", { 1, 2.5, "x" } }, { "b", nlohmann::json::object() },
    { "c", nlohmann::json::array() }, { "d", { { "e", nullptr }, { "f", true } } } };
  JsonWriter writer({ 2 });
  writer.BeginObject().Key("a").BeginArray().Put(1).Put(2.5).Put("x").EndArray();
  writer.Key("b").BeginObject().EndObject().Key("c").BeginArray().EndArray();
  writer.Member("d", [](JsonWriter& d)
    { d.BeginObject().Member("e", std::optional<int>()).Member("f", true).EndObject(); });
  writer.EndObject();
  EXPECT_EQ(writer.Text(), expected.dump(2));
}
