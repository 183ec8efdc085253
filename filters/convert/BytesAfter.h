// SPDX-License-Identifier: BSD-3-Clause
// Handles bytes after the end of the data that a file declares: they are reported, not refused.
#pragma once

#include "filters/meshio/ByteSource.h"
#include "filters/meshio/Tolerance.h"

#include <algorithm>
#include <functional>
#include <string>

namespace kdstream
{

// Whether all bytes from `begin` to `end` are zeros. REQUIRES: end <= source.Size().
inline Result<bool> AreZeros(ByteSource& source, std::uint64_t begin, std::uint64_t end)
{
  source.Seek(begin);
  while (begin < end)
  {
    const auto view = source.Peek(
      static_cast<std::size_t>(std::min<std::uint64_t>(ByteSource::blockSize, end - begin)));
    KDSTREAM_TRY(view);
    const std::string_view bytes = view->substr(0, end - begin);
    if (bytes.empty() || bytes.find_first_not_of('\0') != std::string_view::npos)
    {
      return false;
    }
    source.Consume(bytes.size());
    begin += bytes.size();
  }
  return true;
}

// Counts the bytes from `begin` to `end`. Zeros are padding. If the length is a multiple of
// `elementBytes`, the bytes count as elements, unless areElements (if given) denies it. counted:
// the number of elements before these bytes. Returns the number of further elements.
inline Result<std::uint64_t> CheckBytesAfter(ByteSource& source, std::uint64_t begin,
  std::uint64_t end, std::uint64_t elementBytes, std::uint64_t counted, Tolerance& tolerance,
  const std::function<Result<bool>(std::uint64_t elements)>& areElements = {})
{
  const std::uint64_t rest = end - begin;
  const Result<bool> zeros = AreZeros(source, begin, end);
  KDSTREAM_TRY(zeros);
  const std::uint64_t more = elementBytes > 0 ? rest / elementBytes : 0;
  bool are = !*zeros && more > 0 && rest % elementBytes == 0;
  if (are && areElements)
  {
    const Result<bool> reported = areElements(more);
    KDSTREAM_TRY(reported);
    are = *reported;
  }
  if (are)
  {
    tolerance.Count(Lapse::NotCounted, more, "point " + std::to_string(counted));
    return more;
  }
  tolerance.Count(
    *zeros ? Lapse::PaddedEnd : Lapse::BytesAfterEnd, rest, "byte " + std::to_string(begin));
  return std::uint64_t{ 0 };
}

}
