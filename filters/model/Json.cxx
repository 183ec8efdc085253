// SPDX-License-Identifier: BSD-3-Clause
#include "filters/model/Json.h"

#include "filters/core/Texts.h"
#include "filters/model/DecimalNumber.h"

#include <rapidjson/reader.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <string>

namespace kdstream
{

namespace
{

// Hands what the parser finds to a document, numbers as they are nearest.
struct DocumentBuilder
{
  JsonDocument& document;

  bool RawNumber(const char* text, rapidjson::SizeType length, bool)
  {
    const std::string_view number(text, length);
    if (number.find_first_of(".eE") == std::string_view::npos)
    {
      const bool negative = number[0] == '-';
      const char *const begin = text + (negative ? 1 : 0), *const end = text + length;
      std::uint64_t magnitude = 0;
      const bool fits = std::from_chars(begin, end, magnitude).ec == std::errc();
      if (fits && !negative)
      {
        return this->document.Uint64(magnitude);
      }
      // -0 is a double, and so is what 64 bits do not hold.
      if (fits && magnitude != 0 && magnitude <= std::uint64_t{ 1 } << 63)
      {
        return this->document.Int64(static_cast<std::int64_t>(0 - magnitude));
      }
    }
    const double value = NearestDouble(number);
    return std::isfinite(value) && this->document.Double(value);
  }
  bool Null() { return this->document.Null(); }
  bool Bool(bool value) { return this->document.Bool(value); }
  bool String(const char* text, rapidjson::SizeType length, bool copy)
  {
    return this->document.String(text, length, copy);
  }
  bool Key(const char* text, rapidjson::SizeType length, bool copy)
  {
    return this->document.Key(text, length, copy);
  }
  bool StartObject() { return this->document.StartObject(); }
  bool EndObject(rapidjson::SizeType members) { return this->document.EndObject(members); }
  bool StartArray() { return this->document.StartArray(); }
  bool EndArray(rapidjson::SizeType values) { return this->document.EndArray(values); }
  // RawNumber takes all numbers.
  bool Int(int) { return false; }
  bool Uint(unsigned) { return false; }
  bool Int64(std::int64_t) { return false; }
  bool Uint64(std::uint64_t) { return false; }
  bool Double(double) { return false; }
};

}

Result<JsonDocument> ParseJson(std::string_view text)
{
  constexpr unsigned flags = rapidjson::kParseIterativeFlag | rapidjson::kParseNumbersAsStringsFlag;
  JsonDocument document;
  // RapidJSON takes a zero byte for the text's end, and bytes that are no characters as they come.
  std::size_t end = std::min(Utf8Prefix(text), text.find('\0'));
  if (end >= text.size())
  {
    rapidjson::MemoryStream stream(text.data(), text.size());
    rapidjson::GenericReader<rapidjson::UTF8<>, rapidjson::UTF8<>, JsonMemory> reader;
    const auto parse = [&reader, &stream](JsonDocument& handler)
    {
      DocumentBuilder builder{ handler };
      return !reader.Parse<flags>(stream, builder).IsError();
    };
    document.Populate(parse);
    if (!reader.HasParseError())
    {
      return document;
    }
    end = reader.GetErrorOffset();
  }
  return Error{ ErrorCode::InvalidInput, "no JSON from byte " + std::to_string(end) + " on" };
}

const JsonValue* FindMember(const JsonValue& object, std::string_view key)
{
  for (auto member = object.MemberEnd(); member != object.MemberBegin();)
  {
    --member;
    if (TextOf(member->name) == key)
    {
      return &member->value;
    }
  }
  return nullptr;
}

}
