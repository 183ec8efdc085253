// SPDX-License-Identifier: BSD-3-Clause
// Finds a file's format from its bytes, for messages about files with a wrong extension and about
// formats that are not read.
#pragma once

#include "filters/meshio/ByteSource.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace kdstream
{

// How many of a file's first bytes are enough to tell its format, except for the content of a ZIP
// archive.
inline constexpr std::size_t contentFormatBytes = 512;

// Returns the extension that fits the content: ".ply" if it begins as a PLY file does, and so on;
// empty if unknown. size: the size of the whole file, which identifies a binary STL; 0 if it is not
// known. Weak signs are enough, such as the word "solid" of a text STL, so call this only after
// reading has failed.
std::string_view FormatOfContent(std::string_view begin, std::uint64_t size = 0);

// Says what is wrong with the file and what to do; empty if its content fits its extension. There
// are two cases: a format that is not read ("is an FBX file, which is not read: …", "is compressed
// (.gz): unpack it first, by gunzip", a Git LFS pointer), and a format other than that of the
// extension ("looks like a .ply file, although its name ends in .stl: …"). The names at the end of
// a ZIP archive are read, at most 1 MiB of them. Afterwards the source stands at its beginning. If
// the source cannot be read, the hint is empty.
std::string OtherFormatHint(ByteSource& source, std::string_view ending);

// Says why a file is not read if no reader knows its ending: OtherFormatHint's answer, or else what
// is known about the ending.
std::string UnknownEndingHint(ByteSource& source, std::string_view ending);

}
