// SPDX-License-Identifier: BSD-3-Clause
// Peers of the piece codec: Draco, meshoptimizer and zstd for a small mesh on an integer grid.
#pragma once

#include "filters/core/Types.h"

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace kdstream::bench
{

// Positions on the model's grid, and triangles; peers get nothing else.
struct GridMesh
{
  std::vector<std::array<std::uint32_t, 3>> points;
  std::vector<Triangle> triangles;
};

// A coder's result for one mesh. vertices, triangles: the numbers after decoding, because peers may
// drop some.
struct Coded
{
  std::size_t bytes = 0;
  double encodeSeconds = 0, decodeSeconds = 0;
  std::size_t vertices = 0, triangles = 0;
};

// Edgebreaker and parallelograms. Coordinates are integers, so that nothing is quantized again.
// speed: 0 (smallest) to 10.
Coded CodeByDraco(const GridMesh& mesh, int speed);

// Vertex and index codecs, after the reordering that they require.
Coded CodeByMeshoptimizer(const GridMesh& mesh);

// zstd at `level`. The numbers of vertices and triangles in the result are 0.
Coded CodeByZstd(std::span<const std::uint8_t> bytes, int level);

}
