// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/Texts.h"

#include <algorithm>

namespace kdstream
{
namespace
{

// -1: none.
int HexValue(char c)
{
  if (c >= '0' && c <= '9')
  {
    return c - '0';
  }
  const char lower = static_cast<char>(c | 0x20);
  return lower >= 'a' && lower <= 'f' ? lower - 'a' + 10 : -1;
}

// The bytes of the UTF-8 character that the text begins with; 0 where there is none.
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

}

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

std::size_t CountCharacters(std::string_view text)
{
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(),
    [](char byte) { return (static_cast<unsigned char>(byte) & 0xC0) != 0x80; }));
}

std::string Quoted(std::string_view text)
{
  constexpr std::size_t most = 64;
  std::string quoted = "\"";
  for (const char c : text.substr(0, most))
  {
    quoted += c >= ' ' && c <= '~' ? c : '?';
  }
  quoted += text.size() > most ? "…\"" : "\"";
  return quoted;
}

std::string WithoutControls(std::string_view text)
{
  std::string shown;
  for (const char byte : RepairUtf8(text))
  {
    const auto c = static_cast<unsigned char>(byte);
    const bool endsC1 = c >= 0x80 && c < 0xA0 && !shown.empty() && shown.back() == '\xC2';
    if (endsC1)
    {
      shown.pop_back();
    }
    shown += endsC1 || c < ' ' || c == 0x7F ? '?' : byte;
  }
  return shown;
}

std::optional<std::string> PercentDecoded(std::string_view text)
{
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i)
  {
    if (text[i] != '%')
    {
      plain += text[i];
      continue;
    }
    const int high = i + 2 < text.size() ? HexValue(text[i + 1]) : -1;
    const int low = i + 2 < text.size() ? HexValue(text[i + 2]) : -1;
    if (high < 0 || low < 0)
    {
      return std::nullopt;
    }
    plain += static_cast<char>(high * 16 + low);
    i += 2;
  }
  return plain;
}

}
