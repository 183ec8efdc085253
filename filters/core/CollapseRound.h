// One round of collapses: from the clusters of a level to those of the next coarser one. For the
// makers of levels alone.
#pragma once

#include "filters/core/EdgeCollapse.h"
#include "filters/core/Execution.h"
#include "filters/core/Merging.h"
#include "filters/core/TriangleBuckets.h"

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
  // interval, partitions ascending. surface: how many clusters with triangles TakeUntil will be
  // asked for: most partitions need not collapse further than that takes. Keeps references to all
  // but `surface`.
  PartitionCollapse(const CollapseState& state, const CollapseSpace& space,
    std::span<const std::uint32_t> partitionOf, std::size_t partitions, std::size_t surface,
    const Execution& execution);

  // Takes the cheapest merges of all partitions until `surface` clusters with triangles are left.
  // Partitions that are stuck with more than their share (surface / partitions) are not made up for
  // by others.
  void TakeUntil();
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
    bool whole = false; // nothing was left out
    std::size_t taken = 0;
  };
  struct Entry
  {
    double error;
    std::size_t partition;
    std::size_t index;
    bool operator<(const Entry& other) const;
  };

  std::size_t Share() const { return this->Surface / this->Lists.size(); }
  std::size_t ToTake(std::size_t first, std::size_t stride) const;
  std::vector<Entry> EntriesOf(std::size_t begin, std::size_t end, std::size_t stride) const;
  void Collapse(std::span<const std::size_t> partitions, double enough);
  void CollapsePartition(std::size_t partition, double enough);
  void Complete(std::size_t begin, std::size_t end);

  const CollapseState& State;
  const CollapseSpace& Space;
  std::span<const std::uint32_t> PartitionOf;
  std::size_t Surface;
  const Execution& Exec;
  TriangleBuckets Buckets;
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
