// SPDX-License-Identifier: BSD-3-Clause
// A hash of one 64-bit number. Bytes are hashed by XXH3.
#pragma once

#include <cstdint>

namespace kdstream
{

// The finalizer of splitmix64 (Steele, Lea and Flood, "Fast splittable pseudorandom number
// generators", 2014): each bit of `x` changes each bit of the result with a probability of about
// one half. 0 stays 0. It is invertible, so it does not protect against chosen keys: tables whose
// keys come from a file use SeededHash.h.
constexpr std::uint64_t MixBits(std::uint64_t x)
{
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9U;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBU;
  return x ^ (x >> 31);
}

}
