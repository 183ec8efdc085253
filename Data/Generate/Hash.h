// SPDX-License-Identifier: BSD-3-Clause
// Orders and numbers that look random but are computed on the fly: nothing is kept in memory.
#pragma once

#include <bit>
#include <cstdint>

namespace kdstream::generate
{

// Hashes a number (the finalizer of MurmurHash3, by A. Appleby).
constexpr std::uint64_t Hash(std::uint64_t x)
{
  x = (x ^ (x >> 33)) * 0xFF51AFD7ED558CCDu;
  x = (x ^ (x >> 33)) * 0xC4CEB9FE1A85EC53u;
  return x ^ (x >> 33);
}

// A permutation of 0 … count - 1 that needs no memory. It is a Feistel network over the smallest
// power of two that is not less than `count`, applied again until the value is below `count` (cycle
// walking: Black and Rogaway, "Ciphers with arbitrary finite domains", 2002). A call takes fewer
// than two steps on average. The same seed gives the same permutation. Not cryptographic.
class Permutation
{
public:
  // REQUIRES: 0 < count <= 2^62.
  Permutation(std::uint64_t count, std::uint64_t seed)
    : Count(count)
    , LowBits(static_cast<unsigned>(std::bit_width(count - 1) + 1) / 2)
    , LowMask((std::uint64_t{ 1 } << LowBits) - 1)
    , HighMask((std::uint64_t{ 1 } << (std::bit_width(count - 1) - LowBits)) - 1)
  {
    for (unsigned round = 0; round < rounds; ++round)
    {
      this->Keys[round] = Hash(seed * rounds + round + 0x9E3779B97F4A7C15u);
    }
  }

  // REQUIRES: i < count.
  std::uint64_t operator()(std::uint64_t i) const
  {
    do
    {
      i = this->Forward(i);
    } while (i >= this->Count);
    return i;
  }

  // The inverse permutation: Inverse((*this)(i)) == i.
  std::uint64_t Inverse(std::uint64_t i) const
  {
    do
    {
      i = this->Backward(i);
    } while (i >= this->Count);
    return i;
  }

private:
  static constexpr unsigned rounds = 4;

  std::uint64_t Forward(std::uint64_t i) const
  {
    std::uint64_t low = i & this->LowMask, high = i >> this->LowBits;
    for (unsigned round = 0; round < rounds; round += 2)
    {
      high ^= Hash(low ^ this->Keys[round]) & this->HighMask;
      low ^= Hash(high ^ this->Keys[round + 1]) & this->LowMask;
    }
    return high << this->LowBits | low;
  }

  std::uint64_t Backward(std::uint64_t i) const
  {
    std::uint64_t low = i & this->LowMask, high = i >> this->LowBits;
    for (unsigned round = rounds; round > 0; round -= 2)
    {
      low ^= Hash(high ^ this->Keys[round - 1]) & this->LowMask;
      high ^= Hash(low ^ this->Keys[round - 2]) & this->HighMask;
    }
    return high << this->LowBits | low;
  }

  std::uint64_t Count;
  unsigned LowBits; // bits in the lower half of a number
  std::uint64_t LowMask, HighMask;
  std::uint64_t Keys[rounds];
};

}
