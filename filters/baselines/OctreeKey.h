// SPDX-License-Identifier: BSD-3-Clause
// The place of a point in an octree: the cube of the root, and the Morton key of the deepest cell.
#pragma once

#include "filters/core/Types.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace kdstream
{

// The sides of the deepest cells are 1/2^21 of the root's. These cells are never split. So vertices
// that are nearer to each other may form a cluster of more than N.
inline constexpr unsigned octreeDeepest = 21;

// The cube of the root: it has the centre of the vertices' box, and its longest side.
class OctreeCube
{
public:
  // REQUIRES: `box` contains points, and its sides are finite.
  explicit OctreeCube(const Box& box)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      this->Side = std::max(this->Side, box.hi[k] - box.lo[k]);
    }
    for (std::size_t k = 0; k < 3; ++k)
    {
      this->Lo[k] = box.lo[k] - (this->Side - (box.hi[k] - box.lo[k])) / 2;
    }
  }

  // 63 bits: three for each depth from the root's children down; x is the lowest of the three. The
  // cell of depth d is key >> 3 (octreeDeepest - d).
  std::uint64_t KeyOf(const Vec3& p) const
  {
    constexpr auto cells = static_cast<double>(std::uint64_t{ 1 } << octreeDeepest);
    std::uint64_t key = 0;
    for (std::size_t k = 0; k < 3; ++k)
    {
      // If all points are in one place, the side is zero. Rounding may move the ends out of the
      // cube.
      const double place = this->Side > 0 ? (p[k] - this->Lo[k]) / this->Side * cells : 0;
      key |= Spread(static_cast<std::uint64_t>(std::clamp(place, 0.0, cells - 1))) << k;
    }
    return key;
  }

private:
  // Inserts two zero bits before each of the 21 low bits.
  static std::uint64_t Spread(std::uint64_t bits)
  {
    bits = (bits | bits << 32) & 0x001F00000000FFFFU;
    bits = (bits | bits << 16) & 0x001F0000FF0000FFU;
    bits = (bits | bits << 8) & 0x100F00F00F00F00FU;
    bits = (bits | bits << 4) & 0x10C30C30C30C30C3U;
    return (bits | bits << 2) & 0x1249249249249249U;
  }

  Vec3 Lo{};
  double Side = 0;
};

}
