// SPDX-License-Identifier: BSD-3-Clause
#include "filters/page/GzipText.h"

#include <zlib.h>

namespace kdstream
{

Result<std::string> GzipText(std::string_view text, int level)
{
  z_stream stream{};
  constexpr int gzip = 16; // added to the bits of the window
  if (deflateInit2(&stream, level, Z_DEFLATED, MAX_WBITS + gzip, 9, Z_DEFAULT_STRATEGY) != Z_OK)
  {
    return Error{ ErrorCode::LimitExceeded, "out of memory for compression" };
  }
  std::string small(deflateBound(&stream, static_cast<uLong>(text.size())), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(small.data());
  stream.avail_out = static_cast<uInt>(small.size());
  deflate(&stream, Z_FINISH); // cannot fail: the buffer is large enough
  small.resize(stream.total_out);
  deflateEnd(&stream);
  return small;
}

}
