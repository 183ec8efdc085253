// SPDX-License-Identifier: BSD-3-Clause
// Borders of tiles beside each other: their places were computed from other corners, so they differ
// in the last bits, and would leave cracks.
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
  // Keeps the vertices of the triangles from `first` on that lie on edges of a single triangle.
  // tile: whose they are. box: of these triangles. Time and memory: O(n log n) of them.
  void Add(const Mesh& mesh, std::size_t first, std::uint32_t tile, const Box& box);

  // Moves each of them to the nearest one of an earlier tile, if that is not farther than 2^-14 of
  // the longest side of one of the two: as far as tiles are rounded. Their normals become one if
  // they nearly are. What is farther apart stays. Expected time: O(n).
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
