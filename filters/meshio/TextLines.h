// SPDX-License-Identifier: BSD-3-Clause
// Reads a text file line by line, in bounded memory: for the readers of text formats.
#pragma once

#include "filters/core/Result.h"
#include "filters/meshio/ByteSource.h"
#include "filters/meshio/PlainText.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

class TextLines
{
public:
  // longest: the longest line that is accepted, in bytes.
  explicit TextLines(ByteSource source, std::size_t longest = ByteSource::blockSize)
    : Source(std::move(source))
    , Longest(longest)
  {
  }

  // Goes to the next line; false at the end. Lines end with \n or \r\n, and also with a single \r
  // if the first MiB of the text has a \r without \n. A byte order mark at the beginning of the
  // text or of a line is skipped. The text ends before Ctrl-Z and zeros (PlainText.h). Memory: one
  // block, and a line that is longer than a block. Errors: InputOutput; a line longer than
  // `longest`; text in UTF-16.
  Result<bool> Next()
  {
    const char* const end = this->FindEnd();
    if (!end)
    {
      return this->NextAcrossBlocks();
    }
    this->TakeLine(end);
    this->PassEnd();
    return true;
  }
  // Valid until the next call of Next.
  std::string_view Line() const { return this->Text; }
  std::uint64_t Number() const { return this->Count; } // of the current line, from 1
  // The offset in the file of the first byte after the line and its line break.
  std::uint64_t End() const
  {
    return this->Source.Position() + static_cast<std::uint64_t>(this->Cursor - this->Begin);
  }
  std::uint64_t Size() const { return this->Source.Size(); } // of the file
  double Fraction() const;                                   // share of the file read so far
  // Begins again with the first line.
  void Restart();
  // Whether lines end with only \r, known once a line has been read.
  bool EndWithReturns() const { return this->ReturnsEnd; }
  // The number of zeros after the text, known once a line has been read.
  std::uint64_t Padding() const { return this->Zeros; }

  // "line 17: message".
  Error Wrong(const std::string& message, Remedy remedy = Remedy::Unknown) const;

private:
  Status Open();
  Result<bool> Load();
  Result<bool> NextAcrossBlocks();
  Result<bool> NextLong();
  // The end of the line that begins at Cursor; null if it is not in memory.
  const char* FindEnd() const
  {
    if (this->Cursor == this->Limit)
    {
      return nullptr;
    }
    if (this->ReturnsEnd)
    {
      const char* const end =
        std::find_if(this->Cursor, this->Limit, [](char c) { return c == '\n' || c == '\r'; });
      return end == this->Limit ? nullptr : end;
    }
    return static_cast<const char*>(
      std::memchr(this->Cursor, '\n', static_cast<std::size_t>(this->Limit - this->Cursor)));
  }
  // Moves Cursor past the line break at which it stands.
  void PassEnd()
  {
    const bool both = this->ReturnsEnd && *this->Cursor == '\r' && this->Limit - this->Cursor > 1 &&
                      this->Cursor[1] == '\n';
    this->Cursor += both ? 2 : 1;
  }
  void TakeLine(const char* end)
  {
    this->TakeText(std::string_view(this->Cursor, static_cast<std::size_t>(end - this->Cursor)));
    this->Cursor = end;
  }
  void TakeText(std::string_view text)
  {
    // A byte order mark inside the text comes from joining two files.
    if (text.starts_with(utf8Mark))
    {
      text.remove_prefix(utf8Mark.size());
    }
    this->Text = text;
    if (!this->Text.empty() && this->Text.back() == '\r')
    {
      this->Text.remove_suffix(1);
    }
    ++this->Count;
  }

  ByteSource Source;
  std::size_t Longest;
  std::string Gathered;        // a line that is longer than a block
  const char* Begin = nullptr; // [Begin, Limit) is in memory, Source stands at Begin
  const char* Cursor = nullptr;
  const char* Limit = nullptr;
  std::string_view Text;
  std::uint64_t Count = 0;
  bool Opened = false;
  bool ReturnsEnd = false; // whether \r by itself ends a line
  std::uint64_t Zeros = 0;
};

// Splits a line at any of the separators; `words` is emptied first.
void SplitWords(
  std::string_view line, std::string_view separators, std::vector<std::string_view>& words);

}
