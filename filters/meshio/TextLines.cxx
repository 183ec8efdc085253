// SPDX-License-Identifier: BSD-3-Clause
// A text file line by line, in bounded memory: see TextLines.h.
#include "filters/meshio/TextLines.h"

#include "filters/meshio/PlainText.h"

namespace kdstream
{

namespace
{

// Whether a \r ends a line by itself.
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

// The line does not end in what is in memory.
Result<bool> TextLines::NextAcrossBlocks()
{
  if (!this->Opened)
  {
    KDSTREAM_TRY(this->Open());
  }
  this->Source.Consume(static_cast<std::size_t>(this->Cursor - this->Begin));
  const Result<std::string_view> ahead = this->Source.Peek(ByteSource::blockSize);
  KDSTREAM_TRY(ahead);
  this->Begin = this->Cursor = ahead->data();
  this->Limit = ahead->data() + ahead->size();
  if (ahead->empty())
  {
    ++this->Count;
    return false;
  }
  const char* const end = this->FindEnd();
  if (!end && ahead->size() < this->Source.Remaining())
  {
    ++this->Count;
    return this->Wrong("is longer than 1 MiB");
  }
  this->TakeLine(end ? end : this->Limit);
  if (end)
  {
    this->PassEnd();
  }
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

Error TextLines::Wrong(const std::string& message) const
{
  return { ErrorCode::InvalidInput, "line " + std::to_string(this->Count) + ": " + message };
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
