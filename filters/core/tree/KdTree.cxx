// SPDX-License-Identifier: BSD-3-Clause
// The balanced k-d tree: see KdTree.h. Points become records, RecordTree orders them.
#include "filters/core/tree/KdTree.h"

#include "filters/core/Extent.h"
#include "filters/core/tree/Clustering.h"
#include "filters/core/tree/RecordTree.h"

#include <algorithm>
#include <bit>
#include <string>

namespace kdstream
{
namespace
{

constexpr unsigned deepestTree = 30; // heap ids of nodes stay below 2^31
constexpr std::uint32_t mostCellVertices = 1024;

constexpr std::size_t blockItems = std::size_t{ 1 } << 16;

std::size_t BlocksOf(std::size_t count)
{
  return (count + blockItems - 1) / blockItems;
}

// Calls body(block, begin, end) for every block of [0, count), on any threads.
template <class Body>
void ForEachBlock(std::size_t count, const Execution& execution, const Body& body)
{
  execution.parallelFor(BlocksOf(count), 1,
    [&](std::size_t first, std::size_t last)
    {
      for (std::size_t block = first; block < last; ++block)
      {
        body(block, block * blockItems, std::min(count, (block + 1) * blockItems));
      }
    });
}

// What must be known before the points become records.
struct Survey
{
  Box box;
  // Whether floats hold every coordinate exactly: records of half the size then give the same tree.
  bool fitFloats = true;
};

Survey SurveyPoints(std::span<const Vec3> points, const Execution& execution)
{
  std::vector<Survey> ofBlock(BlocksOf(points.size()));
  ForEachBlock(points.size(), execution,
    [&](std::size_t block, std::size_t begin, std::size_t end)
    {
      Survey survey;
      for (std::size_t i = begin; i < end; ++i)
      {
        survey.box.Add(points[i]);
        for (const double coordinate : points[i])
        {
          survey.fitFloats &= double(float(coordinate)) == coordinate;
        }
      }
      ofBlock[block] = survey;
    });
  Survey all;
  for (const Survey& survey : ofBlock)
  {
    all.box.Add(survey.box);
    all.fitFloats &= survey.fitFloats;
  }
  return all;
}

template <class Scalar>
std::vector<PointRecord<Scalar>> RecordsOf(std::span<const Vec3> points, const Execution& execution)
{
  std::vector<PointRecord<Scalar>> records(points.size());
  ForEachBlock(points.size(), execution,
    [&](std::size_t, std::size_t begin, std::size_t end)
    {
      for (std::size_t i = begin; i < end; ++i)
      {
        records[i].p = { static_cast<Scalar>(points[i][0]), static_cast<Scalar>(points[i][1]),
          static_cast<Scalar>(points[i][2]) };
        records[i].id = static_cast<VertexId>(i);
      }
    });
  return records;
}

template <class Scalar>
Status BuildWith(std::span<const Vec3> points, KdTree& tree, const Execution& execution)
{
  std::vector<PointRecord<Scalar>> records = RecordsOf<Scalar>(points, execution);
  KDSTREAM_TRY(BuildRecordTree<Scalar>(records, 0, 0, tree.depths, tree.boxes, execution));
  ForEachBlock(points.size(), execution,
    [&](std::size_t, std::size_t begin, std::size_t end)
    {
      for (std::size_t i = begin; i < end; ++i)
      {
        tree.order[i] = records[i].id;
      }
    });
  return {};
}

template <class Scalar>
Status ClusterWith(std::span<const Vec3> points, const TreeDepths& depths, Clustering& clustering,
  const Execution& execution)
{
  std::vector<PointRecord<Scalar>> records = RecordsOf<Scalar>(points, execution);
  KDSTREAM_TRY(BuildRecordTree<Scalar>(records, 0, 0, depths, {}, execution));
  execution.parallelFor(clustering.clusters, 1,
    [&](std::size_t begin, std::size_t end)
    {
      for (std::size_t c = begin; c < end; ++c)
      {
        const CellRange range = RangeOfCell(points.size(), depths.partition, c);
        for (const auto& record : std::span(records).subspan(
               static_cast<std::size_t>(range.begin), static_cast<std::size_t>(range.size)))
        {
          clustering.clusterOf[record.id] = static_cast<std::uint32_t>(c);
        }
      }
    });
  return {};
}

// The smallest depth at which `vertices` vertices, halved at each depth, give cells of at most
// `limit` vertices.
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
        "the number of vertices per partition must be at least 1, not 0" };
    }
    depths.partition = SmallestDepth(vertices, options.verticesPerPartition);
  }
  if (options.cellVertices > mostCellVertices)
  {
    return Error{ ErrorCode::InvalidArgument, "the number of vertices per cell, " +
                                                std::to_string(options.cellVertices) +
                                                ", is above " + std::to_string(mostCellVertices) };
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
    return Error{ ErrorCode::LimitExceeded, "the tree would need " + std::to_string(depths.finest) +
                                              " depths; the maximum is " +
                                              std::to_string(deepestTree) + "" };
  }
  depths.stitch = std::min(depths.finest, depths.partition + 4);
  return depths;
}

CellRange RangeOfCell(std::uint64_t vertices, unsigned depth, std::uint64_t index)
{
  CellRange range{ 0, vertices };
  for (unsigned d = depth; d > 0; --d)
  {
    const std::uint64_t lower = range.size / 2;
    const bool isUpper = (index >> (d - 1) & 1) != 0;
    range.begin += isUpper ? lower : 0;
    range.size = isUpper ? range.size - lower : lower;
  }
  return range;
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
  KDSTREAM_TRY(depths);
  const Survey survey = SurveyPoints(points, execution);
  KDSTREAM_TRY(CheckExtent(survey.box));
  KdTree tree;
  tree.depths = *depths;
  tree.order.resize(points.size());
  tree.cellBegin.resize((std::size_t{ 1 } << depths->finest) + 1);
  ForEachBlock(tree.cellBegin.size() - 1, execution,
    [&](std::size_t, std::size_t begin, std::size_t end)
    {
      for (std::size_t cell = begin; cell < end; ++cell)
      {
        tree.cellBegin[cell] =
          static_cast<VertexId>(RangeOfCell(points.size(), depths->finest, cell).begin);
      }
    });
  tree.cellBegin.back() = static_cast<VertexId>(points.size());
  tree.boxes.resize(std::size_t{ 2 } << depths->partition);
  KDSTREAM_TRY(survey.fitFloats ? BuildWith<float>(points, tree, execution)
                                : BuildWith<double>(points, tree, execution));
  return tree;
}

Result<Clustering> ClusterByKdTree(
  std::span<const Vec3> points, KdTreeOptions options, const Execution& execution)
{
  options.cellVertices = 0;
  const Result<TreeDepths> depths = ComputeDepths(points.size(), options);
  KDSTREAM_TRY(depths);
  const Survey survey = SurveyPoints(points, execution);
  KDSTREAM_TRY(CheckExtent(survey.box));
  Clustering clustering{ std::vector<std::uint32_t>(points.size()),
    std::uint32_t{ 1 } << depths->partition };
  KDSTREAM_TRY(survey.fitFloats ? ClusterWith<float>(points, *depths, clustering, execution)
                                : ClusterWith<double>(points, *depths, clustering, execution));
  return clustering;
}

std::vector<std::uint32_t> CellOfVertex(
  const KdTree& tree, unsigned depth, const Execution& execution)
{
  return CellOfVertex(tree, depth, tree.order.size(), execution);
}

std::vector<std::uint32_t> CellOfVertex(
  const KdTree& tree, unsigned depth, std::size_t vertices, const Execution& execution)
{
  std::vector<std::uint32_t> cell(vertices, noCell);
  const std::size_t cells = std::size_t{ 1 } << depth;
  execution.parallelFor(cells, 1 + blockItems * cells / std::max<std::size_t>(1, vertices),
    [&](std::size_t begin, std::size_t end)
    {
      for (std::size_t c = begin; c < end; ++c)
      {
        for (const VertexId v : tree.Cell(depth, c))
        {
          cell[v] = static_cast<std::uint32_t>(c);
        }
      }
    });
  return cell;
}

}
