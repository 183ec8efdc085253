// SPDX-License-Identifier: BSD-3-Clause
// What editors and copying put around a text: byte order marks in front, Ctrl-Z and zeros after.
// For all text formats of step "read": below TextLines and TextWords.
#pragma once

#include "filters/core/Result.h"
#include "filters/meshio/ByteSource.h"

#include <cstdint>
#include <string_view>

namespace kdstream
{

// The mark that some editors put in front of UTF-8.
inline constexpr std::string_view utf8Mark = "\xEF\xBB\xBF";

// Crops the source to the text itself and goes to its beginning: after the mark of UTF-8, and up
// to Ctrl-Z and zeros at the end, which blanks may follow. Returns how many of these are zeros; of
// only the last MiB. Errors: InvalidInput for text in UTF-16 or UTF-32; InputOutput.
Result<std::uint64_t> CropToText(ByteSource& source);

// Whether the bytes at the beginning of a file are text in UTF-16 or UTF-32, with a mark or
// without.
bool IsWideText(std::string_view begin);
Error WideTextError();

}
