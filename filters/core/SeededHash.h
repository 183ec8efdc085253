// SPDX-License-Identifier: BSD-3-Clause
// Hashes for tables whose keys come from a file. An attacker could choose keys that collide, so
// that each insertion compares all of them. A secret random seed for each run makes it impossible
// to prepare such keys.
#pragma once

#include "filters/core/Types.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace kdstream
{

// A different seed for each call and each process. No result may depend on it.
std::uint64_t RandomSeed();

// The seed of hashes on which several passes, or all ranks of a job, must agree. They only assign
// keys to buckets; no hash table uses them.
inline constexpr std::uint64_t agreedSeed = 0;

// XXH3 with a seed.
std::uint64_t HashOfBytes(std::span<const std::byte> bytes, std::uint64_t seed);

// Hashes the coordinates' bits: -0.0 and 0.0 differ.
std::uint64_t HashOfPlace(const Vec3& place, std::uint64_t seed);
std::uint64_t HashOfPlace(const std::array<float, 3>& place, std::uint64_t seed);

}
