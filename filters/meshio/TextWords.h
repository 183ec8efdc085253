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
  // Longer words are cut: no number and no meaningful name is this long.
  static constexpr std::size_t longestWord = 4096;

  // `source` must outlive this object, and must have been cropped by CropToText (PlainText.h). It
  // is read from its current position; nothing else may move it.
  explicit TextWords(ByteSource& source)
    : Source(source)
  {
  }

  // Returns the next word, skipping blanks and line breaks; empty at the end of the file. Valid
  // until the next call. A word longer than longestWord is returned in parts: its first longestWord
  // + 1 bytes, then the rest as further words. Errors: InputOutput.
  Result<std::string_view> Next()
  {
    const char* begin = this->Cursor;
    while (begin != this->End && IsBlank(*begin))
    {
      ++begin;
    }
    this->Cursor = begin;
    // Usually the word and the blank after it are already in memory.
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
  // Skips the first `count` bytes of the result of RestOfLine. REQUIRES: no other call since
  // RestOfLine.
  void Skip(std::size_t count) { this->Cursor += count; }

  // The offset of the byte after the last word. The source may stand further on, because the end of
  // the word had to be found.
  std::uint64_t Position() const
  {
    return this->Source.Position() + static_cast<std::uint64_t>(this->Cursor - this->Begin);
  }
  // Continues at this offset. REQUIRES: position <= the file's size.
  void Seek(std::uint64_t position);

private:
  Result<std::string_view> NextAcrossBlocks();
  std::string_view Take(const char* end)
  {
    const std::string_view word(this->Cursor, static_cast<std::size_t>(end - this->Cursor));
    this->Cursor = end;
    return word;
  }
  // more: how many bytes are needed after those that are in memory.
  Status Refill(std::size_t more = 1);

  ByteSource& Source;
  const char* Begin = nullptr; // [Begin, End) is in memory, Source stands at Begin
  const char* Cursor = nullptr;
  const char* End = nullptr;
};

}
