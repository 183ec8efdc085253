// SPDX-License-Identifier: BSD-3-Clause
// Reads a text file word by word, in bounded memory: see TextWords.h.
#include "filters/meshio/TextWords.h"

#include <algorithm>

namespace kdstream
{

// Keeps the bytes ahead of Cursor, and reads more after them. At the end of the file nothing is
// added.
Status TextWords::Refill(std::size_t more)
{
  this->Source.Consume(static_cast<std::size_t>(this->Cursor - this->Begin));
  const auto kept = static_cast<std::size_t>(this->End - this->Cursor);
  const Result<std::string_view> ahead =
    this->Source.Peek(std::min(kept + more, ByteSource::blockSize));
  KDSTREAM_TRY(ahead);
  this->Begin = this->Cursor = ahead->data();
  this->End = ahead->data() + ahead->size();
  return {};
}

Result<std::string_view> TextWords::NextAcrossBlocks()
{
  while (this->Cursor == this->End)
  {
    KDSTREAM_TRY(this->Refill());
    if (this->Cursor == this->End)
    {
      return std::string_view();
    }
    this->Cursor = std::find_if_not(this->Cursor, this->End, IsBlank); // a block may be all blanks
  }
  // Brings a whole word of the permitted length into memory.
  if (static_cast<std::size_t>(this->End - this->Cursor) <= longestWord)
  {
    KDSTREAM_TRY(this->Refill());
  }
  const char* const limit =
    this->Cursor + std::min<std::ptrdiff_t>(this->End - this->Cursor, longestWord + 1);
  return this->Take(std::find_if(this->Cursor, limit, IsBlank));
}

Status TextWords::SkipLine()
{
  for (;;)
  {
    this->Cursor =
      std::find_if(this->Cursor, this->End, [](char c) { return c == '\n' || c == '\r'; });
    if (this->Cursor != this->End)
    {
      return {};
    }
    if (Status status = this->Refill(); !status || this->Cursor == this->End)
    {
      return status;
    }
  }
}

Result<std::string_view> TextWords::RestOfLine()
{
  if (static_cast<std::size_t>(this->End - this->Cursor) <= longestWord)
  {
    KDSTREAM_TRY(this->Refill(longestWord));
  }
  const std::string_view ahead(
    this->Cursor, std::min(static_cast<std::size_t>(this->End - this->Cursor), longestWord));
  return ahead.substr(0, ahead.find_first_of("\r\n"));
}

void TextWords::Seek(std::uint64_t position)
{
  this->Source.Seek(position);
  this->Begin = this->Cursor = this->End = nullptr;
}

}
