// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. Find the two lowest and the two highest coordinates along each axis.
// 2. Compute the box without each of the outermost points.
#include "filters/app/StrayPoint.h"

#include "filters/meshio/MeshReader.h"

#include <algorithm>
#include <array>
#include <limits>

namespace kdstream
{
namespace
{

struct Outermost
{
  double first = -std::numeric_limits<double>::infinity();
  double second = -std::numeric_limits<double>::infinity(); // of a different point
  StrayPoint owner;                                         // the point of `first`

  void Add(double value, std::uint64_t number, const Vec3& place)
  {
    if (value > this->first)
    {
      this->second = this->first;
      this->first = value;
      this->owner.number = number;
      this->owner.place = place;
    }
    else
    {
      this->second = std::max(this->second, value);
    }
  }
  double Without(std::uint64_t number) const
  {
    return this->owner.number == number ? this->second : this->first;
  }
};

// For each axis the outermost upwards, and downwards (with the opposite sign).
using Ends = std::array<std::array<Outermost, 2>, 3>;

double LongestSide(const Ends& ends, std::uint64_t without)
{
  double longest = 0;
  for (const auto& [high, low] : ends)
  {
    longest = std::max(longest, high.Without(without) + low.Without(without));
  }
  return longest;
}

}

std::optional<StrayPoint> FindStrayPoint(
  const std::filesystem::path& file, const Execution& execution)
{
  constexpr std::size_t block = std::size_t{ 1 } << 16;
  constexpr double leastShrinking = 10;
  const Result<std::unique_ptr<MeshReader>> reader = MeshReader::Open(file, execution);
  if (!reader)
  {
    return {};
  }
  Ends ends;
  std::uint64_t number = 0;
  for (;;)
  {
    Mesh mesh;
    const Result<std::size_t> read = (*reader)->ReadVertices(mesh, block);
    if (!read || !execution.Report("stray", 0))
    {
      return {};
    }
    if (*read == 0)
    {
      break;
    }
    for (const Vec3& point : mesh.points)
    {
      for (std::size_t k = 0; k < 3; ++k)
      {
        ends[k][0].Add(point[k], number, point);
        ends[k][1].Add(-point[k], number, point);
      }
      ++number;
    }
  }
  if (number < 3)
  {
    return {};
  }
  const double whole = LongestSide(ends, number);
  std::optional<StrayPoint> found;
  double shortest = whole / leastShrinking;
  for (const auto& axis : ends)
  {
    for (const Outermost& end : axis)
    {
      const double without = LongestSide(ends, end.owner.number);
      if (without > 0 && without <= shortest)
      {
        shortest = without;
        found = end.owner;
        found->shrinks = whole / without;
      }
    }
  }
  return found;
}

}
