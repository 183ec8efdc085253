// SPDX-License-Identifier: BSD-3-Clause
// Texts from outside: whether they are UTF-8, converting them to UTF-8, quoting them in messages;
// and decoding texts that stand for bytes.
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

// The number of bytes at the front of the text that are valid UTF-8 (Unicode, table 3-7).
std::size_t Utf8Prefix(std::string_view text);
inline bool IsUtf8(std::string_view text)
{
  return Utf8Prefix(text) == text.size();
}
// The text with U+FFFD for every byte that belongs to no character.
std::string RepairUtf8(std::string_view text);

// REQUIRES: UTF-8.
std::size_t CountCharacters(std::string_view text);

// The text in quotes for a message: at most its first 64 characters; everything except printable
// ASCII becomes '?'.
std::string Quoted(std::string_view text);

// The text made safe to print on a terminal: control characters (C0, DEL, C1) become '?', invalid
// bytes U+FFFD.
std::string WithoutControls(std::string_view text);

// The text with each %HH replaced by its byte, as in URLs (RFC 3986, section 2.1). No value if a %
// is followed by anything else.
std::optional<std::string> PercentDecoded(std::string_view text);
// The text with %HH for every byte that is neither an ASCII letter nor a digit nor in `plain`.
std::string PercentEncoded(std::string_view text, std::string_view plain);

// The bytes as base64url without padding (RFC 4648, section 5).
std::string Base64Url(std::span<const std::uint8_t> bytes);
// Decodes base64, in either alphabet of RFC 4648, with or without blanks and line ends, up to the
// first '='. Incomplete bytes are dropped. No value if there is any other character.
std::optional<std::vector<std::uint8_t>> Base64Decoded(std::string_view text);

// The text without the characters of `blanks` at its start and end.
std::string_view Trimmed(std::string_view text, std::string_view blanks = " \t");

}
