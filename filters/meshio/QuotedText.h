// SPDX-License-Identifier: BSD-3-Clause
// Words of a file inside messages.
#pragma once

#include <string>
#include <string_view>

namespace kdstream
{

// 'word' in quotes, without control characters and at most 40 characters of it.
inline std::string QuotedText(std::string_view word)
{
  std::string text = "'";
  for (char c : word.substr(0, 40))
  {
    text += c >= ' ' && c <= '~' ? c : '?';
  }
  text += word.size() > 40 ? "…'" : "'";
  return text;
}

}
