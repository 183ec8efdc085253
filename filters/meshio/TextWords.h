// SPDX-License-Identifier: BSD-3-Clause
// Splits text into words, within a line or across the lines of a file, in bounded memory. For all
// text formats of step "read".
#pragma once

#include "filters/core/Result.h"
#include "filters/meshio/ByteSource.h"

#include <cstdint>
#include <string>
#include <string_view>

namespace kdstream
{

// Blanks and the ends of lines.
constexpr bool IsBlank(char c)
{
  return c == ' ' || (c >= '\t' && c <= '\r');
}

// The text with ASCII letters in lower case, whatever the locale.
inline std::string LowercaseText(std::string_view text)
{
  std::string lower(text);
  for (char& c : lower)
  {
    c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  }
  return lower;
}

// Takes the blanks off the front.
inline void TakeBlanks(std::string_view& text)
{
  while (!text.empty() && IsBlank(text.front()))
  {
    text.remove_prefix(1);
  }
}

// Removes the next word from the front and returns it; empty if there is none.
inline std::string_view TakeWord(std::string_view& text)
{
  const char* begin = text.data();
  const char* const limit = begin + text.size();
  while (begin != limit && IsBlank(*begin))
  {
    ++begin;
  }
  const char* end = begin;
  while (end != limit && !IsBlank(*end))
  {
    ++end;
  }
  text = std::string_view(end, static_cast<std::size_t>(limit - end));
  return std::string_view(begin, static_cast<std::size_t>(end - begin));
}

class TextWords
{
public:
  // Longer ones are cut: no number and no name that means anything is as long.
  static constexpr std::size_t longestWord = 4096;

  // `source` must outlive this object, and must have been cropped by CropToText (PlainText.h). It
  // is read from its current position; nothing else may move it.
  explicit TextWords(ByteSource& source)
    : Source(source)
  {
  }

  // Goes to the next word, across blanks and the ends of lines; empty at the end of the file. Valid
  // until the next call. A longer word is returned in parts: its first longestWord + 1 bytes, then
  // the rest as further words. Errors: InputOutput.
  Result<std::string_view> Next()
  {
    const char* begin = this->Cursor;
    while (begin != this->End && IsBlank(*begin))
    {
      ++begin;
    }
    this->Cursor = begin;
    // The word and the blank after it are mostly in memory.
    if (this->End - begin <= static_cast<std::ptrdiff_t>(longestWord))
    {
      return this->NextAcrossBlocks();
    }
    const char* end = begin + 1;
    while (end != begin + longestWord + 1 && !IsBlank(*end))
    {
      ++end;
    }
    return this->Take(end);
  }
  // Goes to the end of the line. Errors: InputOutput.
  Status SkipLine();
  // The rest of the line after the last word, up to longestWord bytes. Valid until the next call.
  // Errors: InputOutput.
  Result<std::string_view> RestOfLine();
  // Goes on by `count` bytes of it. REQUIRES: no call since RestOfLine.
  void Skip(std::size_t count) { this->Cursor += count; }

  // The byte after the last word. Source's position may be further, where the word's end was found.
  std::uint64_t Position() const
  {
    return this->Source.Position() + static_cast<std::uint64_t>(this->Cursor - this->Begin);
  }
  // Reads from that byte on. REQUIRES: position <= the file's size.
  void Seek(std::uint64_t position);

private:
  Result<std::string_view> NextAcrossBlocks();
  std::string_view Take(const char* end)
  {
    const std::string_view word(this->Cursor, static_cast<std::size_t>(end - this->Cursor));
    this->Cursor = end;
    return word;
  }
  // more: bytes after those that are in memory.
  Status Refill(std::size_t more = 1);

  ByteSource& Source;
  const char* Begin = nullptr; // [Begin, End) is in memory, Source stands at Begin
  const char* Cursor = nullptr;
  const char* End = nullptr;
};

}
