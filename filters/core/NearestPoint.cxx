// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/NearestPoint.h"

#include "filters/core/VectorMath.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace kdstream
{

NearestPoint::NearestPoint(std::span<const Vec3> points)
  : Points(points)
  , Order(points.size())
  , Axis(points.size())
{
  std::iota(this->Order.begin(), this->Order.end(), 0U);
  this->Split(0, points.size());
}

void NearestPoint::Split(std::size_t begin, std::size_t end)
{
  if (end - begin < 2)
  {
    return;
  }
  Box box;
  for (std::size_t i = begin; i < end; ++i)
  {
    box.Add(this->Points[this->Order[i]]);
  }
  std::size_t axis = 0;
  for (std::size_t k = 1; k < 3; ++k)
  {
    axis = box.hi[k] - box.lo[k] > box.hi[axis] - box.lo[axis] ? k : axis;
  }
  const std::size_t middle = begin + (end - begin) / 2;
  const auto at = [this](std::size_t i) { return this->Order.begin() + std::ptrdiff_t(i); };
  std::nth_element(at(begin), at(middle), at(end),
    [&](std::uint32_t a, std::uint32_t b)
    {
      const double x = this->Points[a][axis], y = this->Points[b][axis];
      return x < y || (x == y && a < b);
    });
  this->Axis[middle] = static_cast<std::uint8_t>(axis);
  this->Split(begin, middle);
  this->Split(middle + 1, end);
}

void NearestPoint::Search(const Vec3& place, std::size_t begin, std::size_t end, Best& best) const
{
  if (begin == end)
  {
    return;
  }
  const std::size_t middle = begin + (end - begin) / 2;
  const std::uint32_t point = this->Order[middle];
  const Vec3& p = this->Points[point];
  const Vec3 d = Minus(place, p);
  const double squared = Dot(d, d);
  if (squared < best.squared || (squared == best.squared && point < best.point))
  {
    best = { squared, point };
  }
  const double beyond = d[this->Axis[middle]];
  const bool lower = beyond < 0;
  this->Search(place, lower ? begin : middle + 1, lower ? middle : end, best);
  if (beyond * beyond <= best.squared)
  {
    this->Search(place, lower ? middle + 1 : begin, lower ? end : middle, best);
  }
}

std::uint32_t NearestPoint::Find(const Vec3& place) const
{
  Best best{ std::numeric_limits<double>::infinity(), 0 };
  this->Search(place, 0, this->Order.size(), best);
  return best.point;
}

}
