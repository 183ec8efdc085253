// SPDX-License-Identifier: BSD-3-Clause
// Reads a text file line by line, in bounded memory: see TextLines.h.
#include "filters/meshio/TextLines.h"

namespace kdstream
{

namespace
{

// Whether the text has a \r without \n after it, which then ends a line.
bool HasLoneReturn(std::string_view text)
{
  for (std::size_t at = text.find('\r'); at != std::string_view::npos; at = text.find('\r', at + 1))
  {
    if (at + 1 < text.size() && text[at + 1] != '\n')
    {
      return true;
    }
  }
  return false;
}

}

Status TextLines::Open()
{
  this->Opened = true;
  const Result<std::uint64_t> zeros = CropToText(this->Source);
  KDSTREAM_TRY(zeros);
  this->Zeros = *zeros;
  const Result<std::string_view> ahead = this->Source.Peek(ByteSource::blockSize);
  KDSTREAM_TRY(ahead);
  this->ReturnsEnd = HasLoneReturn(*ahead);
  return {};
}

// Loads a block that begins at Cursor; false at the end of the text.
Result<bool> TextLines::Load()
{
  this->Source.Consume(static_cast<std::size_t>(this->Cursor - this->Begin));
  const Result<std::string_view> ahead = this->Source.Peek(ByteSource::blockSize);
  KDSTREAM_TRY(ahead);
  this->Begin = this->Cursor = ahead->data();
  this->Limit = ahead->data() + ahead->size();
  return !ahead->empty();
}

// Handles a line that does not end in the part that is in memory.
Result<bool> TextLines::NextAcrossBlocks()
{
  if (!this->Opened)
  {
    KDSTREAM_TRY(this->Open());
  }
  const Result<bool> more = this->Load();
  KDSTREAM_TRY(more);
  if (!*more)
  {
    ++this->Count;
    return false;
  }
  const char* const end = this->FindEnd();
  if (!end && static_cast<std::uint64_t>(this->Limit - this->Cursor) < this->Source.Remaining())
  {
    return this->NextLong();
  }
  this->TakeLine(end ? end : this->Limit);
  if (end)
  {
    this->PassEnd();
  }
  return true;
}

// Handles a line that is longer than a block.
Result<bool> TextLines::NextLong()
{
  this->Gathered.clear();
  for (bool more = true; more;)
  {
    const char* const end = this->FindEnd();
    const char* const to = end ? end : this->Limit;
    if (static_cast<std::size_t>(to - this->Cursor) > this->Longest - this->Gathered.size())
    {
      ++this->Count;
      return this->Wrong("is longer than " + std::to_string(this->Longest >> 20U) + " MiB");
    }
    this->Gathered.append(this->Cursor, to);
    this->Cursor = to;
    if (end)
    {
      this->PassEnd();
      break;
    }
    const Result<bool> loaded = this->Load();
    KDSTREAM_TRY(loaded);
    more = *loaded;
  }
  this->TakeText(this->Gathered);
  return true;
}

void TextLines::Restart()
{
  this->Source.Seek(this->Source.Start());
  this->Begin = this->Cursor = this->Limit = nullptr;
  this->Text = {};
  this->Count = 0;
}

double TextLines::Fraction() const
{
  return double(this->End()) / std::max(1.0, double(this->Source.Size()));
}

Error TextLines::Wrong(const std::string& message, Remedy remedy) const
{
  return BadInput("line " + std::to_string(this->Count) + ": " + message, remedy);
}

void SplitWords(
  std::string_view line, std::string_view separators, std::vector<std::string_view>& words)
{
  words.clear();
  for (std::size_t begin = line.find_first_not_of(separators); begin != std::string_view::npos;)
  {
    const std::size_t end = std::min(line.find_first_of(separators, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(separators, end);
  }
}

}
