// SPDX-License-Identifier: BSD-3-Clause
// A closed surface with fine relief at every scale, of any size: what benchmarks of large meshes
// read.
#pragma once

#include "Data/Generate/CubeGrid.h"
#include "filters/core/Execution.h"
#include "filters/core/Types.h"

#include <cstdint>
#include <filesystem>

namespace kdstream::generate
{

struct ReliefOptions
{
  std::uint64_t seed = 1;
  bool shuffledTriangles = false; // in an order that looks random instead of side by side
  bool shuffledPoints = false;
  // Fine relief as a ball of this number of points would have, and no grain: the shape is then the
  // same for any number of points. 0: as fine as the ball's own points allow.
  std::uint64_t detail = 0;
};

// A ball of radius about 1 with relief of wavelengths from half its size down to a few edges, each
// half as long and a little less than half as high as the one before, and grain of a fraction of an
// edge, like a scanner's noise.
class Relief
{
public:
  Relief(const CubeGrid& grid, const ReliefOptions& options);

  // Where a point of the grid is. The same on every machine: nothing but +, ×, ÷ and roots.
  // REQUIRES: point < grid.Points().
  Vec3 At(std::uint64_t point) const;

private:
  CubeGrid Grid;
  std::uint64_t Seed;
  int Octaves;
  double Grain;
};

// As a binary little-endian PLY file: float x, y, z; triangles of uint. Closed and consistently
// oriented. Its bytes do not depend on how many threads `execution` has. O(points) time, memory:
// some blocks of the file. Errors: InputOutput; Cancelled.
Status WriteRelief(const CubeGrid& grid, const ReliefOptions& options,
  const std::filesystem::path& file, const Execution& execution = {});

}
