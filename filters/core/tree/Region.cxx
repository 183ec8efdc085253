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

// Squared distance from a point to the farthest corner of a box that is not empty.
double SquaredDistanceToFarthest(const Box& box, const Vec3& point)
{
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k)
  {
    const double along = std::max(point[k] - box.lo[k], box.hi[k] - point[k]);
    sum += along * along;
  }
  return sum;
}

Vec3 Centre(const Box& box)
{
  return { box.lo[0] / 2 + box.hi[0] / 2, box.lo[1] / 2 + box.hi[1] / 2,
    box.lo[2] / 2 + box.hi[2] / 2 };
}

// For a tree whose boxes are all known exactly.
class AllBoxes : public TreeBoxes
{
public:
  explicit AllBoxes(std::span<const Box> boxes)
    : Boxes(boxes)
  {
  }
  const Box* Around(NodeId node) override { return &this->Boxes[node]; }
  const Box* OfPartition(NodeId node) override { return &this->Boxes[node]; }
  void NeedAround(NodeId) override {}
  void NeedOfPartition(NodeId) override {}

private:
  std::span<const Box> Boxes;
};

// An unknown box that a search needs; it lies somewhere in `within`.
struct UnknownBox
{
  NodeId node;
  bool ofPartition;
  Box within;
};

void Need(TreeBoxes& boxes, const UnknownBox& unknown)
{
  unknown.ofPartition ? boxes.NeedOfPartition(unknown.node) : boxes.NeedAround(unknown.node);
}

// Calls visit(partition's node, its box) for the partitions whose boxes pass `enter`. nearest: if
// not null, of two children the one nearer to this point is visited first.
template <class Enter, class Visit>
class Descent
{
public:
  Descent(TreeBoxes& boxes, const Enter& enter, const Visit& visit, const Vec3* nearest = nullptr)
    : Boxes(boxes)
    , MayEnter(enter)
    , Found(visit)
    , Nearest(nearest)
  {
  }

  // Searches down to `depth`; returns the unknown boxes that might be part of the region.
  std::vector<UnknownBox> Into(unsigned depth)
  {
    this->Into(1, depth, {});
    return std::move(this->Unknown);
  }

private:
  void Into(NodeId node, unsigned levelsBelow, const Box& parent)
  {
    const Box* known = this->Boxes.Around(node);
    if (!known)
    {
      this->Unknown.push_back({ node, false, parent });
      return;
    }
    const Box around = *known;
    if (around.Empty() || !this->MayEnter(around))
    {
      return;
    }
    if (levelsBelow > 0)
    {
      const NodeId first = this->Nearest ? this->NearerChild(node) : 2 * node;
      this->Into(first, levelsBelow - 1, around);
      this->Into(first ^ 1, levelsBelow - 1, around);
      return;
    }
    const Box* exact = this->Boxes.OfPartition(node);
    if (!exact)
    {
      this->Unknown.push_back({ node, true, around });
    }
    else if (!exact->Empty() && this->MayEnter(*exact))
    {
      this->Found(node, *exact);
    }
  }

  NodeId NearerChild(NodeId node)
  {
    const Box* lower = this->Boxes.Around(2 * node);
    const Box* upper = this->Boxes.Around(2 * node + 1);
    return lower && upper &&
               SquaredDistanceTo(*upper, *this->Nearest) < SquaredDistanceTo(*lower, *this->Nearest)
             ? 2 * node + 1
             : 2 * node;
  }

  TreeBoxes& Boxes;
  const Enter& MayEnter;
  const Visit& Found;
  const Vec3* Nearest;
  std::vector<UnknownBox> Unknown;
};

// A cell's box moved outward by a multiple of the average of its sides.
Box Reach(const Box& cell, unsigned rings)
{
  const double average =
    ((cell.hi[0] - cell.lo[0]) + (cell.hi[1] - cell.lo[1]) + (cell.hi[2] - cell.lo[2])) / 3;
  Box reach = cell;
  for (std::size_t k = 0; k < 3; ++k)
  {
    reach.lo[k] -= rings * average;
    reach.hi[k] += rings * average;
  }
  return reach;
}

// The region around a node. box: the exact box of `cell`. If the region has more than `most`
// partitions, returns only some of them, but more than `most`.
std::optional<std::vector<std::uint32_t>> RegionAround(TreeBoxes& boxes, const TreeDepths& depths,
  NodeId cell, const Box& box, unsigned rings, std::size_t most)
{
  const Box reach = Reach(box, rings);
  const Vec3 centre = Centre(box);
  std::vector<std::pair<double, std::uint32_t>> found;
  const auto touches = [&](const Box& other)
  { return found.size() <= most && Touch(other, reach); };
  const auto add = [&](NodeId node, const Box& exact)
  {
    const bool own = (node >> (depths.partition - DepthOfNode(cell))) == cell;
    found.emplace_back(own ? -1.0 : SquaredDistance(Centre(exact), centre),
      node - (NodeId{ 1 } << depths.partition));
  };
  const std::vector<UnknownBox> unknown = Descent(boxes, touches, add).Into(depths.partition);
  for (const UnknownBox& needed : unknown)
  {
    Need(boxes, needed);
  }
  if (!unknown.empty())
  {
    return {};
  }
  std::sort(found.begin(), found.end());
  std::vector<std::uint32_t> partitions(found.size());
  std::transform(
    found.begin(), found.end(), partitions.begin(), [](const auto& entry) { return entry.second; });
  return partitions;
}

}

Result<std::vector<std::uint32_t>> FindRegion(std::span<const Box> boxes, const TreeDepths& depths,
  NodeId cell, unsigned rings, std::size_t most)
{
  if (cell < 1 || cell >= boxes.size())
  {
    return Error{ ErrorCode::InvalidArgument, "cell " + std::to_string(cell) +
                                                " is not a node of the tree (1 to " +
                                                std::to_string(boxes.size() - 1) + ")" };
  }
  if (boxes[cell].Empty())
  {
    return std::vector<std::uint32_t>{};
  }
  AllBoxes all(boxes);
  std::vector<std::uint32_t> region = *RegionAround(all, depths, cell, boxes[cell], rings, most);
  if (region.size() > most)
  {
    return Error{ ErrorCode::LimitExceeded,
      "the region has more than " + std::to_string(most) + " partitions" };
  }
  return region;
}

std::optional<std::vector<std::uint32_t>> FindKnownRegion(
  TreeBoxes& boxes, const TreeDepths& depths, NodeId partition, unsigned rings)
{
  const Box* exact = boxes.OfPartition(partition);
  if (!exact)
  {
    boxes.NeedOfPartition(partition);
    return {};
  }
  if (exact->Empty())
  {
    return std::vector<std::uint32_t>{};
  }
  return RegionAround(
    boxes, depths, partition, Box(*exact), rings, std::numeric_limits<std::size_t>::max());
}

NearestAnswer NearestKnownPartition(TreeBoxes& boxes, const TreeDepths& depths, const Vec3& point)
{
  // The nearest point is not farther than this, because each box that is not empty contains a
  // point.
  double most = std::numeric_limits<double>::infinity();
  const auto isNear = [&](const Box& box)
  {
    most = std::min(most, SquaredDistanceToFarthest(box, point));
    return SquaredDistanceTo(box, point) <= most;
  };
  double best = std::numeric_limits<double>::infinity();
  NodeId nearest = 0;
  const auto take = [&](NodeId node, const Box& exact)
  {
    const double distance = SquaredDistanceTo(exact, point);
    if (nearest == 0 || distance < best || (distance == best && node < nearest))
    {
      best = distance;
      nearest = node;
      most = std::min(most, best);
    }
  };
  std::vector<UnknownBox> unknown = Descent(boxes, isNear, take, &point).Into(depths.partition);
  std::erase_if(
    unknown, [&](const UnknownBox& box) { return SquaredDistanceTo(box.within, point) > most; });
  double least = std::numeric_limits<double>::infinity();
  for (const UnknownBox& box : unknown)
  {
    least = std::min(least, SquaredDistanceTo(box.within, point));
  }
  for (const UnknownBox& box : unknown)
  {
    if (SquaredDistanceTo(box.within, point) == least)
    {
      Need(boxes, box);
    }
  }
  NearestAnswer answer;
  answer.known = unknown.empty();
  if (nearest != 0)
  {
    answer.partition = nearest - (NodeId{ 1 } << depths.partition);
  }
  return answer;
}

std::uint32_t NearestPartition(
  std::span<const Box> boxes, const TreeDepths& depths, const Vec3& point)
{
  AllBoxes all(boxes);
  return NearestKnownPartition(all, depths, point).partition.value_or(0);
}

}
