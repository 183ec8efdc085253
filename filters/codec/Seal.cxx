// SPDX-License-Identifier: BSD-3-Clause
#include "filters/codec/Seal.h"

#include <algorithm>
#include <array>

// Only XXH64: the rest of the library would only make the web page larger.
#define XXH_INLINE_ALL
#define XXH_NO_XXH3
#include <xxhash.h>

namespace kdstream
{
namespace
{

std::array<std::uint8_t, checksumSize> ChecksumOf(std::span<const std::uint8_t> bytes)
{
  const std::uint64_t hash = XXH64(bytes.data(), bytes.size(), 0);
  std::array<std::uint8_t, checksumSize> checksum{};
  for (std::size_t i = 0; i < checksumSize; ++i)
  {
    checksum[i] = static_cast<std::uint8_t>(hash >> (8 * i));
  }
  return checksum;
}

}

void WriteBlobHead(ByteWriter& writer, std::string_view magic)
{
  for (const char letter : magic)
  {
    writer.Byte(static_cast<std::uint8_t>(letter));
  }
  writer.Byte(codecVersion);
}

void SealBlob(std::vector<std::uint8_t>& blob)
{
  const auto checksum = ChecksumOf(blob);
  blob.insert(blob.end(), checksum.begin(), checksum.end());
}

bool IsSealed(std::span<const std::uint8_t> blob)
{
  if (blob.size() < checksumSize)
  {
    return false;
  }
  const auto checksum = ChecksumOf(blob.first(blob.size() - checksumSize));
  return std::equal(checksum.begin(), checksum.end(), blob.end() - std::ptrdiff_t(checksumSize));
}

Result<std::span<const std::uint8_t>> UnsealBlob(
  std::span<const std::uint8_t> blob, std::string_view magic)
{
  const std::size_t head = std::min(blob.size(), magicSize);
  if (!std::equal(blob.begin(), blob.begin() + std::ptrdiff_t(head), magic.begin(),
        [](std::uint8_t byte, char letter) { return byte == static_cast<std::uint8_t>(letter); }))
  {
    return Error{ ErrorCode::InvalidInput, "does not begin with \"" + std::string(magic) + "\"" };
  }
  // Checked before the checksum, because another version can have another checksum, or none. The
  // message "damaged" would make the user look for a fault, while only a newer viewer is needed.
  if (blob.size() > magicSize && blob[magicSize] != codecVersion)
  {
    return Error{ ErrorCode::Unsupported, "unknown codec version " +
                                            std::to_string(blob[magicSize]) +
                                            ": this viewer knows " + std::to_string(codecVersion) };
  }
  if (blob.size() < blobHeadSize + checksumSize)
  {
    return Error{ ErrorCode::Damaged,
      "truncated: " + std::to_string(blob.size()) + " bytes are too short for any content" };
  }
  if (!IsSealed(blob))
  {
    return Error{ ErrorCode::Damaged, "its checksum is wrong" };
  }
  return blob.first(blob.size() - checksumSize);
}

}
