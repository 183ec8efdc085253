// SPDX-License-Identifier: BSD-3-Clause
// The records from which a k-d tree is built: a vertex's coordinates and its id together. So
// comparing or moving a vertex accesses one place in memory, or in a spill file.
#pragma once

#include "filters/core/Types.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace kdstream
{

// Scalar: float (16 bytes) if floats hold every coordinate exactly, otherwise double (32 bytes).
// Both give the same tree for the same points.
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
  std::uint32_t unused = 0; // records are written to files, so no byte may be undefined
};

static_assert(sizeof(PointRecord<float>) == 16 && sizeof(PointRecord<double>) == 32);

// The longest side of a box, the first of equals: the axis that a cell is split along (paper 4.1).
inline std::size_t LongestAxis(const Box& box)
{
  const Vec3 side{ box.hi[0] - box.lo[0], box.hi[1] - box.lo[1], box.hi[2] - box.lo[2] };
  return side[0] >= side[1] && side[0] >= side[2] ? 0 : (side[1] >= side[2] ? 1 : 2);
}

// The lowest and the highest coordinates of some records. One instruction compares all axes of a
// whole record; the lanes beside the coordinates, which hold the id, may contain anything.
template <class Scalar>
class RecordBox
{
public:
  explicit RecordBox(const PointRecord<Scalar>& first)
  {
    std::memcpy(this->Lowest, &first, sizeof(first));
    std::memcpy(this->Highest, &first, sizeof(first));
  }
  void Add(const PointRecord<Scalar>& record)
  {
    Vector lanes[vectors];
    std::memcpy(lanes, &record, sizeof(record));
    this->Add(lanes, lanes);
  }
  void Add(const RecordBox& other) { this->Add(other.Lowest, other.Highest); }
  // -0.0 becomes 0.0: which of the two zeros is met first depends on the order of the records.
  Box Corners() const
  {
    PointRecord<Scalar> lowest, highest;
    std::memcpy(&lowest, this->Lowest, sizeof(lowest));
    std::memcpy(&highest, this->Highest, sizeof(highest));
    Box box;
    for (std::size_t k = 0; k < 3; ++k)
    {
      box.lo[k] = double(lowest.p[k]) + 0.0;
      box.hi[k] = double(highest.p[k]) + 0.0;
    }
    return box;
  }

private:
  typedef Scalar Vector __attribute__((vector_size(16)));
  static constexpr std::size_t vectors = sizeof(PointRecord<Scalar>) / sizeof(Vector);

  void Add(const Vector* low, const Vector* high)
  {
    for (std::size_t i = 0; i < vectors; ++i)
    {
      this->Lowest[i] = low[i] < this->Lowest[i] ? low[i] : this->Lowest[i];
      this->Highest[i] = high[i] > this->Highest[i] ? high[i] : this->Highest[i];
    }
  }

  Vector Lowest[vectors], Highest[vectors];
};

// The box of the records' points; -0.0 counts as 0.0. O(n). REQUIRES: finite coordinates.
template <class Scalar>
Box BoxOfRecords(std::span<const PointRecord<Scalar>> records)
{
  if (records.empty())
  {
    return {};
  }
  // Two boxes in turn: with a single one, each minimum would wait for the previous minimum.
  RecordBox<Scalar> even(records[0]), odd(records[0]);
  std::size_t i = 0;
  for (; i + 2 <= records.size(); i += 2)
  {
    even.Add(records[i]);
    odd.Add(records[i + 1]);
  }
  if (i < records.size())
  {
    even.Add(records[i]);
  }
  even.Add(odd);
  return even.Corners();
}

}
