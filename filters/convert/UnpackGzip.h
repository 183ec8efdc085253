// SPDX-License-Identifier: BSD-3-Clause
// Decompresses text that gzip has compressed, as many VRML scenes are. Part of step "convert" of
// the pipeline picture.
#pragma once

#include "filters/core/Result.h"

#include <cstdint>
#include <string>
#include <string_view>

namespace kdstream
{

// Whether the bytes begin as a gzip file does.
bool IsGzip(std::string_view bytes);

struct UnpackedText
{
  std::string text;
  std::uint64_t bytesAfter = 0; // bytes after the compressed data; they are left out
};

// Decompresses gzip data, also if it has several members in a row. Memory: the text, which grows as
// it is decompressed, never because of a claimed length. Errors: InvalidInput naming the byte, for
// truncated or damaged data; LimitExceeded for more than `most` bytes of text, or for more than 200
// bytes of text for each byte of the file, which real scenes do not reach.
Result<UnpackedText> UnpackGzip(std::string_view bytes, std::uint64_t most);

}
