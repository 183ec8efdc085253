// SPDX-License-Identifier: BSD-3-Clause
// Closes the borders between neighbouring tiles. Their positions were computed from different
// corners, so they differ in the last bits, which would leave cracks.
#pragma once

#include "filters/core/Types.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace kdstream
{

class JoinedBorders
{
public:
  // Remembers the border vertices of the triangles from `first` on: those on edges that belong to a
  // single triangle. tile: the tile of these triangles. box: of these triangles. Time and memory:
  // O(n log n) of them.
  void Add(const Mesh& mesh, std::size_t first, std::uint32_t tile, const Box& box);

  // Moves each border vertex to the nearest one of an earlier tile, if their distance is at most
  // 2^-14 of the longest side of one of the two tiles: tiles are rounded by up to this. The two
  // normals become equal if they nearly are. Vertices that are farther apart stay. Expected time:
  // O(n).
  void Close(Mesh& mesh) const;

private:
  struct Vertex
  {
    VertexId number = 0;
    std::uint32_t tile = 0;
    double reach = 0;
  };
  std::vector<Vertex> Vertices;
};

}
