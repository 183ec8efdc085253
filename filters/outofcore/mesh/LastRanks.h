// SPDX-License-Identifier: BSD-3-Clause
// Finds vertices in the same place while the vertices are visited in the order of the leaves. For
// code that looks for coincident vertices (CoincidentRanks.h, filters/Parallel).
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

// The vertex with its rank as id, and without negative zeros.
template <class Scalar>
PointRecord<Scalar> RankedPlace(const PointRecord<Scalar>& vertex, VertexId rank)
{
  const std::array<Scalar, 3>& p = vertex.p;
  return { { p[0] + Scalar(0), p[1] + Scalar(0), p[2] + Scalar(0) }, rank };
}

// Remembers the rank that was added last at each place.
template <class Scalar>
class LastRanks
{
public:
  static constexpr std::uint64_t bytesPerPlace = 80; // of the table, including its growth

  // visit(a, b): called with ranks a < b at one place, if none of the ranks between them is at that
  // place. Keeps a reference.
  explicit LastRanks(const std::function<Status(VertexId, VertexId)>& visit)
    : Visit(visit)
  {
  }

  // REQUIRES: `vertex` is a RankedPlace; ranks ascend. Errors: those of `visit`.
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
