// SPDX-License-Identifier: BSD-3-Clause
// Finds a file's format by its bytes: for messages about files with a wrong extension, and about
// formats that are not read.
#pragma once

#include "filters/meshio/ByteSource.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace kdstream
{

// Bytes of a file that are enough, except for the content of a ZIP archive.
inline constexpr std::size_t contentFormatBytes = 512;

// ".ply" for content that begins as a PLY file does, and so on; empty if unknown. size: of the
// whole file, which identifies a binary STL, or 0. Weak signs, such as "solid" of a text STL, are
// enough; so use it only after reading has failed.
std::string_view FormatOfContent(std::string_view begin, std::uint64_t size = 0);

// What is wrong with the file and what to do; empty if its content fits its extension. There are
// two cases: a format that is not read ("is an FBX file, which is not read: …", "is compressed
// (.gz): unpack it first, by gunzip", a pointer of Git LFS), and a format other than that of the
// extension ("looks like a .ply file, although its name ends in .stl: …"). The names at the end of
// a ZIP archive are read, at most 1 MiB of them. Afterwards the source stands at its beginning. If
// the source cannot be read, the hint is empty.
std::string OtherFormatHint(ByteSource& source, std::string_view ending);

// Why a file is not read whose ending no reader has: the hint, or what is known of the ending.
std::string UnknownEndingHint(ByteSource& source, std::string_view ending);

}
