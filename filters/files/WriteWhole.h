// SPDX-License-Identifier: BSD-3-Clause
// Files that are written at once: notes, pictures, reports, what is exported of a store.
#pragma once

#include "filters/core/Result.h"

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace kdstream
{

// Writes these bytes to a file. Afterwards, also after a power cut, the file has either all of
// these bytes or its old content. By NewFile, which describes permissions and links. Errors:
// InputOutput, with the file's name.
Status WriteWhole(const std::filesystem::path& file, std::string_view bytes);

// The same for an output that a user names. If it is a terminal, a pipe, another device or a
// descriptor (/dev/stdout), the bytes are written to it directly. Errors: InputOutput.
Status WriteToOutput(const std::filesystem::path& file, std::string_view bytes);

// Writes a new file in a folder that nobody else writes to. Does not wait for the disk (SyncTree).
// Errors: InputOutput, with the file's name.
Status WriteAnew(const std::filesystem::path& file, std::string_view bytes);

// Whether the name is that of a descriptor of this process, as /dev/stdout: a link to an open file,
// not to a name.
bool NamesDescriptor(const std::filesystem::path& file);

// Whether it is a regular file, and not a link to one, of exactly these bytes.
bool HasBytes(const std::filesystem::path& file, std::string_view bytes);

enum class Links
{
  Follow,
  Refuse // in a folder that others may write to
};
// Reads a whole file. Errors: NotFound, InputOutput; LimitExceeded if it has more than mostBytes: it
// may be a device without an end.
Result<std::string> ReadWholeFile(const std::filesystem::path& file, Links links = Links::Follow,
  std::size_t mostBytes = std::size_t{ 64 } << 20);

}
