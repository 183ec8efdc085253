// SPDX-License-Identifier: BSD-3-Clause
// Points that are difficult for selection, trees and clusterings: equal, tied, sorted, skewed, far
// from the origin. For tests; the same on every machine.
#pragma once

#include "filters/core/Types.h"

#include <cstddef>
#include <string>
#include <vector>

namespace kdstream::fixtures
{

struct HardPoints
{
  std::string name;
  std::vector<Vec3> points;
  bool fitFloats = false; // whether floats hold every coordinate exactly
};

// Each kind with each number of points.
std::vector<HardPoints> AllHardPoints(const std::vector<std::size_t>& counts);

}
