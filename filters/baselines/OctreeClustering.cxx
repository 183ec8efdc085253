// SPDX-License-Identifier: BSD-3-Clause
// Octree clustering: see OctreeClustering.h. Steps:
//   a. Compute for each vertex the 63-bit Morton key of its cell at the deepest level.
//   b. Split cells: sort their records into eight, by three bits of the key, in place.
//   c. Number the leaves in Morton order.
#include "filters/baselines/OctreeClustering.h"

#include "filters/core/Extent.h"
#include "filters/core/Weld.h"

#include <algorithm>
#include <array>
#include <queue>
#include <string>
#include <vector>

namespace kdstream
{
namespace
{

struct Record
{
  std::uint64_t key;
  VertexId id;
};

// The records [begin, end) of one cell.
struct Cell
{
  VertexId begin = 0, end = 0;
  unsigned depth = 0;

  std::uint32_t Size() const { return this->end - this->begin; }
  bool CanSplit() const { return this->depth < octreeDeepest; }
};

class Octree
{
public:
  Octree(std::span<const Vec3> points, const Box& box, const Execution& execution)
    : Records(points.size())
    , Scratch(points.size())
  {
    const OctreeCube cube(box);
    execution.parallelFor(points.size(), 1 << 14,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t i = begin; i < end; ++i)
        {
          this->Records[i] = { cube.KeyOf(points[i]), static_cast<VertexId>(i) };
        }
      });
  }

  Cell Root() const { return { 0, static_cast<VertexId>(this->Records.size()), 0 }; }

  // Sorts the records of the cell into its children, and calls add(child) for each that is not
  // empty, in Morton order. Cells that do not overlap can be split at the same time. REQUIRES:
  // cell.CanSplit().
  template <class Add>
  void Split(const Cell& cell, const Add& add)
  {
    const unsigned shift = 3 * (octreeDeepest - 1 - cell.depth);
    const auto childOf = [shift](const Record& record)
    { return static_cast<std::size_t>(record.key >> shift & 7); };
    std::array<VertexId, 9> begin{};
    for (VertexId i = cell.begin; i < cell.end; ++i)
    {
      ++begin[childOf(this->Records[i]) + 1];
    }
    begin[0] = cell.begin;
    for (std::size_t child = 0; child < 8; ++child)
    {
      begin[child + 1] += begin[child];
    }
    std::array<VertexId, 9> next = begin;
    for (VertexId i = cell.begin; i < cell.end; ++i)
    {
      this->Scratch[next[childOf(this->Records[i])]++] = this->Records[i];
    }
    std::copy(this->Scratch.data() + cell.begin, this->Scratch.data() + cell.end,
      this->Records.data() + cell.begin);
    for (std::size_t child = 0; child < 8; ++child)
    {
      if (begin[child + 1] > begin[child])
      {
        add(Cell{ begin[child], begin[child + 1], cell.depth + 1 });
      }
    }
  }

  // Appends the leaves below `cell`; cells of more than `most` vertices are split.
  void Finish(const Cell& cell, std::uint32_t most, std::vector<Cell>& leaves)
  {
    if (cell.Size() <= most || !cell.CanSplit())
    {
      leaves.push_back(cell);
      return;
    }
    this->Split(cell, [&](const Cell& child) { this->Finish(child, most, leaves); });
  }

  // Numbers the leaves in the order of their records. REQUIRES: the leaves cover all records.
  OctreeClustering Number(std::vector<Cell>& leaves) const
  {
    std::sort(
      leaves.begin(), leaves.end(), [](const Cell& a, const Cell& b) { return a.begin < b.begin; });
    OctreeClustering clustering;
    clustering.clusterOf.resize(this->Records.size());
    for (const Cell& leaf : leaves)
    {
      clustering.depth = std::max(clustering.depth, leaf.depth);
      for (VertexId i = leaf.begin; i < leaf.end; ++i)
      {
        clustering.clusterOf[this->Records[i].id] = clustering.clusters;
      }
      ++clustering.clusters;
    }
    return clustering;
  }

private:
  std::vector<Record> Records;
  std::vector<Record> Scratch;
};

// Returns the leaves; cells of more than `most` vertices are split.
Result<std::vector<Cell>> SplitByCount(
  Octree& octree, std::uint32_t most, const Execution& execution)
{
  // Splits large cells first, until there are enough for all threads; then each is finished
  // separately.
  constexpr std::size_t enough = 64;
  std::vector<Cell> cells{ octree.Root() };
  bool split = true;
  while (split && cells.size() < enough)
  {
    split = false;
    std::vector<Cell> next;
    for (const Cell& cell : cells)
    {
      if (cell.Size() <= most || !cell.CanSplit())
      {
        next.push_back(cell);
        continue;
      }
      split = true;
      octree.Split(cell, [&](const Cell& child) { next.push_back(child); });
    }
    cells = std::move(next);
    KDSTREAM_TRY(execution.Report("octree", 0.5));
  }
  std::vector<std::vector<Cell>> leavesOf(cells.size());
  execution.parallelFor(cells.size(), 1,
    [&](std::size_t begin, std::size_t end)
    {
      for (std::size_t i = begin; i < end; ++i)
      {
        octree.Finish(cells[i], most, leavesOf[i]);
      }
    });
  std::vector<Cell> leaves;
  for (const std::vector<Cell>& some : leavesOf)
  {
    leaves.insert(leaves.end(), some.begin(), some.end());
  }
  return leaves;
}

struct Searched
{
  std::vector<Cell> leaves;
  std::uint32_t most = 0;
};

// The leaves for the N that gives the number of leaves nearest to `wanted`.
Result<Searched> SearchCount(Octree& octree, std::uint32_t wanted, const Execution& execution)
{
  // The fullest cells first. The order among cells of the same count does not matter, because all
  // of them are split.
  const auto less = [](const Cell& a, const Cell& b) { return a.Size() < b.Size(); };
  std::priority_queue<Cell, std::vector<Cell>, decltype(less)> open(less);
  std::vector<Cell> closed; // at the deepest level
  open.push(octree.Root());
  std::vector<Cell> parents; // cells that were split in the last round
  std::size_t leaves = 1, before = 1;
  std::uint32_t most = octree.Root().Size(), mostBefore = most;
  while (leaves < wanted && !open.empty() && open.top().Size() > 1)
  {
    // One round: split all cells with the largest count, and also children that have the same
    // count.
    const std::uint32_t size = open.top().Size();
    parents.clear();
    before = leaves;
    mostBefore = most;
    while (!open.empty() && open.top().Size() == size)
    {
      const Cell cell = open.top();
      open.pop();
      parents.push_back(cell);
      --leaves;
      octree.Split(cell,
        [&](const Cell& child)
        {
          ++leaves;
          child.CanSplit() ? open.push(child) : closed.push_back(child);
        });
    }
    most = open.empty() ? 1 : open.top().Size();
    const double done = std::min(1.0, double(leaves) / double(wanted));
    KDSTREAM_TRY(execution.Report("octree", 0.5 + 0.5 * done));
  }
  Searched result{ std::move(closed), most };
  for (; !open.empty(); open.pop())
  {
    result.leaves.push_back(open.top());
  }
  if (leaves > wanted && leaves - wanted >= wanted - before)
  {
    // Undo the last round: the cells that it split are leaves again, instead of the leaves inside
    // them.
    result.most = mostBefore;
    std::vector<Cell> kept;
    std::sort(parents.begin(), parents.end(),
      [](const Cell& a, const Cell& b)
      { return a.begin != b.begin ? a.begin < b.begin : a.depth < b.depth; });
    // If a cell has only one child, both were split in the round. The upper one becomes the leaf.
    parents.erase(std::unique(parents.begin(), parents.end(),
                    [](const Cell& a, const Cell& b) { return a.begin == b.begin; }),
      parents.end());
    for (const Cell& leaf : result.leaves)
    {
      const auto above = std::upper_bound(parents.begin(), parents.end(), leaf,
        [](const Cell& a, const Cell& b) { return a.begin < b.begin; });
      if (above == parents.begin() || leaf.begin >= std::prev(above)->end)
      {
        kept.push_back(leaf);
      }
    }
    kept.insert(kept.end(), parents.begin(), parents.end());
    result.leaves = std::move(kept);
  }
  return result;
}

Status CheckOptions(std::size_t vertices, const OctreeOptions& options)
{
  if (vertices == 0)
  {
    return Error{ ErrorCode::InvalidArgument, "the mesh has no vertices" };
  }
  if (vertices >= noVertex)
  {
    return Error{ ErrorCode::LimitExceeded,
      std::to_string(vertices) + " vertices; at most 4294967294 fit an octree in memory" };
  }
  if (!options.partitions)
  {
    return options.verticesPerPartition > 0
             ? Status{}
             : Error{ ErrorCode::InvalidArgument,
                 "the number of vertices per partition must be at least 1, not 0" };
  }
  if (*options.partitions == 0)
  {
    return Error{ ErrorCode::InvalidArgument,
      "the number of partitions must be at least 1, not 0" };
  }
  if (*options.partitions > vertices)
  {
    return Error{ ErrorCode::InvalidArgument,
      "number of partitions " + std::to_string(*options.partitions) +
        " is above the number of vertices, " + std::to_string(vertices) };
  }
  return {};
}

}

Result<OctreeClustering> ClusterByOctree(
  std::span<const Vec3> points, const OctreeOptions& options, const Execution& execution)
{
  KDSTREAM_TRY(CheckOptions(points.size(), options));
  const Box box = BoxOfPoints(points);
  KDSTREAM_TRY(CheckExtent(box));
  KDSTREAM_TRY(execution.Report("octree", 0));
  Octree octree(points, box, execution);
  Searched found;
  found.most = options.verticesPerPartition;
  if (options.partitions)
  {
    Result<Searched> searched = SearchCount(octree, *options.partitions, execution);
    KDSTREAM_TRY(searched);
    found = std::move(*searched);
  }
  else
  {
    Result<std::vector<Cell>> leaves = SplitByCount(octree, found.most, execution);
    KDSTREAM_TRY(leaves);
    found.leaves = std::move(*leaves);
  }
  OctreeClustering clustering = octree.Number(found.leaves);
  clustering.verticesPerPartition = found.most;
  KDSTREAM_TRY(execution.Report("octree", 1));
  return clustering;
}

}
