// SPDX-License-Identifier: BSD-3-Clause
// The cap of a section: see SurfaceSection.h.
#include "viewer/session/section/SurfaceSection.h"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

namespace kdstream
{
namespace
{

using Point = std::array<double, 2>;

struct Side // a side of trapezoids: a segment, directed upwards
{
  Point low, high;

  double At(double y) const
  {
    const double share = (y - this->low[1]) / (this->high[1] - this->low[1]);
    return y >= this->high[1] ? this->high[0]
                              : this->low[0] + (this->high[0] - this->low[0]) * share;
  }
};

double SquareBetween(const Point& a, const Point& b)
{
  return (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]);
}

// Joins the ends of open lines by segments, so that no open end is left. A scan has few holes: if
// there are more than mostEnds ends, the rest stays open.
void CloseGaps(std::vector<std::array<Point, 2>>& segments)
{
  constexpr std::size_t mostEnds = 512;
  std::map<Point, bool> odd;
  for (const auto& segment : segments)
  {
    for (const Point& end : segment)
    {
      bool& isOdd = odd[end];
      isOdd = !isOdd;
    }
  }
  std::vector<Point> ends;
  for (const auto& [end, isOdd] : odd)
  {
    if (isOdd && ends.size() < mostEnds)
    {
      ends.push_back(end);
    }
  }
  while (ends.size() > 1)
  {
    std::pair<std::size_t, std::size_t> nearest{ 0, 1 };
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < ends.size(); ++i)
    {
      for (std::size_t j = i + 1; j < ends.size(); ++j)
      {
        const double square = SquareBetween(ends[i], ends[j]);
        if (square < least)
        {
          least = square;
          nearest = { i, j };
        }
      }
    }
    segments.push_back({ ends[nearest.first], ends[nearest.second] });
    ends.erase(ends.begin() + static_cast<std::ptrdiff_t>(nearest.second));
    ends.erase(ends.begin() + static_cast<std::ptrdiff_t>(nearest.first));
  }
}

// The state of the sweep, which goes from the lowest end upwards.
class Sweep
{
public:
  explicit Sweep(std::vector<Side> sides)
    : Sides(std::move(sides))
    , Trapezoids(this->Sides.size())
  {
    std::sort(this->Sides.begin(), this->Sides.end(),
      [](const Side& a, const Side& b) { return a.low[1] < b.low[1]; });
  }

  template <class Emit> // emit(left, right, from, to): a trapezoid between two heights
  void Run(const Emit& emit)
  {
    std::vector<double> heights;
    for (const Side& side : this->Sides)
    {
      heights.push_back(side.low[1]);
      heights.push_back(side.high[1]);
    }
    std::sort(heights.begin(), heights.end());
    heights.erase(std::unique(heights.begin(), heights.end()), heights.end());
    std::size_t next = 0;
    for (std::size_t i = 0; i < heights.size(); ++i)
    {
      const double y = heights[i];
      for (const std::size_t side : this->Active)
      {
        if (this->Sides[side].high[1] <= y)
        {
          this->Close(side, y, emit);
        }
      }
      std::erase_if(this->Active, [&](std::size_t side) { return this->Sides[side].high[1] <= y; });
      for (; next < this->Sides.size() && this->Sides[next].low[1] == y; ++next)
      {
        this->Active.push_back(next);
      }
      if (i + 1 < heights.size())
      {
        this->Pair(y, 0.5 * (y + heights[i + 1]), emit);
      }
    }
  }

private:
  static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
  struct Trapezoid // the trapezoid to the right of a side
  {
    std::size_t right = none;
    double since = 0;
  };

  template <class Emit>
  void Close(std::size_t left, double y, const Emit& emit)
  {
    Trapezoid& open = this->Trapezoids[left];
    if (open.right != none)
    {
      emit(this->Sides[left], this->Sides[open.right], open.since, y);
    }
    open.right = none;
  }

  // Pairs the active sides from height y on. A trapezoid whose right side changes is emitted, up to
  // y. `middle`: the height half way to the next end, at which the sides are compared.
  template <class Emit>
  void Pair(double y, double middle, const Emit& emit)
  {
    for (std::size_t i = 1; i < this->Active.size(); ++i) // insertion sort: nearly in order already
    {
      const std::size_t side = this->Active[i];
      const double x = this->Sides[side].At(middle);
      std::size_t place = i;
      for (; place > 0 && this->Sides[this->Active[place - 1]].At(middle) > x; --place)
      {
        this->Active[place] = this->Active[place - 1];
      }
      this->Active[place] = side;
    }
    for (std::size_t i = 0; i < this->Active.size(); ++i)
    {
      const bool isLeft = i % 2 == 0 && i + 1 < this->Active.size();
      const std::size_t right = isLeft ? this->Active[i + 1] : none;
      if (this->Trapezoids[this->Active[i]].right != right)
      {
        this->Close(this->Active[i], y, emit);
        this->Trapezoids[this->Active[i]] = { right, y };
      }
    }
  }

  std::vector<Side> Sides;
  std::vector<Trapezoid> Trapezoids; // one for each side
  std::vector<std::size_t> Active;   // the sides at the current height, from the left
};

}

Surface CapOf(const std::vector<SectionSegment>& segments, const SectionPlane& plane)
{
  Surface cap;
  if (segments.empty())
  {
    return cap;
  }
  const SectionAxes axes(plane, segments.front().from);
  std::vector<std::array<Point, 2>> flat;
  for (const SectionSegment& segment : segments)
  {
    flat.push_back({ axes.To(segment.from), axes.To(segment.to) });
  }
  CloseGaps(flat);
  std::vector<Side> sides;
  for (const auto& [a, b] : flat)
  {
    if (a[1] != b[1])
    {
      sides.push_back(a[1] < b[1] ? Side{ a, b } : Side{ b, a });
    }
  }
  const auto add = [&](const Point& a, const Point& b, const Point& c)
  {
    if (a != b && b != c && c != a)
    {
      const auto first = static_cast<VertexId>(cap.points.size());
      cap.points.insert(cap.points.end(), { axes.From(a), axes.From(b), axes.From(c) });
      cap.triangles.push_back({ first, first + 1, first + 2 });
    }
  };
  Sweep(std::move(sides))
    .Run(
      [&](const Side& left, const Side& right, double from, double to)
      {
        const Point lowLeft{ left.At(from), from }, lowRight{ right.At(from), from };
        const Point highLeft{ left.At(to), to }, highRight{ right.At(to), to };
        add(lowLeft, lowRight, highRight);
        add(lowLeft, highRight, highLeft);
      });
  cap.sources.resize(cap.points.size());
  return cap;
}

}
