// SPDX-License-Identifier: BSD-3-Clause
// Removes what editors and copying add to a text: byte order marks at the beginning, Ctrl-Z and
// zeros at the end. For all text formats of step "read": below TextLines and TextWords.
#pragma once

#include "filters/core/Result.h"
#include "filters/meshio/ByteSource.h"

#include <cstdint>
#include <string_view>

namespace kdstream
{

// The byte order mark that some editors put before UTF-8 text.
inline constexpr std::string_view utf8Mark = "\xEF\xBB\xBF";

// Crops the source to the text itself, and goes to its beginning. The text begins after a UTF-8
// byte order mark. It ends before Ctrl-Z and zeros at the end, even if blanks follow these. Returns
// the number of these zeros, counting only the last MiB. Errors: InvalidInput for text in UTF-16 or
// UTF-32; InputOutput.
Result<std::uint64_t> CropToText(ByteSource& source);

// Whether the first bytes of a file are text in UTF-16 or UTF-32, with or without a mark.
bool IsWideText(std::string_view begin);
Error WideTextError();

}
