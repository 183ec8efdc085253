// One round of collapses: see CollapseRound.h.
#include "filters/core/CollapseRound.h"

#include "filters/core/TriangleBuckets.h"

#include <algorithm>

namespace kdstream
{
namespace
{

// Every partition collapses to this share of its clusters, so that the threshold finds what it
// needs.
constexpr double deepest = 0.25;

Box RelativeBox(const CollapseSpace& space)
{
  Box box;
  box.Add(space.Relative(space.box.lo));
  box.Add(space.Relative(space.box.hi));
  return box;
}

void AppendCluster(
  const CollapseState& state, const CollapseSpace& space, VertexId cluster, CollapsePart& part)
{
  part.positions.push_back(space.Relative(state.level.positions[cluster]));
  part.quadrics.push_back(state.clusters[cluster].quadric);
  const auto values = state.attributes.values.begin() +
                      static_cast<std::ptrdiff_t>(cluster * state.attributes.components);
  part.attributes.insert(part.attributes.end(), values,
    values + static_cast<std::ptrdiff_t>(state.attributes.components));
}

// Area that a cluster's triangles have on average.
double AreaPerCluster(const CollapseState& state)
{
  double area = 0;
  for (const ClusterSum& cluster : state.clusters)
  {
    area += cluster.quadric.Trace();
  }
  return area / double(state.clusters.size());
}

CollapsePart WholeLevel(const CollapseState& state, const CollapseSpace& space)
{
  CollapsePart part;
  part.components = state.attributes.components;
  part.bounds = RelativeBox(space);
  part.keepTopology = false; // handles would take what few vertices there are
  part.positions.reserve(state.clusters.size());
  part.quadrics.reserve(state.clusters.size());
  for (VertexId c = 0; c < state.clusters.size(); ++c)
  {
    AppendCluster(state, space, c, part);
  }
  part.triangles = state.level.triangles;
  part.areaPerVertex = AreaPerCluster(state);
  return part;
}

}

Vec3 CollapseSpace::Absolute(const Vec3& relative) const
{
  Vec3 p;
  for (std::size_t k = 0; k < 3; ++k)
  {
    p[k] = std::clamp(relative[k] + this->origin[k], this->box.lo[k], this->box.hi[k]) + 0.0;
  }
  return p;
}

PartitionCollapse::PartitionCollapse(const CollapseState& state, const CollapseSpace& space,
  std::span<const std::uint32_t> partitionOf, std::size_t partitions, const Execution& execution)
  : AreaPerVertex(AreaPerCluster(state))
  , Lists(partitions)
{
  const TriangleBuckets buckets = BucketTriangles(
    state.level.triangles, partitions, [&](VertexId v) { return partitionOf[v]; }, execution);
  execution.parallelFor(partitions, 1,
    [&](std::size_t begin, std::size_t end)
    {
      for (std::size_t p = begin; p < end; ++p)
      {
        const auto own = std::equal_range(partitionOf.begin(), partitionOf.end(), p);
        this->CollapsePartition(p, state, space, buckets.Of(p),
          static_cast<VertexId>(own.first - partitionOf.begin()),
          static_cast<VertexId>(own.second - partitionOf.begin()));
      }
    });
}

void PartitionCollapse::CollapsePartition(std::size_t partition, const CollapseState& state,
  const CollapseSpace& space, std::span<const std::uint32_t> triangles, VertexId ownBegin,
  VertexId ownEnd)
{
  // Own clusters first, then those of other partitions that the triangles touch.
  std::vector<VertexId> ghosts;
  for (const std::uint32_t t : triangles)
  {
    for (const VertexId v : state.level.triangles[t])
    {
      if (v < ownBegin || v >= ownEnd)
      {
        ghosts.push_back(v);
      }
    }
  }
  std::sort(ghosts.begin(), ghosts.end());
  ghosts.erase(std::unique(ghosts.begin(), ghosts.end()), ghosts.end());
  const VertexId own = ownEnd - ownBegin;

  CollapsePart part;
  part.components = state.attributes.components;
  part.bounds = RelativeBox(space);
  part.areaPerVertex = this->AreaPerVertex;
  part.positions.reserve(own + ghosts.size());
  part.quadrics.reserve(own + ghosts.size());
  for (VertexId c = ownBegin; c < ownEnd; ++c)
  {
    AppendCluster(state, space, c, part);
  }
  for (const VertexId ghost : ghosts)
  {
    AppendCluster(state, space, ghost, part);
  }
  part.fixed.assign(own, 0);
  part.fixed.resize(own + ghosts.size(), 1);
  part.triangles.reserve(triangles.size());
  for (const std::uint32_t t : triangles)
  {
    Triangle local;
    std::transform(state.level.triangles[t].begin(), state.level.triangles[t].end(), local.begin(),
      [&](VertexId v)
      {
        const auto ghost = std::lower_bound(ghosts.begin(), ghosts.end(), v) - ghosts.begin();
        return v >= ownBegin && v < ownEnd ? v - ownBegin : own + static_cast<VertexId>(ghost);
      });
    part.triangles.push_back(local);
  }

  EdgeCollapse engine(std::move(part));
  List& list = this->Lists[partition];
  list.own = engine.VertexCount();
  list.stuck = !engine.Run(static_cast<std::size_t>(deepest * double(list.own)));
  list.merges = engine.Merges();
  for (Merge& merge : list.merges) // fixed clusters are in no merge
  {
    merge.from += ownBegin;
    merge.to += ownBegin;
  }
}

void PartitionCollapse::TakeUntil(std::size_t surface)
{
  std::size_t now = 0, wanted = surface;
  const std::size_t share = surface / this->Lists.size();
  for (const List& list : this->Lists)
  {
    now += list.own;
    const std::size_t least = list.own - std::min(list.own, list.merges.size());
    wanted += list.stuck && least > share ? least - share : 0;
  }
  if (now > wanted)
  {
    this->TakeMore(now - wanted, 0, this->Lists.size());
  }
}

bool PartitionCollapse::TakeMore(std::size_t count, std::size_t begin, std::size_t end)
{
  struct Entry
  {
    double error;
    std::size_t partition;
    std::size_t index;
    bool operator<(const Entry& other) const
    {
      return error != other.error           ? error < other.error
             : partition != other.partition ? partition < other.partition
                                            : index < other.index;
    }
  };
  std::vector<Entry> entries;
  for (std::size_t p = begin; p < end; ++p)
  {
    const List& list = this->Lists[p];
    for (std::size_t i = list.taken; i < list.merges.size(); ++i)
    {
      entries.push_back({ list.merges[i].error, p, i });
    }
  }
  count = std::min(count, entries.size());
  if (count < entries.size())
  {
    std::nth_element(
      entries.begin(), entries.begin() + static_cast<std::ptrdiff_t>(count), entries.end());
  }
  for (std::size_t i = 0; i < count; ++i)
  {
    ++this->Lists[entries[i].partition].taken; // errors never fall along a list
  }
  return count > 0;
}

void PartitionCollapse::Apply(Merging& merging) const
{
  for (const List& list : this->Lists)
  {
    merging.Apply(std::span(list.merges).first(list.taken));
  }
}

FreeCollapse::FreeCollapse(const CollapseState& state, const CollapseSpace& space)
  : Clusters(state.clusters.size())
  , Engine(WholeLevel(state, space))
{
}

void FreeCollapse::Apply(Merging& merging) const
{
  merging.Apply(this->Engine.Merges());
}

}
