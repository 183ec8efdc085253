// One round of collapses: from the clusters of a level to those of the next coarser one. For the
// makers of levels alone.
#pragma once

#include "filters/core/EdgeCollapse.h"
#include "filters/core/Execution.h"
#include "filters/core/Merging.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// Where the positions of a state are taken from, and where vertices may go. Absolute.
struct CollapseSpace
{
  Vec3 origin{}; // of the clusters' sums
  Box box;       // the model's

  Vec3 Relative(const Vec3& p) const
  {
    return { p[0] - this->origin[0], p[1] - this->origin[1], p[2] - this->origin[2] };
  }
  // Inside the box, without -0.0.
  Vec3 Absolute(const Vec3& relative) const;
};

// The collapses of all partitions, each on its own with the clusters of others fixed, in parallel.
class PartitionCollapse
{
public:
  // partitionOf: the partition of each cluster of the state; clusters of one partition are in one
  // interval, partitions ascending.
  PartitionCollapse(const CollapseState& state, const CollapseSpace& space,
    std::span<const std::uint32_t> partitionOf, std::size_t partitions, const Execution& execution);

  // Takes the cheapest merges of all partitions until `surface` clusters with triangles would be
  // left. Partitions that are stuck with more than their share (surface / partitions) are not made
  // up for by others.
  void TakeUntil(std::size_t surface);
  // Takes the cheapest `count` more, of the partitions [begin, end); fewer where they have no more.
  // Returns whether any.
  bool TakeMore(std::size_t count, std::size_t begin, std::size_t end);
  void Apply(Merging& merging) const;

private:
  struct List
  {
    std::vector<Merge> merges; // in the ids of the state
    std::size_t own = 0;       // vertices with triangles at first
    bool stuck = false;
    std::size_t taken = 0;
  };

  void CollapsePartition(std::size_t partition, const CollapseState& state,
    const CollapseSpace& space, std::span<const std::uint32_t> triangles, VertexId ownBegin,
    VertexId ownEnd);

  double AreaPerVertex;
  std::vector<List> Lists;
};

// Collapses the whole level, below S.
class FreeCollapse
{
public:
  FreeCollapse(const CollapseState& state, const CollapseSpace& space);

  bool Run(std::size_t vertices, std::size_t triangles)
  {
    return this->Engine.Run(vertices, triangles);
  }
  // Only vertices for which movable(v) is true may collapse from now on.
  template <class Movable>
  void Restrict(const Movable& movable)
  {
    for (VertexId v = 0; v < this->Clusters; ++v)
    {
      if (!movable(v))
      {
        this->Engine.Fix(v);
      }
    }
  }
  std::size_t VertexCount() const { return this->Engine.VertexCount(); }
  void Apply(Merging& merging) const;

private:
  std::size_t Clusters;
  EdgeCollapse Engine;
};

}
