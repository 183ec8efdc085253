// SPDX-License-Identifier: BSD-3-Clause
// Which format a file has by its bytes: for messages about files whose ending says otherwise, and
// about formats that are not read.
#pragma once

#include "filters/meshio/ByteSource.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace kdstream
{

// Bytes of a file that are enough, but for what is in a ZIP archive.
inline constexpr std::size_t contentFormatBytes = 512;

// ".ply" for what begins as a PLY file does, and so on; empty if it is not known. size: of the
// whole file, by which a binary STL is known, or 0. A name that says nothing, such as "solid" of a
// text STL, is enough: use it where reading has failed.
std::string_view FormatOfContent(std::string_view begin, std::uint64_t size = 0);

// What is wrong with the file and what to do; empty if its content fits its ending. There are two
// cases: a format that is not read ("is an FBX file, which is not read: …", "is compressed (.gz):
// unpack it first, by gunzip", a pointer of Git LFS), and a format other than that of the ending
// ("looks like a .ply file, although its name ends in .stl: …"). The names at the end of a ZIP
// archive are read, at most 1 MiB of them. Afterwards the source stands at its beginning. A source
// that cannot be read has no hint.
std::string OtherFormatHint(ByteSource& source, std::string_view ending);

// Why a file is not read whose ending no reader has: the hint, or what is known of the ending.
std::string UnknownEndingHint(ByteSource& source, std::string_view ending);

}
