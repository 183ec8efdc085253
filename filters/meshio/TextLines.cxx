#include "filters/meshio/TextLines.h"

#include <algorithm>

namespace kdstream
{

Result<bool> TextLines::Next()
{
  this->Source.Consume(this->Taken);
  this->Taken = 0;
  ++this->Count;
  Result<std::string_view> ahead = this->Source.Peek(1);
  if (!ahead)
  {
    return ahead.GetError();
  }
  if (ahead->empty())
  {
    return false;
  }
  std::size_t end = ahead->find('\n');
  if (end == std::string_view::npos)
  {
    ahead = this->Source.Peek(ByteSource::blockSize);
    if (!ahead)
    {
      return ahead.GetError();
    }
    end = ahead->find('\n');
  }
  if (end == std::string_view::npos && ahead->size() < this->Source.Remaining())
  {
    return this->Wrong("is longer than 1 MiB");
  }
  this->Taken = std::min(end, ahead->size() - 1) + 1;
  this->Text = ahead->substr(0, end);
  if (!this->Text.empty() && this->Text.back() == '\r')
  {
    this->Text.remove_suffix(1);
  }
  return true;
}

double TextLines::Fraction() const
{
  return double(this->Source.Position()) / std::max(1.0, double(this->Source.Size()));
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
