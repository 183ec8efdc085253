// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/Texts.h"

#include <algorithm>

namespace kdstream
{
namespace
{

// The value of a hexadecimal digit; -1 if c is not one.
int HexValue(char c)
{
  if (c >= '0' && c <= '9')
  {
    return c - '0';
  }
  const char lower = static_cast<char>(c | 0x20);
  return lower >= 'a' && lower <= 'f' ? lower - 'a' + 10 : -1;
}

bool IsLetterOrDigit(char c)
{
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
}

constexpr std::string_view base64Digits =
  "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";

// The number of bytes of the UTF-8 character at the start of the text; 0 if there is no valid one.
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

std::string PercentEncoded(std::string_view text, std::string_view plain)
{
  constexpr std::string_view digits = "0123456789ABCDEF";
  std::string encoded;
  for (const char c : text)
  {
    const auto byte = static_cast<unsigned char>(c);
    const bool isPlain = IsLetterOrDigit(c) || plain.find(c) != plain.npos;
    encoded +=
      isPlain ? std::string(1, c) : std::string{ '%', digits[byte >> 4U], digits[byte & 15U] };
  }
  return encoded;
}

std::string Base64Url(std::span<const std::uint8_t> bytes)
{
  std::string text;
  std::uint32_t held = 0;
  unsigned bits = 0;
  for (const std::uint8_t byte : bytes)
  {
    held = held << 8U | byte;
    for (bits += 8; bits >= 6; bits -= 6)
    {
      text += base64Digits[held >> (bits - 6) & 63U];
    }
  }
  return bits == 0 ? text : text + base64Digits[held << (6 - bits) & 63U];
}

std::optional<std::vector<std::uint8_t>> Base64Decoded(std::string_view text)
{
  constexpr std::string_view blanks = " \t\r\n";
  text = text.substr(0, text.find('='));
  std::vector<std::uint8_t> bytes;
  bytes.reserve(text.size() / 4 * 3);
  std::uint32_t held = 0;
  unsigned bits = 0;
  for (const char c : text)
  {
    if (blanks.find(c) != blanks.npos)
    {
      continue;
    }
    const std::size_t digit = base64Digits.find(c == '+' ? '-' : c == '/' ? '_' : c);
    if (digit == base64Digits.npos)
    {
      return std::nullopt;
    }
    held = held << 6U | static_cast<std::uint32_t>(digit);
    bits += 6;
    if (bits >= 8)
    {
      bits -= 8;
      bytes.push_back(static_cast<std::uint8_t>(held >> bits));
    }
  }
  return bytes;
}

std::string_view Trimmed(std::string_view text, std::string_view blanks)
{
  const auto first = text.find_first_not_of(blanks);
  return first == text.npos ? std::string_view()
                            : text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

}
