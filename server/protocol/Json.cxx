// JSON texts in and out: see Json.h.
#include "server/protocol/Json.h"

#include "server/protocol/DecimalNumber.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace kdstream::protocol
{

namespace
{

// The bytes of the UTF-8 character that the text begins with (Unicode, table 3-7); 0 where there is
// none.
std::size_t CharacterBytes(std::string_view text)
{
  const auto at = [text](std::size_t i) -> unsigned
  { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  const auto continues = [&at](std::size_t first, std::size_t last)
  {
    bool all = true;
    for (std::size_t i = first; i <= last; ++i)
    {
      all = all && at(i) >= 0x80 && at(i) <= 0xBF;
    }
    return all;
  };
  const unsigned lead = at(0);
  if (lead < 0x80)
  {
    return text.empty() ? 0 : 1;
  }
  if (lead >= 0xC2 && lead <= 0xDF)
  {
    return continues(1, 1) ? 2 : 0;
  }
  if (lead >= 0xE0 && lead <= 0xEF)
  {
    const bool overlong = lead == 0xE0 && at(1) < 0xA0;
    const bool surrogate = lead == 0xED && at(1) > 0x9F;
    return continues(1, 2) && !overlong && !surrogate ? 3 : 0;
  }
  const bool overlong = lead == 0xF0 && at(1) < 0x90;
  const bool beyond = lead == 0xF4 && at(1) > 0x8F;
  return lead >= 0xF0 && lead <= 0xF4 && continues(1, 3) && !overlong && !beyond ? 4 : 0;
}

// The bytes at the front that are UTF-8.
std::size_t Utf8Prefix(std::string_view text)
{
  std::size_t bytes = 0;
  for (std::size_t next = 0; (next = CharacterBytes(text.substr(bytes))) != 0;)
  {
    bytes += next;
  }
  return bytes;
}

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

std::string RepairUtf8(std::string_view text)
{
  std::string repaired;
  while (!text.empty())
  {
    const std::size_t good = Utf8Prefix(text);
    repaired += text.substr(0, good);
    text.remove_prefix(good);
    if (!text.empty())
    {
      repaired += "\xEF\xBF\xBD";
      text.remove_prefix(1);
    }
  }
  return repaired;
}

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
    rapidjson::Reader reader;
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

const Json* FindMember(const Json& object, std::string_view key)
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

bool IsUtf8(std::string_view text)
{
  return Utf8Prefix(text) == text.size();
}

void JsonWriter::Put(std::string_view text)
{
  if (!IsUtf8(text))
  {
    this->Put(std::string_view(RepairUtf8(text)));
    return;
  }
  this->Writer.String(text.data(), static_cast<rapidjson::SizeType>(text.size()));
}

void JsonWriter::Put(double value)
{
  if (std::isfinite(value))
  {
    this->Writer.Double(value);
  }
  else
  {
    this->Writer.Null();
  }
}

}
