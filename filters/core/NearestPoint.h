// SPDX-License-Identifier: BSD-3-Clause
// The nearest of a set of points: a small k-d tree for queries.
#pragma once

#include "filters/core/Types.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// The search is exact. Building takes O(k log k) for k points, a query O(log k) on average. Any
// number of threads may search at once.
class NearestPoint
{
public:
  explicit NearestPoint(std::span<const Vec3> points);

  // The number of the nearest point; of equally near ones, the lowest number. REQUIRES: at least
  // one point, and differences whose squares do not overflow.
  std::uint32_t Find(const Vec3& place) const;

private:
  struct Best
  {
    double squared;
    std::uint32_t point;
  };
  void Split(std::size_t begin, std::size_t end);
  void Search(const Vec3& place, std::size_t begin, std::size_t end, Best& best) const;

  std::span<const Vec3> Points;
  std::vector<std::uint32_t> Order; // the middle of every range splits it
  std::vector<std::uint8_t> Axis;   // the axis that each middle splits along
};

}
