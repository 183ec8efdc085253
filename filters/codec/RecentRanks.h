// SPDX-License-Identifier: BSD-3-Clause
// Remembers the ranks of parents that were stored last, in the same way for reader and writer of
// ancestors. Layout: doc/formats.md, "Ancestors".
//
// Vertices come in the order of the tree, and clusters of a level are ranked by their lowest
// vertices. So a vertex's parent is mostly one that was stored shortly before, or the next one in
// rank.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace kdstream
{

class RecentRanks
{
public:
  // Symbols below this number stand for the ranks stored last, without duplicates: 0 for the very
  // last one.
  static constexpr unsigned recent = 8;
  static constexpr unsigned next = 8;  // stands for the largest rank stored so far + 1, at first 0
  static constexpr unsigned other = 9; // a difference from Newest follows

  // The symbol for a rank.
  unsigned SymbolOf(std::uint64_t rank) const
  {
    const auto* end = this->Last.data() + this->Count;
    const auto* found = std::find(this->Last.data(), end, rank);
    return found != end             ? static_cast<unsigned>(found - this->Last.data())
           : rank == this->NextRank ? next
                                    : other;
  }
  // Finds the rank for a symbol below `recent`. Returns false if there is none.
  bool Find(unsigned symbol, std::uint64_t& rank) const
  {
    if (symbol >= this->Count)
    {
      return false;
    }
    rank = this->Last[symbol];
    return true;
  }
  std::uint64_t Next() const { return this->NextRank; }
  // The rank that was stored last, at first 0. Other ranks are stored as differences from it.
  std::uint64_t Newest() const { return this->Last[0]; }

  // Notes that a rank was stored with this symbol.
  void Use(unsigned symbol, std::uint64_t rank)
  {
    const std::size_t from =
      symbol < recent ? symbol : std::min<std::size_t>(this->Count, recent - 1);
    this->Count = std::max(this->Count, from + 1);
    std::copy_backward(this->Last.begin(), this->Last.begin() + std::ptrdiff_t(from),
      this->Last.begin() + std::ptrdiff_t(from) + 1);
    this->Last[0] = rank;
    this->NextRank = std::max(this->NextRank, rank + 1);
  }

private:
  std::array<std::uint64_t, recent> Last{};
  std::size_t Count = 0;
  std::uint64_t NextRank = 0;
};

}
