// SPDX-License-Identifier: BSD-3-Clause
// A small file that others may be reading: notes, and what is exported of a store.
#pragma once

#include "filters/core/Result.h"

#include <filesystem>
#include <string_view>

namespace kdstream
{

// The file has these bytes whole, or is as it was before: they are written to FILE.new, which then
// takes its place. Errors: InputOutput.
Status WriteWhole(const std::filesystem::path& file, std::string_view bytes);

}
