// One round of collapses: see CollapseRound.h.
#include "filters/core/CollapseRound.h"

#include "filters/core/TriangleBuckets.h"

#include <algorithm>
#include <limits>

namespace kdstream
{
namespace
{

// Every partition collapses to this share of its clusters, so that the threshold finds what it
// needs.
constexpr double deepest = 0.25;
constexpr std::size_t sampled = 8; // every so many partitions tell where the threshold is
constexpr double beyond = 1.5;     // how far the others go above it

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
  std::span<const std::uint32_t> partitionOf, std::size_t partitions, std::size_t surface,
  const Execution& execution)
  : State(state)
  , Space(space)
  , PartitionOf(partitionOf)
  , Surface(surface)
  , Exec(execution)
  , Buckets(BucketTriangles(
      state.level.triangles, partitions, [&](VertexId v) { return partitionOf[v]; }, execution))
  , AreaPerVertex(AreaPerCluster(state))
  , Lists(partitions)
{
  // Some partitions collapse as far as any may have to. Their threshold is close to that of all:
  // the others go a little beyond it.
  constexpr double everything = std::numeric_limits<double>::infinity();
  const std::size_t stride = partitions < 4 * sampled ? 1 : sampled;
  std::vector<std::size_t> whole, others;
  for (std::size_t p = 0; p < partitions; ++p)
  {
    (p % stride == 0 ? whole : others).push_back(p);
  }
  this->Collapse(whole, everything);
  if (!others.empty())
  {
    std::vector<Entry> entries = this->EntriesOf(0, partitions, stride);
    const std::size_t count = this->ToTake(0, stride);
    double enough = everything;
    if (count < entries.size())
    {
      const auto last = entries.begin() + static_cast<std::ptrdiff_t>(count);
      std::nth_element(entries.begin(), last, entries.end());
      enough = beyond * last->error;
    }
    this->Collapse(others, enough);
  }
}

bool PartitionCollapse::Entry::operator<(const Entry& other) const
{
  return error != other.error           ? error < other.error
         : partition != other.partition ? partition < other.partition
                                        : index < other.index;
}

// How many merges of the partitions first, first + stride … leave what `surface` allows them.
std::size_t PartitionCollapse::ToTake(std::size_t first, std::size_t stride) const
{
  std::size_t now = 0, wanted = this->Surface / stride;
  const std::size_t share = this->Share();
  for (std::size_t p = first; p < this->Lists.size(); p += stride)
  {
    const List& list = this->Lists[p];
    now += list.own;
    const std::size_t least = list.own - std::min(list.own, list.merges.size());
    wanted += list.stuck && least > share ? least - share : 0;
  }
  return now - std::min(now, wanted);
}

// The merges that are not taken yet, of the partitions begin, begin + stride … below end.
std::vector<PartitionCollapse::Entry> PartitionCollapse::EntriesOf(
  std::size_t begin, std::size_t end, std::size_t stride) const
{
  std::vector<Entry> entries;
  for (std::size_t p = begin; p < end; p += stride)
  {
    const List& list = this->Lists[p];
    for (std::size_t i = list.taken; i < list.merges.size(); ++i)
    {
      entries.push_back({ list.merges[i].error, p, i });
    }
  }
  return entries;
}

void PartitionCollapse::Collapse(std::span<const std::size_t> partitions, double enough)
{
  this->Exec.parallelFor(partitions.size(), 1,
    [&](std::size_t begin, std::size_t end)
    {
      for (std::size_t i = begin; i < end; ++i)
      {
        this->CollapsePartition(partitions[i], enough);
      }
    });
}

// Collapses again, as far as any may have to, those of [begin, end) that left something out. What
// they had stays the beginning of their lists.
void PartitionCollapse::Complete(std::size_t begin, std::size_t end)
{
  std::vector<std::size_t> partitions;
  for (std::size_t p = begin; p < end; ++p)
  {
    if (!this->Lists[p].whole)
    {
      partitions.push_back(p);
    }
  }
  this->Collapse(partitions, std::numeric_limits<double>::infinity());
}

// enough: merges that cost more need not all be found, if what is left is no more than the share.
void PartitionCollapse::CollapsePartition(std::size_t partition, double enough)
{
  const CollapseState& state = this->State;
  const CollapseSpace& space = this->Space;
  const std::span<const std::uint32_t> triangles = this->Buckets.Of(partition);
  const auto range =
    std::equal_range(this->PartitionOf.begin(), this->PartitionOf.end(), partition);
  const auto ownBegin = static_cast<VertexId>(range.first - this->PartitionOf.begin());
  const auto ownEnd = static_cast<VertexId>(range.second - this->PartitionOf.begin());
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
  const auto fewest = static_cast<std::size_t>(deepest * double(list.own));
  list.stuck = !engine.Run(std::max(fewest, std::min(list.own, this->Share())));
  if (!list.stuck)
  {
    const bool mayStop = engine.Merges().size() + this->Share() >= list.own;
    list.stuck =
      !engine.RunBeyond(mayStop ? enough : std::numeric_limits<double>::infinity(), fewest);
  }
  list.whole = list.stuck || engine.VertexCount() <= fewest;
  list.merges = engine.Merges();
  for (Merge& merge : list.merges) // fixed clusters are in no merge
  {
    merge.from += ownBegin;
    merge.to += ownBegin;
  }
}

void PartitionCollapse::TakeUntil()
{
  // What was left out costs more than the last merge of its list. Where a threshold is above one of
  // these the lists are completed.
  const std::size_t count = this->ToTake(0, 1);
  std::vector<Entry> entries = this->EntriesOf(0, this->Lists.size(), 1);
  const auto last = entries.begin() + static_cast<std::ptrdiff_t>(std::min(count, entries.size()));
  std::nth_element(entries.begin(), last, entries.end());
  const double most = count > entries.size() ? std::numeric_limits<double>::infinity()
                      : count == 0           ? -1
                                             : std::max_element(entries.begin(), last)->error;
  const bool complete = std::all_of(this->Lists.begin(), this->Lists.end(),
    [&](const List& list)
    { return list.whole || (!list.merges.empty() && list.merges.back().error > most); });
  if (!complete)
  {
    entries = {};
    this->Complete(0, this->Lists.size());
    this->TakeMore(this->ToTake(0, 1), 0, this->Lists.size());
    return;
  }
  for (auto entry = entries.begin(); entry != last; ++entry)
  {
    ++this->Lists[entry->partition].taken; // errors never fall along a list
  }
}

bool PartitionCollapse::TakeMore(std::size_t count, std::size_t begin, std::size_t end)
{
  this->Complete(begin, end);
  std::vector<Entry> entries = this->EntriesOf(begin, end, 1);
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
