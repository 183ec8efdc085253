// SPDX-License-Identifier: BSD-3-Clause
// Points for tests that are difficult for selection, trees and clusterings: equal, tied, sorted,
// skewed, far from the origin. They are the same on every machine.
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
  bool fitFloats = false; // whether floats can hold every coordinate exactly
};

// Returns each kind of points with each number of points.
std::vector<HardPoints> AllHardPoints(const std::vector<std::size_t>& counts);

}
