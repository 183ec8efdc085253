// SPDX-License-Identifier: BSD-3-Clause
// What is gathered about a cell while its records are written: box, mean, count, and the
// distribution of its coordinates. With these the cell can be split without an extra pass.
#pragma once

#include "filters/core/tree/OrderKey.h"
#include "filters/core/tree/PointRecord.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// Counts the coordinates along one axis in equal bins of their ordered bits between two bounds.
class CoordinateBins
{
public:
  CoordinateBins() = default;
  // All coordinates that are added later must lie in [low, high].
  CoordinateBins(double low, double high, unsigned bits)
    : Low(OrderedBits(low))
  {
    const std::uint64_t extent = OrderedBits(high) - this->Low;
    const auto width = static_cast<unsigned>(std::bit_width(extent));
    this->Shift = width > bits ? width - bits : 0;
    this->Counts.assign(static_cast<std::size_t>(extent >> this->Shift) + 1, 0);
  }

  bool Empty() const { return this->Counts.empty(); }
  void Add(double coordinate)
  {
    ++this->Counts[(OrderedBits(coordinate) - this->Low) >> this->Shift];
  }
  void Add(const CoordinateBins& other)
  {
    for (std::size_t bin = 0; bin < this->Counts.size(); ++bin)
    {
      this->Counts[bin] += other.Counts[bin];
    }
  }

  // The bin that contains the coordinate of `rank`: its bounds, and how many coordinates are below
  // it and in it. REQUIRES: rank is less than the number of coordinates added.
  struct Bin
  {
    std::uint64_t first = 0, last = 0; // OrderedBits, both included
    std::uint64_t below = 0, inside = 0;
  };
  Bin BinOfRank(std::uint64_t rank) const
  {
    Bin bin;
    std::size_t index = 0;
    for (; bin.below + this->Counts[index] <= rank; ++index)
    {
      bin.below += this->Counts[index];
    }
    bin.inside = this->Counts[index];
    bin.first = this->Low + (std::uint64_t{ index } << this->Shift);
    const std::uint64_t width = (std::uint64_t{ 1 } << this->Shift) - 1;
    bin.last = bin.first + std::min(width, ~std::uint64_t{ 0 } - bin.first);
    return bin;
  }

private:
  std::uint64_t Low = 0;
  unsigned Shift = 0;
  std::vector<std::uint32_t> Counts;
};

struct CellStatistics
{
  Box box;
  Vec3 sum{};                         // of the coordinates
  std::array<CoordinateBins, 3> bins; // empty unless wanted

  // Enables the bins too, for a cell whose box lies in `bounds`.
  void WantBins(const Box& bounds, unsigned bits)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      this->bins[k] = CoordinateBins(bounds.lo[k], bounds.hi[k], bits);
    }
  }

  template <class Scalar>
  void Add(std::span<const PointRecord<Scalar>> records)
  {
    this->box.Add(BoxOfRecords<Scalar>(records));
    Vec3 some{};
    for (const PointRecord<Scalar>& record : records)
    {
      for (std::size_t k = 0; k < 3; ++k)
      {
        some[k] += double(record.p[k]);
      }
    }
    for (std::size_t k = 0; k < 3; ++k)
    {
      this->sum[k] += some[k];
    }
    if (!this->bins[0].Empty())
    {
      for (const PointRecord<Scalar>& record : records)
      {
        for (std::size_t k = 0; k < 3; ++k)
        {
          this->bins[k].Add(double(record.p[k]));
        }
      }
    }
  }

  void Add(const CellStatistics& other)
  {
    this->box.Add(other.box);
    for (std::size_t k = 0; k < 3; ++k)
    {
      this->sum[k] += other.sum[k];
      if (!this->bins[k].Empty())
      {
        this->bins[k].Add(other.bins[k]);
      }
    }
  }
};

}
