// SPDX-License-Identifier: BSD-3-Clause
// Writes whole files at once: notes, pictures, reports, exports of a store.
#pragma once

#include "filters/core/Result.h"

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace kdstream
{

// Writes these bytes to a file. Afterwards, even after a power cut, the file has either all of
// these bytes or its old content. Uses NewFile; see there for permissions and links. Errors:
// InputOutput, with the file's name.
Status WriteWhole(const std::filesystem::path& file, std::string_view bytes);

// The same for an output that a user names. If it is a terminal, a pipe, another device or a
// descriptor (/dev/stdout), the bytes are written to it directly. Errors: InputOutput.
Status WriteToOutput(const std::filesystem::path& file, std::string_view bytes);

// Writes a new file in a folder to which nobody else writes. Does not wait for the disk (see
// SyncTree). Errors: InputOutput, with the file's name.
Status WriteAnew(const std::filesystem::path& file, std::string_view bytes);

// Whether the name is that of a descriptor of this process, such as /dev/stdout: a link to an open
// file instead of a name.
bool NamesDescriptor(const std::filesystem::path& file);

// Whether it is a regular file, not a link to one, with exactly these bytes.
bool HasBytes(const std::filesystem::path& file, std::string_view bytes);

enum class Links
{
  Follow,
  Refuse // for folders to which other users may write
};
// Reads a whole file. Errors: NotFound, InputOutput; LimitExceeded if it has more than mostBytes,
// because it can be a device without an end.
Result<std::string> ReadWholeFile(const std::filesystem::path& file, Links links = Links::Follow,
  std::size_t mostBytes = std::size_t{ 64 } << 20);

}
