// SPDX-License-Identifier: BSD-3-Clause
// Which vertices, in the order of the leaves, are in the same place: for code that looks for
// coincident ones (CoincidentRanks.h, filters/Parallel).
#pragma once

#include "filters/core/Result.h"
#include "filters/core/SeededHash.h"
#include "filters/core/Types.h"
#include "filters/core/tree/PointRecord.h"

#include <array>
#include <cstdint>
#include <functional>
#include <unordered_map>
#include <utility>

namespace kdstream
{

// A vertex whose id is its rank, and no zero is negative.
template <class Scalar>
PointRecord<Scalar> RankedPlace(const PointRecord<Scalar>& vertex, VertexId rank)
{
  const std::array<Scalar, 3>& p = vertex.p;
  return { { p[0] + Scalar(0), p[1] + Scalar(0), p[2] + Scalar(0) }, rank };
}

// Which rank was met last in each place.
template <class Scalar>
class LastRanks
{
public:
  static constexpr std::uint64_t bytesPerPlace = 80; // of the table, while it grows too

  // visit(a, b): ranks a < b in one place that have none of it between them. Keeps a reference.
  explicit LastRanks(const std::function<Status(VertexId, VertexId)>& visit)
    : Visit(visit)
  {
  }

  // REQUIRES: a RankedPlace; ranks ascend. Errors: those of `visit`.
  Status Add(const PointRecord<Scalar>& vertex)
  {
    const auto [found, isNew] = this->Last.try_emplace(vertex.p, vertex.id);
    return isNew ? Status{} : this->Visit(std::exchange(found->second, vertex.id), vertex.id);
  }
  void Clear() { this->Last.clear(); }

private:
  struct Hash
  {
    std::uint64_t seed = RandomSeed();
    std::size_t operator()(const std::array<Scalar, 3>& place) const
    {
      return HashOfPlace(place, this->seed);
    }
  };

  const std::function<Status(VertexId, VertexId)>& Visit;
  std::unordered_map<std::array<Scalar, 3>, VertexId, Hash> Last;
};

}
