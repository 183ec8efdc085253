// JSON texts in and out: see Json.h.
#include "server/protocol/Json.h"

#include <algorithm>
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
  constexpr unsigned flags = rapidjson::kParseIterativeFlag | rapidjson::kParseFullPrecisionFlag;
  JsonDocument document;
  // RapidJSON takes a zero byte for the text's end, and bytes that are no characters as they come.
  std::size_t end = std::min(Utf8Prefix(text), text.find('\0'));
  if (end >= text.size())
  {
    document.Parse<flags>(text.data(), text.size());
    if (!document.HasParseError())
    {
      return document;
    }
    end = document.GetErrorOffset();
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
