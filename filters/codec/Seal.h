// SPDX-License-Identifier: BSD-3-Clause
// The head and the checksum of every encoded blob: part of the steps "encode" and "decode" of the
// pipeline picture. A blob begins with its magic and the codec's version. It ends with a checksum
// of all bytes before it. So a blob that was damaged between the store and the viewer (by a proxy,
// a CDN, a disk cache) is refused instead of drawn. Layout: doc/formats.md, section 4.
//
// The checksum finds accidents, not forgeries: decoders never rely on it.
#pragma once

#include "filters/codec/ByteStream.h"
#include "filters/core/Result.h"

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace kdstream
{

// Common to pieces, tree pages and textures; raised when the layout of any of them changes.
inline constexpr std::uint8_t codecVersion = 8;
inline constexpr std::size_t magicSize = 3;
inline constexpr std::size_t blobHeadSize = magicSize + 1; // magic, version
inline constexpr std::size_t checksumSize = 8;             // XXH64, seed 0, little-endian

// Writes magic and version, with which a blob begins. REQUIRES: magic.size() == magicSize.
void WriteBlobHead(ByteWriter& writer, std::string_view magic);

// Appends the checksum of the bytes so far.
void SealBlob(std::vector<std::uint8_t>& blob);

// Whether the blob ends with the checksum of its other bytes, whatever these are. O(size).
bool IsSealed(std::span<const std::uint8_t> blob);

// Checks magic, version and checksum, and returns the blob without its checksum; the content starts
// at blobHeadSize. O(size); allocates nothing. Errors: InvalidInput for another magic; Unsupported
// for an unknown version, which is checked before the checksum, because another version can have
// another checksum; Damaged if the checksum is wrong, or the blob is too short to have one.
// REQUIRES: magic.size() == magicSize.
Result<std::span<const std::uint8_t>> UnsealBlob(
  std::span<const std::uint8_t> blob, std::string_view magic);

}
