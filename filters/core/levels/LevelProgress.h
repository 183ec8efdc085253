// SPDX-License-Identifier: BSD-3-Clause
// How far step "levels" has come: fractions for progress.
#pragma once

#include <cmath>

namespace kdstream
{

// The share of the time of all levels, in memory, that has passed when the components of the finest
// level are found, when its clusters are summed, and when these have positions. Measured on 28
// million triangles.
inline constexpr double componentsFoundPart = 0.06, clustersSummedPart = 0.28,
                        finestMadePart = 0.37;

// The share of the time of all coarser levels that has passed when levels are made down to `depth`.
// `depth` may have a fraction: 11.25 is level 12 and three quarters of level 11. A level takes half
// as long as the next finer one.
inline double CoarserPart(double depth, unsigned finest)
{
  const double whole = std::floor(depth);
  return 1 - std::ldexp(1 + (depth - whole), static_cast<int>(whole) - static_cast<int>(finest));
}

}
