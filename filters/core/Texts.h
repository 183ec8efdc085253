// SPDX-License-Identifier: BSD-3-Clause
// Texts that come from elsewhere: whether they are UTF-8, made UTF-8, and in a message.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

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

}
