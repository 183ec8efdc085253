// SPDX-License-Identifier: BSD-3-Clause
#include "filters/codec/CoordinateGrid.h"

#include <algorithm>
#include <cmath>

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
  // A step below the smallest normal number would divide badly: such a model is one place.
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

std::array<std::uint32_t, 3> CoordinateGrid::Quantize(const Vec3& point) const
{
  const double most = double((std::uint64_t{ 1 } << this->bits) - 1);
  std::array<std::uint32_t, 3> q{};
  for (std::size_t k = 0; k < 3; ++k)
  {
    const double cell = std::floor((point[k] - this->origin[k]) / this->step + 0.5);
    q[k] = static_cast<std::uint32_t>(std::clamp(cell, 0.0, most));
  }
  return q;
}

Vec3 CoordinateGrid::At(const std::array<std::uint32_t, 3>& q) const
{
  return { this->origin[0] + q[0] * this->step, this->origin[1] + q[1] * this->step,
    this->origin[2] + q[2] * this->step };
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
