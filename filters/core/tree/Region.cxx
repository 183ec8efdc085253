// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/tree/Region.h"

#include "filters/core/VectorMath.h"

#include <algorithm>
#include <string>

namespace kdstream
{
namespace
{

bool Touch(const Box& a, const Box& b)
{
  for (std::size_t k = 0; k < 3; ++k)
  {
    if (a.lo[k] > b.hi[k] || a.hi[k] < b.lo[k])
    {
      return false;
    }
  }
  return true;
}

// Squared distance from a point to a box; infinite for an empty one.
double SquaredDistanceTo(const Box& box, const Vec3& point)
{
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k)
  {
    const double outside = std::max({ box.lo[k] - point[k], point[k] - box.hi[k], 0.0 });
    sum += outside * outside;
  }
  return sum;
}

Vec3 Centre(const Box& box)
{
  return { box.lo[0] / 2 + box.hi[0] / 2, box.lo[1] / 2 + box.hi[1] / 2,
    box.lo[2] / 2 + box.hi[2] / 2 };
}

// Calls `visit` for the partitions below `node` whose boxes pass `enter`, in ascending order.
template <class Enter, class Visit>
void Descend(std::span<const Box> boxes, unsigned levelsBelow, NodeId node, const Enter& enter,
  const Visit& visit)
{
  if (boxes[node].Empty() || !enter(boxes[node]))
  {
    return;
  }
  if (levelsBelow == 0)
  {
    visit(node);
    return;
  }
  Descend(boxes, levelsBelow - 1, 2 * node, enter, visit);
  Descend(boxes, levelsBelow - 1, 2 * node + 1, enter, visit);
}

}

Result<std::vector<std::uint32_t>> FindRegion(
  std::span<const Box> boxes, const TreeDepths& depths, NodeId cell, unsigned rings)
{
  if (cell < 1 || cell >= boxes.size())
  {
    return Error{ ErrorCode::InvalidArgument, "cell " + std::to_string(cell) +
                                                " is not a node of the tree (1 to " +
                                                std::to_string(boxes.size() - 1) + ")" };
  }
  std::vector<std::uint32_t> partitions;
  Box reach = boxes[cell];
  if (reach.Empty())
  {
    return partitions;
  }
  const double average =
    ((reach.hi[0] - reach.lo[0]) + (reach.hi[1] - reach.lo[1]) + (reach.hi[2] - reach.lo[2])) / 3;
  for (std::size_t k = 0; k < 3; ++k)
  {
    reach.lo[k] -= rings * average;
    reach.hi[k] += rings * average;
  }
  const Vec3 centre = Centre(boxes[cell]);
  std::vector<std::pair<double, std::uint32_t>> found;
  Descend(
    boxes, depths.partition, 1, [&](const Box& box) { return Touch(box, reach); },
    [&](NodeId node)
    {
      const Box& box = boxes[node];
      const Vec3 c = Centre(box);
      const bool own = (node >> (depths.partition - DepthOfNode(cell))) == cell;
      found.emplace_back(
        own ? -1.0 : SquaredDistance(c, centre), node - (NodeId{ 1 } << depths.partition));
    });
  std::sort(found.begin(), found.end());
  for (const auto& entry : found)
  {
    partitions.push_back(entry.second);
  }
  return partitions;
}

std::uint32_t NearestPartition(
  std::span<const Box> boxes, const TreeDepths& depths, const Vec3& point)
{
  double best = std::numeric_limits<double>::infinity();
  NodeId nearest = NodeId{ 1 } << depths.partition;
  // A node is entered only if it may hold something nearer; of equals the first visited, the
  // lowest, stays.
  Descend(
    boxes, depths.partition, 1,
    [&](const Box& box) { return SquaredDistanceTo(box, point) < best; },
    [&](NodeId node)
    {
      best = SquaredDistanceTo(boxes[node], point);
      nearest = node;
    });
  return nearest - (NodeId{ 1 } << depths.partition);
}

}
