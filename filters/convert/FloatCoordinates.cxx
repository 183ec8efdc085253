// SPDX-License-Identifier: BSD-3-Clause
#include "filters/convert/FloatCoordinates.h"

#include "filters/core/VectorMath.h"

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
  Box box;
  for (const Vec3& point : read.mesh.points)
  {
    box.Add(point);
  }
  const double largest = largestRead.value_or(LargestCoordinate(box));
  if (FloatsAreCoarse(largest, LongestSideOf(box)))
  {
    std::array<char, 100> text{};
    std::snprintf(text.data(), text.size(),
      "coordinates are read as floats: at %.7g they are %.3g apart", largest, SpacingAt(largest));
    read.warnings.emplace_back(text.data());
  }
}

}
