// SPDX-License-Identifier: BSD-3-Clause
// Which format a file has by its first bytes: for messages about files whose ending says otherwise.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace kdstream
{

// Bytes of a file that are enough.
inline constexpr std::size_t contentFormatBytes = 512;

// ".ply" for what begins as a PLY file does, and so on; empty if it is not known. size: of the
// whole file, by which a binary STL is known, or 0. A name that says nothing, such as "solid" of a
// text STL, is enough: use it where reading has failed.
std::string_view FormatOfContent(std::string_view begin, std::uint64_t size = 0);

// "is compressed (.gz): unpack it first, by gunzip" for what begins as such files and archives do,
// or that it is a pointer of Git LFS; else empty.
std::string CompressedHint(std::string_view begin);

// The same; or "looks like a .ply file, although its name ends in .stl", and what to do, where the
// content is of another format than the ending; else empty.
std::string OtherFormatHint(std::string_view begin, std::string_view ending, std::uint64_t size);

}
