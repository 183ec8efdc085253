// SPDX-License-Identifier: BSD-3-Clause
// A set of numbers, filled from many that repeat: vertices and clusters of other ranks, hashes.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace kdstream
{

// Memory: `most` numbers, or twice the number of distinct ones if that is more. Adding takes O(log
// n) a number on average.
template <class Number>
class NumberSet
{
public:
  explicit NumberSet(std::size_t most = std::size_t{ 1 } << 16)
    : Most(most)
  {
  }

  // Reserves memory for `all` numbers, or for `most` if that is less, so that adding does not move
  // them.
  void Reserve(std::size_t all) { this->Numbers.reserve(std::min(this->Most, all)); }

  void Add(Number number)
  {
    if (this->Numbers.size() >= this->Most)
    {
      this->Compact();
      // There may be more distinct numbers than expected. Then memory must grow, or every Add would
      // sort.
      this->Most = std::max(this->Most, 2 * this->Numbers.size());
    }
    this->Numbers.push_back(number);
  }
  // Returns the distinct numbers in ascending order, and leaves the set empty.
  std::vector<Number> Take()
  {
    this->Compact();
    return std::exchange(this->Numbers, {});
  }
  // Returns how many distinct numbers there are, and empties the set; keeps its memory.
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
