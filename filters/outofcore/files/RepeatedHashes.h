// SPDX-License-Identifier: BSD-3-Clause
// Which of many hashes may occur more than once. Code that looks for equal things can skip the
// others.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace kdstream
{

// Finds hashes that may occur more than once. Hashes fall into classes by their upper halves. There
// are two bits for each class: seen once, and seen again. Equal hashes are in one class. Of n
// different hashes in c classes, about n^2 / c share a class with another. Add all hashes first,
// then look them up.
class RepeatedHashes
{
public:
  // count: how many hashes there will be. memory: bytes for the bits; at most 8 bytes a hash are
  // used.
  RepeatedHashes(std::uint64_t count, std::uint64_t memory)
    : Words(
        std::clamp<std::uint64_t>(std::min(memory, 8 * count) / 16, 1, std::uint64_t{ 1 } << 26))
    , Seen(static_cast<std::size_t>(this->Words), 0)
    , Twice(static_cast<std::size_t>(this->Words), 0)
  {
  }

  // Adds hashes; may be called by several threads. Returns how many of them fell into a class that
  // had been seen before.
  template <class Hashes>
  std::uint64_t Add(const Hashes& hashes)
  {
    std::uint64_t repeats = 0;
    for (const std::uint64_t hash : hashes)
    {
      const std::uint64_t place = this->PlaceOf(hash), bit = std::uint64_t{ 1 } << (place & 63);
      const auto word = static_cast<std::size_t>(place >> 6);
      if ((std::atomic_ref(this->Seen[word]).fetch_or(bit, std::memory_order_relaxed) & bit) != 0)
      {
        std::atomic_ref(this->Twice[word]).fetch_or(bit, std::memory_order_relaxed);
        ++repeats;
      }
    }
    return repeats;
  }

  // Call it after all hashes were added: frees half of the memory.
  void Finish() { this->Seen = {}; }

  // Whether this hash may occur more than once: its class was seen again.
  bool MayRepeat(std::uint64_t hash) const
  {
    const std::uint64_t place = this->PlaceOf(hash);
    return (this->Twice[static_cast<std::size_t>(place >> 6)] >> (place & 63) & 1) != 0;
  }

private:
  std::uint64_t PlaceOf(std::uint64_t hash) const
  {
    return (hash >> 32) * (this->Words << 6) >> 32;
  }

  std::uint64_t Words;
  std::vector<std::uint64_t> Seen, Twice;
};

}
