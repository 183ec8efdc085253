// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/SeededHash.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <random>

namespace kdstream
{

std::uint64_t RandomSeed()
{
  std::random_device random;
  return std::uint64_t{ random() } << 32 | random();
}

std::uint64_t HashOfBytes(std::span<const std::byte> bytes, std::uint64_t seed)
{
  return XXH3_64bits_withSeed(bytes.data(), bytes.size(), seed);
}

std::uint64_t HashOfPlace(const Vec3& place, std::uint64_t seed)
{
  return XXH3_64bits_withSeed(place.data(), sizeof(place), seed);
}

std::uint64_t HashOfPlace(const std::array<float, 3>& place, std::uint64_t seed)
{
  return XXH3_64bits_withSeed(place.data(), sizeof(place), seed);
}

}
