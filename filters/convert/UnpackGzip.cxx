// SPDX-License-Identifier: BSD-3-Clause
#include "filters/convert/UnpackGzip.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <memory>

namespace kdstream
{
namespace
{

constexpr std::uint64_t mostTextPerByte = 200, alwaysText = std::uint64_t{ 1 } << 20;

Error Wrong(const std::string& what, std::size_t byte)
{
  return BadInput(
    what + " at byte " + std::to_string(byte) + ", as gunzip reports, too", Remedy::CopyAgain);
}

}

bool IsGzip(std::string_view bytes)
{
  return bytes.starts_with("\x1f\x8b");
}

Result<UnpackedText> UnpackGzip(std::string_view bytes, std::uint64_t most)
{
  most = std::min(most, alwaysText + bytes.size() * mostTextPerByte);
  z_stream stream{};
  constexpr int gzipOnly = 16 + MAX_WBITS;
  if (::inflateInit2(&stream, gzipOnly) != Z_OK)
  {
    return Error{ ErrorCode::InputOutput, "there is no memory to unpack it in" };
  }
  const std::unique_ptr<z_stream, int (*)(z_stream*)> ended(&stream, &::inflateEnd);
  UnpackedText unpacked;
  std::array<char, 1 << 16> block{};
  std::size_t taken = 0; // number of compressed bytes given to zlib
  for (;;)
  {
    // zlib's counter has 32 bits.
    const std::size_t given = std::min<std::size_t>(bytes.size() - taken, 1U << 30U);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data() + taken));
    stream.avail_in = static_cast<uInt>(given);
    stream.next_out = reinterpret_cast<Bytef*>(block.data());
    stream.avail_out = static_cast<uInt>(block.size());
    const int state = ::inflate(&stream, Z_NO_FLUSH);
    taken += given - stream.avail_in;
    unpacked.text.append(block.data(), block.size() - stream.avail_out);
    if (unpacked.text.size() > most)
    {
      return Error{ ErrorCode::LimitExceeded,
        "is compressed (gzip), and its text is longer than " + std::to_string(most) +
          " bytes: unpack it with gunzip and check it",
        {}, {}, Remedy::InMessage };
    }
    if (state == Z_STREAM_END)
    {
      if (!IsGzip(bytes.substr(taken)))
      {
        unpacked.bytesAfter = bytes.size() - taken;
        return unpacked;
      }
      ::inflateReset(&stream);
    }
    else if (state == Z_BUF_ERROR ||
             (state == Z_OK && taken == bytes.size() && stream.avail_out > 0))
    {
      return Wrong("truncated: its compressed text (gzip) ends", bytes.size());
    }
    else if (state != Z_OK)
    {
      return Wrong("its compressed text (gzip) is damaged", taken);
    }
  }
}

}
