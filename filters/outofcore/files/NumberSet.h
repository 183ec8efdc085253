// SPDX-License-Identifier: BSD-3-Clause
// Ascending numbers, each once, of many that repeat: vertices and clusters of other ranks, hashes.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace kdstream
{

// Memory: `most` numbers, or twice the different ones where these are more. O(log n) a number, on
// average.
template <class Number>
class NumberSet
{
public:
  explicit NumberSet(std::size_t most = std::size_t{ 1 } << 16)
    : Most(most)
  {
  }

  // Reserves memory, so that the first `all` numbers are not moved.
  void Reserve(std::size_t all) { this->Numbers.reserve(std::min(this->Most, all)); }

  void Add(Number number)
  {
    if (this->Numbers.size() >= this->Most)
    {
      this->Compact();
      // There may be more than expected: then memory has to grow, or sorting would never end.
      this->Most = std::max(this->Most, 2 * this->Numbers.size());
    }
    this->Numbers.push_back(number);
  }
  // Returns all numbers, and leaves the set empty.
  std::vector<Number> Take()
  {
    this->Compact();
    return std::exchange(this->Numbers, {});
  }
  // Returns how many numbers there are, and leaves the set empty; keeps its memory.
  std::size_t CountAndClear()
  {
    this->Compact();
    const std::size_t count = this->Numbers.size();
    this->Numbers.clear();
    return count;
  }

private:
  void Compact()
  {
    std::sort(this->Numbers.begin(), this->Numbers.end());
    this->Numbers.erase(
      std::unique(this->Numbers.begin(), this->Numbers.end()), this->Numbers.end());
  }

  std::vector<Number> Numbers;
  std::size_t Most;
};

}
