// SPDX-License-Identifier: BSD-3-Clause
// Room in a vector for what is about to be read in one go: for the readers of step "read".
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace kdstream
{

// Does not give up growth by doubling. REQUIRES: the file has bytes for `count` items.
template <class T>
void MakeRoom(std::vector<T>& items, std::uint64_t count)
{
  const std::size_t wanted = items.size() + static_cast<std::size_t>(count);
  if (wanted > items.capacity())
  {
    items.reserve(std::max(wanted, 2 * items.capacity()));
  }
}

}
