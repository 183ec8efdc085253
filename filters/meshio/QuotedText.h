// SPDX-License-Identifier: BSD-3-Clause
// Words of a file, quoted in messages.
#pragma once

#include "filters/core/Texts.h"

#include <string>
#include <string_view>

namespace kdstream
{

// The word in quotes, for a message: at most 40 bytes, without control characters; empty if the
// text is not UTF-8.
inline std::string QuotedText(std::string_view word)
{
  std::string_view begin = word.substr(0, 40);
  while (begin.size() < word.size() && !begin.empty() && (word[begin.size()] & 0xC0) == 0x80)
  {
    begin.remove_suffix(1); // removes the beginning of a character that does not fit
  }
  std::string text = "'";
  if (IsUtf8(begin))
  {
    text += WithoutControls(begin);
  }
  else
  {
    for (const char c : begin)
    {
      text += c >= ' ' && c <= '~' ? c : '?';
    }
  }
  text += begin.size() < word.size() ? "…'" : "'";
  return text;
}

// The sentence to add if a word is not a number because it has a decimal comma; else empty.
inline std::string DecimalCommaHint(std::string_view word)
{
  constexpr std::string_view digits = "0123456789";
  const std::size_t comma = word.find(',');
  const bool decimal = comma != word.npos && comma > 0 && comma + 1 < word.size() &&
                       digits.find(word[comma - 1]) != digits.npos &&
                       word.find_first_not_of("0123456789eE+-", comma + 1) == word.npos;
  return decimal ? " (a decimal comma: write 1.5 for 1,5)" : "";
}

}
