// SPDX-License-Identifier: BSD-3-Clause
// Removes what editors and copying add before and after a text: see PlainText.h.
#include "filters/meshio/PlainText.h"

#include <algorithm>
#include <array>

namespace kdstream
{

bool IsWideText(std::string_view begin)
{
  using namespace std::string_view_literals;
  if (begin.starts_with("\xFF\xFE") || begin.starts_with("\xFE\xFF") ||
      begin.starts_with("\0\0\xFE\xFF"sv))
  {
    return true;
  }
  // In UTF-16, ASCII characters have a zero in each pair of bytes, always at the same position.
  constexpr std::size_t enough = 8;
  std::array<std::size_t, 2> zeros{};
  const std::size_t size = std::min<std::size_t>(begin.size(), 64) / 2 * 2;
  for (std::size_t i = 0; i < size; ++i)
  {
    zeros[i % 2] += begin[i] == '\0' ? 1 : 0;
  }
  return size >= enough &&
         ((zeros[0] == 0 && zeros[1] == size / 2) || (zeros[1] == 0 && zeros[0] == size / 2));
}

Error WideTextError()
{
  return BadInput(
    "is text in UTF-16 or UTF-32, two or four bytes a character: save it as UTF-8 or ASCII",
    Remedy::InMessage);
}

Result<std::uint64_t> CropToText(ByteSource& source)
{
  constexpr std::size_t looked = 64;
  const Result<std::string_view> head = source.Peek(looked);
  KDSTREAM_TRY(head);
  if (IsWideText(head->substr(0, looked)))
  {
    return WideTextError();
  }
  const std::uint64_t begin =
    source.Position() + (head->starts_with(utf8Mark) ? utf8Mark.size() : 0);
  // The last block of the file, without bytes before the text.
  const std::uint64_t from =
    std::max(begin, source.Size() - std::min<std::uint64_t>(source.Size(), ByteSource::blockSize));
  source.Seek(from);
  const Result<std::string_view> tail = source.Peek(static_cast<std::size_t>(source.Size() - from));
  KDSTREAM_TRY(tail);
  std::size_t end = tail->size();
  std::uint64_t zeros = 0;
  for (std::size_t i = tail->size(); i > 0; --i)
  {
    const char c = (*tail)[i - 1];
    if (c == '\0' || c == '\x1A')
    {
      zeros += c == '\0' ? 1 : 0;
      end = i - 1;
    }
    else if (c != ' ' && c != '\n' && c != '\r' && c != '\t')
    {
      break;
    }
  }
  source.Crop(begin, end == tail->size() ? source.Size() : from + end);
  return zeros;
}

}
