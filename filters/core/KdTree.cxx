// The balanced k-d tree: see KdTree.h. Steps as in the paper's section 4.1:
//   a. the box of the cell's vertices,  b. its longest axis,  c. the median on the total order
//   (coordinate, id), d. two halves,  e. again for each half.
// The upper depths are split one after the other, all nodes of a depth in parallel; below
// `forkDepth` every subtree is finished on its own while it is in the cache.
#include "filters/core/KdTree.h"

#include "filters/core/Weld.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>

namespace kdstream
{
namespace
{

// What nth_element moves about: coordinates beside the id, so that comparing touches one record
// only.
template <class Scalar>
struct Record
{
  std::array<Scalar, 3> p;
  VertexId id;
};

constexpr unsigned deepestTree = 30; // heap ids of nodes stay below 2^31
constexpr unsigned forkDepth = 8;
constexpr std::uint32_t mostCellVertices = 1024;

struct Range
{
  std::size_t begin = 0, end = 0;
  std::size_t Size() const { return this->end - this->begin; }
  // The lower half gets floor, the upper ceil.
  std::size_t Middle() const { return this->begin + this->Size() / 2; }
};

template <class Scalar>
class Builder
{
public:
  Builder(KdTree& tree, std::vector<Record<Scalar>>& records)
    : Tree(tree)
    , Records(records)
  {
  }

  // Splits the whole tree, depth by depth and then subtree by subtree.
  Status Build(const Execution& execution)
  {
    const unsigned deepest = this->Tree.depths.finest;
    std::vector<Range> ranges{ { 0, this->Records.size() } };
    for (unsigned depth = 0; depth < std::min(deepest, forkDepth); ++depth)
    {
      std::vector<Range> halves(ranges.size() * 2);
      execution.parallelFor(ranges.size(), 1,
        [&](std::size_t begin, std::size_t end)
        {
          for (std::size_t i = begin; i < end; ++i)
          {
            this->Split(depth, i, ranges[i]);
            const std::size_t middle = ranges[i].Middle();
            halves[2 * i] = { ranges[i].begin, middle };
            halves[2 * i + 1] = { middle, ranges[i].end };
          }
        });
      ranges = std::move(halves);
      if (Status status = execution.Report("tree", double(depth + 1) / (2 * forkDepth)); !status)
      {
        return status;
      }
    }
    return this->BuildSubtrees(ranges, std::min(deepest, forkDepth), execution);
  }

private:
  Status BuildSubtrees(const std::vector<Range>& ranges, unsigned depth, const Execution& execution)
  {
    constexpr std::size_t batch = 32;
    for (std::size_t first = 0; first < ranges.size(); first += batch)
    {
      execution.parallelFor(std::min(batch, ranges.size() - first), 1,
        [&](std::size_t begin, std::size_t end)
        {
          for (std::size_t i = first + begin; i < first + end; ++i)
          {
            this->Recurse(depth, i, ranges[i]);
          }
        });
      const double done = double(std::min(first + batch, ranges.size())) / double(ranges.size());
      if (Status status = execution.Report("tree", 0.5 + 0.5 * done); !status)
      {
        return status;
      }
    }
    return {};
  }

  void Recurse(unsigned depth, std::size_t index, Range range)
  {
    if (depth == this->Tree.depths.finest)
    {
      this->Finish(depth, index, range);
      return;
    }
    this->Split(depth, index, range);
    this->Recurse(depth + 1, 2 * index, { range.begin, range.Middle() });
    this->Recurse(depth + 1, 2 * index + 1, { range.Middle(), range.end });
  }

  // The ids of a finest cell, ascending.
  void Finish(unsigned depth, std::size_t index, Range range)
  {
    if (depth <= this->Tree.depths.partition)
    {
      this->Tree.boxes[(std::size_t{ 1 } << depth) + index] = this->BoxOf(range);
    }
    this->Tree.cellBegin[index] = static_cast<VertexId>(range.begin);
    for (std::size_t i = range.begin; i < range.end; ++i)
    {
      this->Tree.order[i] = this->Records[i].id;
    }
    std::sort(this->Tree.order.begin() + std::ptrdiff_t(range.begin),
      this->Tree.order.begin() + std::ptrdiff_t(range.end));
  }

  void Split(unsigned depth, std::size_t index, Range range)
  {
    const Box box = this->BoxOf(range);
    if (depth <= this->Tree.depths.partition)
    {
      this->Tree.boxes[(std::size_t{ 1 } << depth) + index] = box;
    }
    const std::size_t middle = range.Middle();
    if (middle == range.begin)
    {
      return; // at most one vertex: the lower half is empty
    }
    const Vec3 side{ box.hi[0] - box.lo[0], box.hi[1] - box.lo[1], box.hi[2] - box.lo[2] };
    const std::size_t axis =
      side[0] >= side[1] && side[0] >= side[2] ? 0 : (side[1] >= side[2] ? 1 : 2);
    switch (axis)
    {
      case 0:
        this->Select<0>(range, middle);
        break;
      case 1:
        this->Select<1>(range, middle);
        break;
      default:
        this->Select<2>(range, middle);
    }
  }

  template <std::size_t Axis>
  void Select(Range range, std::size_t middle)
  {
    const auto at = [this](std::size_t i) { return this->Records.begin() + std::ptrdiff_t(i); };
    std::nth_element(at(range.begin), at(middle), at(range.end),
      [](const Record<Scalar>& a, const Record<Scalar>& b)
      { return a.p[Axis] < b.p[Axis] || (a.p[Axis] == b.p[Axis] && a.id < b.id); });
  }

  Box BoxOf(Range range) const
  {
    if (range.Size() == 0)
    {
      return {};
    }
    auto lo = this->Records[range.begin].p;
    auto hi = lo;
    for (std::size_t i = range.begin + 1; i < range.end; ++i)
    {
      for (std::size_t k = 0; k < 3; ++k)
      {
        lo[k] = std::min(lo[k], this->Records[i].p[k]);
        hi[k] = std::max(hi[k], this->Records[i].p[k]);
      }
    }
    Box box;
    for (std::size_t k = 0; k < 3; ++k)
    {
      // + 0.0 makes -0.0 positive: which of the two zeros is met first depends on the order of the
      // records.
      box.lo[k] = double(lo[k]) + 0.0;
      box.hi[k] = double(hi[k]) + 0.0;
    }
    return box;
  }

  KdTree& Tree;
  std::vector<Record<Scalar>>& Records;
};

template <class Scalar>
Status BuildWith(std::span<const Vec3> points, KdTree& tree, const Execution& execution)
{
  std::vector<Record<Scalar>> records(points.size());
  execution.parallelFor(points.size(), 1 << 16,
    [&](std::size_t begin, std::size_t end)
    {
      for (std::size_t i = begin; i < end; ++i)
      {
        records[i] = { { static_cast<Scalar>(points[i][0]), static_cast<Scalar>(points[i][1]),
                         static_cast<Scalar>(points[i][2]) },
          static_cast<VertexId>(i) };
      }
    });
  return Builder<Scalar>(tree, records).Build(execution);
}

// Whether floats hold every coordinate exactly: records of half the size then give the same tree.
bool FitFloats(std::span<const Vec3> points)
{
  return std::all_of(points.begin(), points.end(),
    [](const Vec3& p)
    {
      return double(float(p[0])) == p[0] && double(float(p[1])) == p[1] &&
             double(float(p[2])) == p[2];
    });
}

// The axes of the tree, the grid and the distances are made of differences: each must be a number.
Status CheckExtent(const Box& box)
{
  for (std::size_t k = 0; k < 3; ++k)
  {
    if (!std::isfinite(box.hi[k] - box.lo[k]))
    {
      return Error{ ErrorCode::InvalidInput,
        std::string("the mesh spans more along ") + "xyz"[k] + " than a double can hold" };
    }
  }
  return {};
}

// The smallest depth at which a cell of `vertices` vertices, halved, has at most `limit`.
unsigned SmallestDepth(std::size_t vertices, std::size_t limit)
{
  unsigned depth = 0;
  while (((vertices - 1) >> depth) + 1 > limit)
  {
    ++depth;
  }
  return depth;
}

}

Result<TreeDepths> ComputeDepths(std::size_t vertices, const KdTreeOptions& options)
{
  if (vertices == 0)
  {
    return Error{ ErrorCode::InvalidArgument, "the mesh has no vertices" };
  }
  if (vertices >= noVertex)
  {
    return Error{ ErrorCode::LimitExceeded,
      std::to_string(vertices) + " vertices; at most 4294967294 fit a tree in memory" };
  }
  TreeDepths depths;
  if (options.partitions)
  {
    const std::uint32_t count = *options.partitions;
    if (!std::has_single_bit(count))
    {
      return Error{ ErrorCode::InvalidArgument,
        "number of partitions " + std::to_string(count) + " is not a power of two" };
    }
    if (count > vertices)
    {
      return Error{ ErrorCode::InvalidArgument, "number of partitions " + std::to_string(count) +
                                                  " is above the number of vertices, " +
                                                  std::to_string(vertices) };
    }
    depths.partition = static_cast<unsigned>(std::countr_zero(count));
  }
  else
  {
    if (options.verticesPerPartition == 0)
    {
      return Error{ ErrorCode::InvalidArgument,
        "vertices per partition is 0; at least 1 is needed" };
    }
    depths.partition = SmallestDepth(vertices, options.verticesPerPartition);
  }
  if (options.cellVertices > mostCellVertices)
  {
    return Error{ ErrorCode::InvalidArgument, "vertices per cell " +
                                                std::to_string(options.cellVertices) +
                                                " is above " + std::to_string(mostCellVertices) };
  }
  depths.finest = depths.partition;
  if (options.cellVertices > 0)
  {
    const auto log2 = static_cast<unsigned>(std::bit_width(vertices) - 1);
    depths.finest = std::max(
      { depths.partition, SmallestDepth(vertices, options.cellVertices), std::min(11U, log2) });
  }
  if (depths.finest > deepestTree)
  {
    return Error{ ErrorCode::LimitExceeded, "the tree would have " + std::to_string(depths.finest) +
                                              " depths; at most " + std::to_string(deepestTree) +
                                              " are possible" };
  }
  depths.stitch = std::min(depths.finest, depths.partition + 4);
  return depths;
}

std::span<const VertexId> KdTree::Cell(unsigned depth, std::size_t index) const
{
  const unsigned below = this->depths.finest - depth;
  const std::size_t begin = this->cellBegin[index << below];
  const std::size_t end = this->cellBegin[(index + 1) << below];
  return { this->order.data() + begin, end - begin };
}

Result<KdTree> BuildKdTree(
  std::span<const Vec3> points, const KdTreeOptions& options, const Execution& execution)
{
  Result<TreeDepths> depths = ComputeDepths(points.size(), options);
  if (!depths)
  {
    return depths.GetError();
  }
  if (Status status = CheckExtent(BoxOfPoints(points)); !status)
  {
    return status.GetError();
  }
  KdTree tree;
  tree.depths = *depths;
  tree.order.resize(points.size());
  tree.cellBegin.resize((std::size_t{ 1 } << depths->finest) + 1);
  tree.cellBegin.back() = static_cast<VertexId>(points.size());
  tree.boxes.resize(std::size_t{ 2 } << depths->partition);
  const Status status = FitFloats(points) ? BuildWith<float>(points, tree, execution)
                                          : BuildWith<double>(points, tree, execution);
  if (!status)
  {
    return status.GetError();
  }
  return tree;
}

std::vector<std::uint32_t> CellOfVertex(const KdTree& tree, unsigned depth)
{
  std::vector<std::uint32_t> cell(tree.order.size());
  for (std::size_t c = 0; c < std::size_t{ 1 } << depth; ++c)
  {
    for (const VertexId v : tree.Cell(depth, c))
    {
      cell[v] = static_cast<std::uint32_t>(c);
    }
  }
  return cell;
}

}
