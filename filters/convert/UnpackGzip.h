// SPDX-License-Identifier: BSD-3-Clause
// Text that was compressed by gzip, as most scenes of VRML were when lines were slow. Part of step
// "convert" of the pipeline picture.
#pragma once

#include "filters/core/Result.h"

#include <cstdint>
#include <string>
#include <string_view>

namespace kdstream
{

// Whether a file begins as gzip's do.
bool IsGzip(std::string_view bytes);

struct UnpackedText
{
  std::string text;
  std::uint64_t behind = 0; // bytes after the compressed ones, which are left out
};

// What gzip has compressed, several parts in a row too. Memory: the text, which grows with what is
// there and never with what a length claims. Errors: InvalidInput naming the byte, for what is cut
// off or damaged; LimitExceeded for more than `most` bytes of text, or than 200 for each byte of
// the file, which no scene comes to.
Result<UnpackedText> UnpackGzip(std::string_view bytes, std::uint64_t most);

}
