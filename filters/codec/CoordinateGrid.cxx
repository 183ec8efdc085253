// SPDX-License-Identifier: BSD-3-Clause
#include "filters/codec/CoordinateGrid.h"

#include <algorithm>
#include <limits>

namespace kdstream
{

CoordinateGrid CoordinateGrid::Over(const Box& box, std::uint8_t bits, ScalarType scalarType)
{
  CoordinateGrid grid;
  grid.bits = bits;
  grid.scalarType = scalarType;
  double longest = 0;
  for (std::size_t k = 0; k < 3; ++k)
  {
    grid.origin[k] = box.Empty() ? 0 : box.lo[k];
    longest = box.Empty() ? 0 : std::max(longest, box.hi[k] - box.lo[k]);
  }
  const double cells = double((std::uint64_t{ 1 } << bits) - 1);
  // A step below the smallest normal number would give wrong quotients; then the whole model counts
  // as one point.
  grid.step = longest / cells >= std::numeric_limits<double>::min() ? longest / cells : 1;
  return grid;
}

CoordinateGrid CoordinateGrid::Exact(ScalarType scalarType)
{
  CoordinateGrid grid;
  grid.bits = 0;
  grid.scalarType = scalarType;
  return grid;
}

CoordinateGrid CoordinateGrid::Spaced(std::uint32_t steps) const
{
  CoordinateGrid grid = *this;
  grid.spacing = this->Lossless() ? 1 : steps;
  return grid;
}

std::uint32_t CoordinateGrid::SpacingFor(double geometricError) const
{
  constexpr unsigned fewestBits = 8;
  if (this->Lossless())
  {
    return 1;
  }
  const double most = double(std::uint32_t{ 1 } << (this->bits - fewestBits));
  // A coordinate moves by up to half a spacing.
  return static_cast<std::uint32_t>(std::clamp(geometricError / 4 / (this->step / 2), 1.0, most));
}

std::array<std::uint32_t, 3> CoordinateGrid::Quantize(const Vec3& point) const
{
  const double most = this->Most(), width = this->step * this->spacing;
  std::array<std::uint32_t, 3> q{};
  for (std::size_t k = 0; k < 3; ++k)
  {
    const double cell = (point[k] - this->origin[k]) / width + 0.5;
    q[k] = static_cast<std::uint32_t>(std::clamp(cell, 0.0, most)); // rounded down
  }
  return q;
}

Vec3 CoordinateGrid::Snap(const Vec3& point) const
{
  if (!this->Lossless())
  {
    return this->At(this->Quantize(point));
  }
  if (this->scalarType == ScalarType::Float64)
  {
    return point;
  }
  return { double(float(point[0])), double(float(point[1])), double(float(point[2])) };
}

}
