// SPDX-License-Identifier: BSD-3-Clause
// Sorts triangles by their vertices. If the numbers of the first vertices are close to each other,
// sorts by counting. For images of levels and for pieces.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Types.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace kdstream
{

inline const Triangle& TriangleOf(const Triangle& triangle)
{
  return triangle;
}

inline const Triangle& TriangleOf(const std::pair<Triangle, std::uint32_t>& numbered)
{
  return numbered.first;
}

// The rotation of a triangle that is lexicographically smallest: orientation is kept.
inline Triangle RotateLowestFirst(const Triangle& t)
{
  if (t[0] < t[1] && t[0] < t[2])
  {
    return t;
  }
  const Triangle left{ t[1], t[2], t[0] }, right{ t[2], t[0], t[1] };
  if (t[1] < t[0] && t[1] < t[2])
  {
    return left;
  }
  return t[2] < t[0] && t[2] < t[1] ? right : std::min({ t, left, right });
}

// Sorts items (triangles, or triangles with a number) into `sorted`, a range of the same length.
// Their first vertices are in [first, first + vertices). next: scratch memory. O(items + vertices),
// plus the time to sort items with the same first vertex.
template <class Item>
void SortByTriangle(std::span<const Item> items, VertexId first, std::size_t vertices,
  std::span<Item> sorted, std::vector<std::uint32_t>& next)
{
  next.assign(vertices + 1, 0);
  for (const Item& item : items)
  {
    ++next[TriangleOf(item)[0] - first + 1];
  }
  for (std::size_t v = 0; v < vertices; ++v)
  {
    next[v + 1] += next[v];
  }
  for (const Item& item : items)
  {
    sorted[next[TriangleOf(item)[0] - first]++] = item;
  }
  // next[v] is now the end of v's items.
  for (std::size_t v = 0, begin = 0; v < vertices; begin = next[v++])
  {
    if (next[v] - begin > 1)
    {
      std::sort(sorted.begin() + static_cast<std::ptrdiff_t>(begin),
        sorted.begin() + static_cast<std::ptrdiff_t>(next[v]));
    }
  }
}

// Sorts triangles in place. unique: keeps only one of equal triangles. The result does not depend
// on the number of threads. Time as above; memory: a copy of the triangles. REQUIRES: each triangle
// has its lowest vertex first; all vertices are below `vertices`.
void SortTriangles(std::vector<Triangle>& triangles, std::size_t vertices, bool unique,
  const Execution& execution = {});

}
