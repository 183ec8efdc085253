// SPDX-License-Identifier: BSD-3-Clause
// Texts that come from elsewhere: whether they are UTF-8, made UTF-8, and in a message; and texts
// that stand for bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

// The bytes at the front of the text that are UTF-8 (Unicode, table 3-7).
std::size_t Utf8Prefix(std::string_view text);
inline bool IsUtf8(std::string_view text)
{
  return Utf8Prefix(text) == text.size();
}
// The text with U+FFFD for every byte that belongs to no character.
std::string RepairUtf8(std::string_view text);

// REQUIRES: UTF-8.
std::size_t CountCharacters(std::string_view text);

// The text in quotes for a message: at most 64 characters of it, anything but printable ASCII as
// '?'.
std::string Quoted(std::string_view text);

// The text as a line of a terminal may show it, whatever a stranger wrote: control characters (C0,
// DEL, C1) as '?', bytes that belong to no character as U+FFFD.
std::string WithoutControls(std::string_view text);

// The text with the byte that each %HH stands for, as addresses have them (RFC 3986, section 2.1).
// Nothing where a % is followed by anything else.
std::optional<std::string> PercentDecoded(std::string_view text);
// The text with %HH for every byte that is neither an ASCII letter nor a digit nor in `plain`.
std::string PercentEncoded(std::string_view text, std::string_view plain);

// The bytes as base64url without padding (RFC 4648, section 5).
std::string Base64Url(std::span<const std::uint8_t> bytes);
// The bytes that base64 stands for, in either alphabet of RFC 4648, with blanks and line ends or
// not, up to the first '='. Bits that make no byte are dropped. Nothing where another character
// comes before that.
std::optional<std::vector<std::uint8_t>> Base64Decoded(std::string_view text);

// The text without what it has of `blanks` at its ends.
std::string_view Trimmed(std::string_view text, std::string_view blanks = " \t");

}
