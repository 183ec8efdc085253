// SPDX-License-Identifier: BSD-3-Clause
// Which corners of triangles lie outside an interval of vertices: the ghosts of a block of a mesh
// or of a level.
#pragma once

#include "filters/core/RadixSort.h"
#include "filters/core/Types.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

class GhostCorners
{
public:
  // The corners whose vertices are not in [first, end). O(corners); memory 8 bytes for each, 16
  // while they are sorted. REQUIRES: 3 × triangles < 2^32.
  GhostCorners(std::span<const Triangle> triangles, VertexId first, VertexId end)
  {
    for (std::size_t corner = 0; corner < 3 * triangles.size(); ++corner)
    {
      const VertexId v = triangles[corner / 3][corner % 3];
      if (v < first || v >= end)
      {
        this->Corners.push_back(std::uint64_t{ v } << 32 | corner);
      }
    }
    SortByUpperHalf(this->Corners);
  }

  // The vertices at these corners, ascending, without duplicates.
  std::vector<VertexId> Vertices() const
  {
    std::vector<VertexId> vertices;
    for (const std::uint64_t entry : this->Corners)
    {
      const auto v = static_cast<VertexId>(entry >> 32);
      if (vertices.empty() || vertices.back() != v)
      {
        vertices.push_back(v);
      }
    }
    return vertices;
  }

  // Replaces each of these corners in `triangles` by replace(index of the corner's vertex in
  // Vertices()). REQUIRES: the same number of triangles as before.
  template <class Replace>
  void ReplaceIn(std::span<Triangle> triangles, const Replace& replace) const
  {
    std::size_t place = 0;
    for (std::size_t i = 0; i < this->Corners.size(); ++i)
    {
      place += i > 0 && this->Corners[i] >> 32 != this->Corners[i - 1] >> 32;
      const auto corner = static_cast<std::uint32_t>(this->Corners[i]);
      triangles[corner / 3][corner % 3] = replace(place);
    }
  }

private:
  std::vector<std::uint64_t> Corners; // sorted: vertex << 32 | (3 × triangle + corner)
};

}
