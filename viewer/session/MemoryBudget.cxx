// SPDX-License-Identifier: BSD-3-Clause
// The memory that a viewer may take: see MemoryBudget.h.
#include "viewer/session/MemoryBudget.h"

#include <algorithm>

namespace kdstream
{
namespace
{

// For the default budget:
// - 300,000 visible triangles, which fill a screen of 3 million points at ten points a triangle;
//   500,000 in one level, which is in memory together with the level before it;
// - regions of 200,000 triangles, in addition to these.
constexpr double bytesOfSeenTriangle = 500;
constexpr double bytesOfLevelTriangle = 300;
constexpr double bytesOfRegionTriangle = 750;

// Bytes of pieces for each triangle: two fifths of all bytes, as pieces take two fifths of the
// budget.
constexpr double pieceBytesOfLevelTriangle = 0.4 * bytesOfLevelTriangle;
constexpr double pieceBytesOfRegionTriangle = 0.4 * bytesOfRegionTriangle;

constexpr double smallestPart = 0.2;
constexpr double smaller = 0.8; // factor of the shares at each growth of the memory

}

MemoryShares SharesOfBudgets(std::uint64_t triangles, std::size_t viewBytes)
{
  const auto within = [viewBytes](double each)
  { return static_cast<std::uint64_t>(static_cast<double>(viewBytes) / each); };
  return { viewBytes / 2, standardTreeBytes, viewBytes, triangles,
    std::min(triangles, within(pieceBytesOfLevelTriangle)),
    std::min(triangles / 2, within(pieceBytesOfRegionTriangle)), viewBytes / 2 };
}

MemoryBudget::MemoryBudget(std::size_t bytes)
  : Budget(std::clamp(bytes, least, most))
  , Reached(Budget / 8 * 7)
{
}

MemoryShares MemoryBudget::Shares() const
{
  const double left = this->Part * static_cast<double>(this->Budget);
  const auto bytes = [left](double part) { return static_cast<std::size_t>(part * left); };
  const auto triangles = [left](double each) { return static_cast<std::uint64_t>(left / each); };
  return { bytes(0.4), bytes(0.06), bytes(0.4), triangles(bytesOfSeenTriangle),
    triangles(bytesOfLevelTriangle), triangles(bytesOfRegionTriangle), bytes(0.2) };
}

bool MemoryBudget::Follow(std::size_t taken)
{
  if (taken <= this->Reached)
  {
    return false;
  }
  this->Reached = taken + this->Budget / 64;
  const double before = this->Part;
  this->Part = std::max(this->Part * smaller, smallestPart);
  return this->Part < before;
}

}
