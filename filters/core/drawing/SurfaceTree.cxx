// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/drawing/SurfaceTree.h"

#include <cmath>
#include <numeric>

namespace kdstream
{
namespace
{

constexpr std::size_t mostInLeaf = 8;

// A sort key along an axis: the coordinate of a point, or three times that of a triangle's centre.
// Values that are not finite come first.
double PlaceOf(const Surface& surface, std::uint32_t i, std::size_t axis)
{
  double sum = 0;
  if (surface.triangles.empty())
  {
    sum = surface.points[i][axis];
  }
  else
  {
    for (const VertexId v : surface.triangles[i])
    {
      sum += surface.points[v][axis];
    }
  }
  return std::isfinite(sum) ? sum : std::numeric_limits<double>::lowest();
}

void AddTo(Box& box, const Surface& surface, std::uint32_t i)
{
  if (surface.triangles.empty())
  {
    box.Add(surface.points[i]);
    return;
  }
  for (const VertexId v : surface.triangles[i])
  {
    box.Add(surface.points[v]);
  }
}

}

Box BoundsOf(const Surface& surface)
{
  const std::size_t count =
    surface.triangles.empty() ? surface.points.size() : surface.triangles.size();
  Box bounds;
  for (std::uint32_t i = 0; i < count; ++i)
  {
    AddTo(bounds, surface, i);
  }
  return bounds;
}

SurfaceTree::SurfaceTree(const Surface& surface)
  : Order(surface.triangles.empty() ? surface.points.size() : surface.triangles.size())
{
  while ((this->Order.size() >> this->Depth) > mostInLeaf)
  {
    ++this->Depth;
  }
  this->Boxes.resize(std::size_t{ 2 } << this->Depth);
  std::iota(this->Order.begin(), this->Order.end(), 0u);
  this->Build(surface, 1, 0);
}

void SurfaceTree::Build(const Surface& surface, std::size_t node, unsigned depth)
{
  const std::size_t place = node - (std::size_t{ 1 } << depth);
  const std::size_t begin = this->Begin(place, depth), end = this->Begin(place + 1, depth);
  Box& box = this->Boxes[node];
  for (std::size_t i = begin; i < end; ++i)
  {
    AddTo(box, surface, this->Order[i]);
  }
  if (depth == this->Depth)
  {
    return;
  }
  const Vec3 sides{ box.hi[0] - box.lo[0], box.hi[1] - box.lo[1], box.hi[2] - box.lo[2] };
  const auto axis =
    static_cast<std::size_t>(std::max_element(sides.begin(), sides.end()) - sides.begin());
  const auto first = this->Order.begin();
  const std::size_t middle = this->Begin(2 * place + 1, depth + 1);
  std::nth_element(first + std::ptrdiff_t(begin), first + std::ptrdiff_t(middle),
    first + std::ptrdiff_t(end),
    [&](std::uint32_t a, std::uint32_t b)
    { return PlaceOf(surface, a, axis) < PlaceOf(surface, b, axis); });
  this->Build(surface, 2 * node, depth + 1);
  this->Build(surface, 2 * node + 1, depth + 1);
}

}
