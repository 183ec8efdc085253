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

// The mark that some editors put in front of UTF-8.
inline constexpr std::string_view utf8Mark = "\xEF\xBB\xBF";

// Crops the source to the text itself, and goes to its beginning: after the mark of UTF-8, and up
// to Ctrl-Z and zeros at the end, which blanks may follow. Returns the number of these zeros, in
// the last MiB only. Errors: InvalidInput for text in UTF-16 or UTF-32; InputOutput.
Result<std::uint64_t> CropToText(ByteSource& source);

// Whether the first bytes of a file are text in UTF-16 or UTF-32, with or without a mark.
bool IsWideText(std::string_view begin);
Error WideTextError();

}
