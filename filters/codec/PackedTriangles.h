// SPDX-License-Identifier: BSD-3-Clause
// Sorts a piece's triangles, fast if it has few vertices.
#pragma once

#include "filters/codec/Sorting.h"
#include "filters/core/Types.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace kdstream
{

// Packs each triangle into one number, with the first corner in the highest bits, so that numbers
// sort as triangles do. Sorts by counting: by the second corner, then by the first; then sorts the
// few triangles that have both corners in common. O(triangles + vertices), unless many have both in
// common.
class PackedTriangles
{
public:
  static constexpr unsigned bits = 21; // of a corner

  // REQUIRES: vertices <= 2^bits.
  PackedTriangles(std::size_t most, std::size_t vertices)
    : Vertices(vertices)
    , Packed(new std::uint64_t[2 * most])
    , Counts(2 * (vertices + 1))
  {
  }

  // Adds a triangle, rotated so that its number is smallest. This compares numbers, without
  // branches that are hard to predict. REQUIRES: corners < vertices, at most `most` triangles.
  void Add(std::uint64_t a, std::uint64_t b, std::uint64_t c)
  {
    const std::uint64_t least =
      std::min(std::min((a << bits | b) << bits | c, (b << bits | c) << bits | a),
        (c << bits | a) << bits | b);
    this->Packed[this->Count++] = least;
    ++this->Counts[First(least) + 1];
    ++this->Counts[this->Vertices + 1 + Second(least) + 1];
  }

  // Call it at most once. REQUIRES: triangles.size() is the number of triangles that were added.
  void Sort(std::span<Triangle> triangles)
  {
    std::uint64_t *from = this->Packed.get(), *to = from + this->Count;
    // Where the triangles begin that have a corner first, and second.
    std::uint32_t* first = this->Counts.data();
    std::uint32_t* second = first + this->Vertices + 1;
    for (std::size_t v = 0; v < this->Vertices; ++v)
    {
      first[v + 1] += first[v];
      second[v + 1] += second[v];
    }
    for (std::size_t t = 0; t < this->Count; ++t)
    {
      to[second[Second(from[t])]++] = from[t];
    }
    for (std::size_t t = 0; t < this->Count; ++t)
    {
      from[first[First(to[t])]++] = to[t];
    }
    this->SortSameEdges();
    for (std::size_t t = 0; t < this->Count; ++t)
    {
      triangles[t] = { First(from[t]), Second(from[t]), static_cast<VertexId>(from[t] & mask) };
    }
  }

private:
  static constexpr std::uint64_t mask = (1U << bits) - 1;

  static VertexId First(std::uint64_t packed) { return static_cast<VertexId>(packed >> 2 * bits); }
  static VertexId Second(std::uint64_t packed)
  {
    return static_cast<VertexId>(packed >> bits & mask);
  }
  void SortSameEdges()
  {
    std::uint64_t* all = this->Packed.get();
    for (std::size_t t = 1; t < this->Count; ++t)
    {
      if (all[t] < all[t - 1])
      {
        std::size_t begin = t - 1, end = t + 1;
        for (; begin > 0 && all[begin - 1] >> bits == all[t] >> bits; --begin)
        {
        }
        for (; end < this->Count && all[end] >> bits == all[t] >> bits; ++end)
        {
        }
        SortFew(all + begin, end - begin, std::less<>());
        t = end;
      }
    }
  }

  std::size_t Vertices, Count = 0;
  std::unique_ptr<std::uint64_t[]> Packed;
  std::vector<std::uint32_t> Counts;
};

}
