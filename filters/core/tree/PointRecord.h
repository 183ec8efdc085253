// SPDX-License-Identifier: BSD-3-Clause
// What a k-d tree is built from: a vertex's coordinates beside its id, so that comparing and moving
// a vertex touches one place in memory, and in a spill file.
#pragma once

#include "filters/core/Types.h"

#include <array>
#include <cstdint>
#include <span>

namespace kdstream
{

// Float: 16 bytes, where floats hold every coordinate exactly; double: 32 bytes. Both give the same
// tree of the same points.
template <class Scalar>
struct PointRecord
{
  std::array<Scalar, 3> p;
  VertexId id;
};

template <>
struct PointRecord<double>
{
  std::array<double, 3> p;
  VertexId id;
  std::uint32_t unused = 0; // no byte of a record is left to chance: records are written to files
};

static_assert(sizeof(PointRecord<float>) == 16 && sizeof(PointRecord<double>) == 32);

// The longest side of a box, the first of equals: the axis that a cell is split along (paper 4.1).
inline std::size_t LongestAxis(const Box& box)
{
  const Vec3 side{ box.hi[0] - box.lo[0], box.hi[1] - box.lo[1], box.hi[2] - box.lo[2] };
  return side[0] >= side[1] && side[0] >= side[2] ? 0 : (side[1] >= side[2] ? 1 : 2);
}

// The box of the records' points; -0.0 counts as 0.0. O(n). REQUIRES: finite coordinates.
template <class Scalar>
Box BoxOfRecords(std::span<const PointRecord<Scalar>> records)
{
  if (records.empty())
  {
    return {};
  }
  // Four records at a time: one minimum alone would wait for the one before.
  constexpr std::size_t lanes = 4;
  std::array<std::array<Scalar, 3>, lanes> lo, hi;
  lo.fill(records[0].p);
  hi.fill(records[0].p);
  const auto add = [&](std::size_t lane, const std::array<Scalar, 3>& p)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      lo[lane][k] = p[k] < lo[lane][k] ? p[k] : lo[lane][k];
      hi[lane][k] = p[k] > hi[lane][k] ? p[k] : hi[lane][k];
    }
  };
  std::size_t i = 0;
  for (; i + lanes <= records.size(); i += lanes)
  {
    for (std::size_t lane = 0; lane < lanes; ++lane)
    {
      add(lane, records[i + lane].p);
    }
  }
  for (; i < records.size(); ++i)
  {
    add(0, records[i].p);
  }
  Box box;
  for (std::size_t lane = 0; lane < lanes; ++lane)
  {
    // + 0.0 makes -0.0 positive: which of the two zeros is met first depends on the order of the
    // records.
    box.Add(
      Vec3{ double(lo[lane][0]) + 0.0, double(lo[lane][1]) + 0.0, double(lo[lane][2]) + 0.0 });
    box.Add(
      Vec3{ double(hi[lane][0]) + 0.0, double(hi[lane][1]) + 0.0, double(hi[lane][2]) + 0.0 });
  }
  return box;
}

}
