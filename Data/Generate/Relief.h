// SPDX-License-Identifier: BSD-3-Clause
// A closed surface of any size, with fine relief at every scale, for benchmarks that read large
// meshes.
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
  // Not 0: the relief is as fine as that of a ball with this number of points, and there is no
  // grain; so the shape is the same for any number of points. 0: the relief is as fine as the
  // ball's own points allow.
  std::uint64_t detail = 0;
};

// A ball of radius about 1 with relief. The wavelengths of the relief range from half the ball's
// size down to a few edges. Each wave is half as long as the previous one, and a little less than
// half as high. Grain of a fraction of an edge is added, like a scanner's noise.
class Relief
{
public:
  Relief(const CubeGrid& grid, const ReliefOptions& options);

  // The place of a point of the grid. It is the same on every machine, because it is computed only
  // from +, ×, ÷ and roots. REQUIRES: point < grid.Points().
  Vec3 At(std::uint64_t point) const;

private:
  CubeGrid Grid;
  std::uint64_t Seed;
  int Octaves;
  double Grain;
};

// Writes the relief as a binary little-endian PLY file: float x, y, z; triangles of uint. It is
// closed and consistently oriented. The bytes do not depend on how many threads `execution` has.
// Time: O(points); memory: a few blocks of the file. Errors: InputOutput; Cancelled.
Status WriteRelief(const CubeGrid& grid, const ReliefOptions& options,
  const std::filesystem::path& file, const Execution& execution = {});

}
