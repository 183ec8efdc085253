// SPDX-License-Identifier: BSD-3-Clause
// Files that are written at once: notes, pictures, reports, what is exported of a store.
#pragma once

#include "filters/core/Result.h"

#include <filesystem>
#include <string>
#include <string_view>

namespace kdstream
{

// The file has these bytes whole, after a power cut too, or is as it was before: by a NewFile,
// whose words on permissions and links hold. Errors: InputOutput, with the file's name.
Status WriteWhole(const std::filesystem::path& file, std::string_view bytes);

// The same for what a user has named as an output, which may also be a terminal, a pipe, another
// device or a descriptor (/dev/stdout): these are written to. Errors: InputOutput.
Status WriteToOutput(const std::filesystem::path& file, std::string_view bytes);

// A file that is not there yet, in a folder that nobody else writes to: not waited for (SyncTree).
// Errors: InputOutput, with the file's name.
Status WriteAnew(const std::filesystem::path& file, std::string_view bytes);

// Whether the name is that of a descriptor of this process, /dev/stdout or the like: a link that
// leads to what is open, and not to its name.
bool NamesDescriptor(const std::filesystem::path& file);

// Whether it is a regular file, and not a link to one, of exactly these bytes.
bool HasBytes(const std::filesystem::path& file, std::string_view bytes);

enum class Links
{
  Follow,
  Refuse // in a folder that others may write to
};
// All of a file. Errors: NotFound, InputOutput.
Result<std::string> ReadWholeFile(const std::filesystem::path& file, Links links = Links::Follow);

}
