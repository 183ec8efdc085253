// SPDX-License-Identifier: BSD-3-Clause
// The triangles of a surface in a tree of boxes, for rays: step "pick" of the pipeline picture.
#pragma once

#include "filters/core/drawing/Surface.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace kdstream
{

// The box of the triangles of a surface, or of its points if it has no triangles. O(n).
Box BoundsOf(const Surface& surface);

// A tree of boxes over the triangles of a surface, or over its points if it has no triangles. A
// node is halved at the median of its triangles' centres, along the longest side of the centres'
// box, until at most eight are left. Construction takes O(n log n); memory 16 to 28 bytes a
// triangle. Keeps no reference to the surface.
class SurfaceTree
{
public:
  explicit SurfaceTree(const Surface& surface);

  // The box of all triangles or points; empty if there are none.
  const Box& Bounds() const { return this->Boxes[1]; }

  // Visits the tree, the nearer child first. enter(box) returns a lower bound for the distance of
  // anything in the box, or infinity to skip it; it is called again before the farther child is
  // entered. visit(i) is called for each triangle or point that is reached.
  template <class Enter, class Visit>
  void Walk(const Enter& enter, const Visit& visit) const
  {
    if (!this->Order.empty() && enter(this->Bounds()) < never)
    {
      this->WalkFrom(1, 0, enter, visit);
    }
  }

private:
  static constexpr double never = std::numeric_limits<double>::infinity();

  std::size_t Begin(std::size_t place, unsigned depth) const // of a node, counted within its depth
  {
    return static_cast<std::size_t>(
      std::uint64_t{ place } * std::uint64_t{ this->Order.size() } >> depth);
  }
  void Build(const Surface& surface, std::size_t node, unsigned depth);

  template <class Enter, class Visit>
  void WalkFrom(std::size_t node, unsigned depth, const Enter& enter, const Visit& visit) const
  {
    if (depth == this->Depth)
    {
      const std::size_t place = node - (std::size_t{ 1 } << depth);
      for (std::size_t i = this->Begin(place, depth); i < this->Begin(place + 1, depth); ++i)
      {
        visit(this->Order[i]);
      }
      return;
    }
    std::size_t first = 2 * node, second = 2 * node + 1;
    double near = enter(this->Boxes[first]), far = enter(this->Boxes[second]);
    if (far < near)
    {
      std::swap(first, second);
      std::swap(near, far);
    }
    if (near < never)
    {
      this->WalkFrom(first, depth + 1, enter, visit);
    }
    if (far < never && enter(this->Boxes[second]) < never)
    {
      this->WalkFrom(second, depth + 1, enter, visit);
    }
  }

  unsigned Depth = 0;               // of the leaves
  std::vector<std::uint32_t> Order; // of the leaves, one after the other
  std::vector<Box> Boxes;           // heap order; the first entry is unused
};

}
