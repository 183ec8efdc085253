// SPDX-License-Identifier: BSD-3-Clause
// Ascending numbers, each once, of many that repeat: vertices and clusters of other ranks, hashes.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace kdstream
{

// Memory: twice the different numbers. O(log n) a number, on average.
template <class Number>
class NumberSet
{
public:
  void Add(Number number)
  {
    this->Numbers.push_back(number);
    if (this->Numbers.size() >= this->Most)
    {
      this->Compact();
      this->Most = std::max(this->Most, 2 * this->Numbers.size());
    }
  }
  // All so far; none are left.
  std::vector<Number> Take()
  {
    this->Compact();
    return std::exchange(this->Numbers, {});
  }

private:
  void Compact()
  {
    std::sort(this->Numbers.begin(), this->Numbers.end());
    this->Numbers.erase(
      std::unique(this->Numbers.begin(), this->Numbers.end()), this->Numbers.end());
  }

  std::vector<Number> Numbers;
  std::size_t Most = std::size_t{ 1 } << 16;
};

}
