// SPDX-License-Identifier: BSD-3-Clause
#include "filters/convert/FloatCoordinates.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

namespace kdstream
{
namespace
{

constexpr double coarsest = 1e-6; // relative to the longest side

// The distance between neighbouring floats.
double SpacingAt(double largest)
{
  const auto at = static_cast<float>(largest);
  return double(std::nextafter(at, std::numeric_limits<float>::infinity())) - double(at);
}

}

bool FloatsAreCoarse(double largest, double side)
{
  return largest > 0 && SpacingAt(largest) > coarsest * side;
}

void WarnOfFloats(ForeignMesh& read, std::optional<double> largestRead)
{
  constexpr double infinity = std::numeric_limits<double>::infinity();
  std::array<double, 3> least{ infinity, infinity, infinity };
  std::array<double, 3> most{ -infinity, -infinity, -infinity };
  for (const Vec3& point : read.mesh.points)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      least[k] = std::min(least[k], point[k]);
      most[k] = std::max(most[k], point[k]);
    }
  }
  double largest = 0, side = 0;
  for (std::size_t k = 0; k < 3 && !read.mesh.points.empty(); ++k)
  {
    largest = std::max({ largest, std::abs(least[k]), std::abs(most[k]) });
    side = std::max(side, most[k] - least[k]);
  }
  largest = largestRead.value_or(largest);
  if (FloatsAreCoarse(largest, side))
  {
    std::array<char, 100> text{};
    std::snprintf(text.data(), text.size(),
      "coordinates are read as floats: at %.7g they are %.3g apart", largest, SpacingAt(largest));
    read.warnings.emplace_back(text.data());
  }
}

}
