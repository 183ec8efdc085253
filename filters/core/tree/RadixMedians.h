// SPDX-License-Identifier: BSD-3-Clause
// Finds the medians of all nodes of a depth at once, for vertices that are spread over several
// ranks (paper 4.1, step c). Works on the bits of keys, so that ranks exchange counts, not
// vertices.
//
// Steps:
// 1. Each rank counts its keys by their highest bits.
// 2. The counts are added over the ranks: the bin that holds a node's median gives the median's
//    highest bits.
// 3. The same for the next bits, among the keys that begin with the known bits.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/tree/KdTree.h"
#include "filters/core/tree/OrderKey.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace kdstream
{

class RadixMedians
{
public:
  // The lowest key of the upper half of each node of a depth. vertices: their number in the whole
  // tree, on all ranks. forEachKey(visit) -> Status calls visit(node, key) for all vertices of this
  // rank, with nodes from 0 to 2^depth - 1, and visits the same in each call. sum(counts) -> Status
  // adds the counts of all ranks, element by element. Makes 6 to 24 passes, each with one sum of at
  // most 8 MiB, or 16 counts a node. REQUIRES: all ranks call it together; all keys differ.
  template <class ForEachKey, class Sum>
  static Result<std::vector<OrderKey>> Find(
    std::uint64_t vertices, unsigned depth, const ForEachKey& forEachKey, const Sum& sum)
  {
    const std::size_t nodes = std::size_t{ 1 } << depth;
    const unsigned digit = DigitFor(nodes, vertices);
    const std::size_t binsOfNode = std::size_t{ 1 } << digit;
    std::vector<OrderKey> known(nodes); // the bits found so far; the rest is 0
    std::vector<std::uint64_t> rest;    // the median's place among keys with these bits, from 0
    for (std::size_t node = 0; node < nodes; ++node)
    {
      rest.push_back(RangeOfCell(vertices, depth + 1, 2 * node).size);
    }
    for (unsigned shift = bitsOfKey; shift > 0;)
    {
      shift -= digit;
      std::vector<std::uint64_t> bins(nodes * binsOfNode, 0);
      KDSTREAM_TRY(forEachKey(
        [&](std::size_t node, const OrderKey& key)
        {
          bins[node * binsOfNode + KeyBits(key, shift, digit)] +=
            BeginsWith(key, known[node], shift + digit) ? 1 : 0;
        }));
      KDSTREAM_TRY(sum(bins));
      for (std::size_t node = 0; node < nodes; ++node)
      {
        std::size_t bin = node * binsOfNode;
        while (bin + 1 < (node + 1) * binsOfNode && rest[node] >= bins[bin])
        {
          rest[node] -= bins[bin++];
        }
        const std::uint64_t bits = bin - node * binsOfNode;
        (shift >= 32 ? known[node].coordinate : known[node].id) |=
          bits << (shift >= 32 ? shift - 32 : shift);
      }
    }
    return known;
  }

private:
  static constexpr unsigned bitsOfKey = 96; // 64 of the coordinate, 32 of the id

  // The number of bits that a pass finds for each node. Fewer nodes allow more bits: the bins take
  // at most 8 MiB (or 16 counts a node), and are fewer than the vertices.
  static unsigned DigitFor(std::size_t nodes, std::uint64_t vertices)
  {
    if (nodes <= 4 && vertices >= std::uint64_t{ 1 } << 16)
    {
      return 16;
    }
    return nodes <= std::size_t{ 1 } << 12 ? 8 : 4;
  }

  // The `bits` bits of a key that are above its lowest `shift` bits.
  static std::uint64_t KeyBits(const OrderKey& key, unsigned shift, unsigned bits)
  {
    const std::uint64_t from = shift >= 32 ? key.coordinate >> (shift - 32) : key.id >> shift;
    return from & ((std::uint64_t{ 1 } << bits) - 1);
  }

  // Whether two keys agree in all bits above their lowest `shift` bits.
  static bool BeginsWith(const OrderKey& a, const OrderKey& b, unsigned shift)
  {
    if (shift >= bitsOfKey)
    {
      return true;
    }
    return shift >= 32 ? a.coordinate >> (shift - 32) == b.coordinate >> (shift - 32)
                       : a.coordinate == b.coordinate && a.id >> shift == b.id >> shift;
  }
};

}
