// SPDX-License-Identifier: BSD-3-Clause
#include "filters/page/PageTexts.h"

#include "filters/core/Texts.h"

#include <algorithm>

namespace kdstream
{

std::string HtmlEscaped(std::string_view text)
{
  std::string escaped;
  for (const char c : RepairUtf8(text))
  {
    const bool isControl = (static_cast<unsigned char>(c) < ' ' && c != '\n' && c != '\t') ||
                           static_cast<unsigned char>(c) == 0x7f;
    escaped += c == '&'    ? "&amp;"
               : c == '<'  ? "&lt;"
               : c == '>'  ? "&gt;"
               : c == '"'  ? "&quot;"
               : c == '\'' ? "&#39;"
               : isControl ? "\xEF\xBF\xBD"
                           : std::string(1, c);
  }
  return escaped;
}

// In JSON, "<" occurs only in texts, where it may be escaped.
std::string ScriptEscaped(std::string_view json)
{
  std::string escaped;
  for (const char c : json)
  {
    escaped += c == '<'   ? "\\u003c"
               : c == '>' ? "\\u003e"
               : c == '&' ? "\\u0026"
                          : std::string(1, c);
  }
  return escaped;
}

std::string Shortened(std::string_view text, std::size_t bytes)
{
  if (text.size() <= bytes)
  {
    return std::string(text);
  }
  return std::string(text.substr(0, Utf8Prefix(text.substr(0, bytes)))) + "…";
}

std::string WithoutDirections(std::string_view text)
{
  std::string plain;
  for (std::size_t at = 0; at < text.size();)
  {
    // U+202A to U+202E, U+2066 to U+2069
    const auto prefix = text.substr(at, 2);
    const auto last = at + 2 < text.size() ? static_cast<unsigned char>(text[at + 2]) : 0;
    const bool isDirection = (prefix == "\xE2\x80" && last >= 0xAA && last <= 0xAE) ||
                             (prefix == "\xE2\x81" && last >= 0xA6 && last <= 0xA9);
    if (!isDirection)
    {
      plain += text[at];
    }
    at += isDirection ? 3 : 1;
  }
  return plain;
}

bool IsWebAddress(std::string_view text)
{
  return (text.substr(0, 7) == "http://" || text.substr(0, 8) == "https://") &&
         std::none_of(
           text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) <= ' '; });
}

}
