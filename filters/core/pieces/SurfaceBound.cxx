// SPDX-License-Identifier: BSD-3-Clause
// Bounds of distances by branch and bound: see SurfaceBound.h.
//   1. What is within a ball is no farther than its centre is, and its radius. Groups of triangles
//   whose balls are near enough are done.
//   2. Others are parted, down to triangles. A triangle is also as near to any one triangle of the
//   other surface as its corners are, since the distance to that is convex.
//   3. What is still too far is cut in two, until it is small beside its distance: then it raises
//   the bound.
// Whether something raises the bound as a whole depends on its own distance alone, never on the
// bound so far; what is done early would not have raised it. So the order in which parts come is
// free.
#include "filters/core/pieces/SurfaceBound.h"

#include "filters/core/TriangleDistance.h"
#include "filters/core/VectorMath.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace kdstream
{
namespace
{

constexpr double tolerated = 0.15;     // radius of what raises the bound, to its distance
constexpr std::size_t closeLevels = 2; // of groups whose balls are as small as their corners allow
constexpr unsigned mostCuts = 10;      // of a triangle, one after the other
constexpr double roundedAway = 1e-14;  // of coordinates: more than a radius loses by rounding
constexpr double infinite = std::numeric_limits<double>::infinity();

using Corner3 = std::array<Vec3, 3>;

double SquaredToBox(const Box& box, const Vec3& place)
{
  double squared = 0;
  for (std::size_t k = 0; k < 3; ++k)
  {
    const double away = std::max({ box.lo[k] - place[k], place[k] - box.hi[k], 0.0 });
    squared += away * away;
  }
  return squared;
}

Vec3 CentreOfBox(const Box& box)
{
  return { box.lo[0] / 2 + box.hi[0] / 2, box.lo[1] / 2 + box.hi[1] / 2,
    box.lo[2] / 2 + box.hi[2] / 2 };
}

Vec3 CentreOfTriangle(const Corner3& corners)
{
  return { (corners[0][0] + corners[1][0] + corners[2][0]) / 3,
    (corners[0][1] + corners[1][1] + corners[2][1]) / 3,
    (corners[0][2] + corners[1][2] + corners[2][2]) / 3 };
}

double RoundedAway(const Vec3& p)
{
  return roundedAway * (std::abs(p[0]) + std::abs(p[1]) + std::abs(p[2]));
}

double RadiusAround(const Vec3& centre, const Corner3& corners)
{
  double squared = 0;
  for (const Vec3& corner : corners)
  {
    squared = std::max(squared, SquaredDistance(centre, corner));
  }
  return std::sqrt(squared) + RoundedAway(centre);
}

// Where a triangle lies, about.
struct Placed
{
  std::array<float, 3> place{};
  std::uint32_t number = 0;
};

// Parts triangles along the longest side of their box until groups of so many are left: all but the
// last at each level are full.
void PartInSpace(std::span<Placed> placed, std::size_t arity)
{
  if (placed.size() <= arity)
  {
    std::sort(placed.begin(), placed.end(),
      [](const Placed& a, const Placed& b) { return a.number < b.number; });
    return;
  }
  std::array<float, 3> low = placed.front().place, high = low;
  for (const Placed& one : placed)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      low[k] = std::min(low[k], one.place[k]);
      high[k] = std::max(high[k], one.place[k]);
    }
  }
  std::size_t axis = 0;
  for (std::size_t k = 1; k < 3; ++k)
  {
    axis = high[k] - low[k] > high[axis] - low[axis] ? k : axis;
  }
  std::size_t group = arity;
  while (group * arity < placed.size())
  {
    group *= arity;
  }
  const std::size_t half = std::max(placed.size() / 2 / group, std::size_t{ 1 }) * group;
  std::nth_element(placed.begin(), placed.begin() + static_cast<std::ptrdiff_t>(half), placed.end(),
    [axis](const Placed& a, const Placed& b) {
      return a.place[axis] != b.place[axis] ? a.place[axis] < b.place[axis] : a.number < b.number;
    });
  PartInSpace(placed.first(half), arity);
  PartInSpace(placed.subspan(half), arity);
}

std::vector<Triangle> OrderedInSpace(
  std::span<const Vec3> points, const std::vector<Triangle>& triangles, std::size_t arity)
{
  std::vector<Placed> placed(triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i)
  {
    const Triangle& t = triangles[i];
    placed[i].number = static_cast<std::uint32_t>(i);
    for (std::size_t k = 0; k < 3; ++k)
    {
      const double from = points.front()[k]; // so that floats hold what lies far from the origin
      placed[i].place[k] = static_cast<float>(
        points[t[0]][k] - from + (points[t[1]][k] - from) + (points[t[2]][k] - from));
    }
  }
  PartInSpace(placed, arity);
  std::vector<Triangle> ordered(triangles.size());
  std::transform(placed.begin(), placed.end(), ordered.begin(),
    [&](const Placed& one) { return triangles[one.number]; });
  return ordered;
}

class FarthestSearch
{
public:
  FarthestSearch(const SearchedPart& from, const MeasuredSurface& to, double enough)
    : From(from)
    , To(to)
    , Enough(enough)
  {
  }

  Result<double> Run()
  {
    if (!this->From.Levels().empty())
    {
      KDSTREAM_TRY(this->VisitNode(this->From.Levels().size() - 1, 0, nullptr));
    }
    return this->Enough;
  }

private:
  // What is known of a ball.
  struct Ball
  {
    Vec3 centre{};
    double radius = 0;
    double distance = infinite;                 // of the centre
    std::uint32_t nearest = SearchedPart::none; // triangle of To.near
    double Farthest() const { return this->distance + this->radius; }
  };
  // A group, and those that it is in.
  struct Group
  {
    Ball ball;
    Group* above = nullptr;
  };

  Status VisitNode(std::size_t level, std::size_t index, Group* above)
  {
    const SearchedPart::Node& node = this->From.Levels()[level][index];
    Group group{ { node.centre, node.radius }, above };
    Ball& ball = group.ball;
    const bool isSmall = ball.radius <= this->To.smallest;
    if ((isSmall || ball.radius <= this->Enough) && this->IsDone(ball, this->GuessOf(level, index)))
    {
      return {};
    }
    if (isSmall && this->IsClose(ball))
    {
      const double most = this->FarthestOf(&group);
      KDSTREAM_TRY(this->LookFarther(ball));
      this->Enough = std::max(this->Enough, std::min(most, ball.Farthest()));
      return {};
    }
    for (std::uint32_t i = node.begin; i < node.end; ++i)
    {
      if (level > 0)
      {
        KDSTREAM_TRY(this->VisitNode(level - 1, i, &group));
        continue;
      }
      const Triangle& t = this->From.Triangles()[i];
      KDSTREAM_TRY(this->VisitTriangle(
        { this->From.At(t[0]), this->From.At(t[1]), this->From.At(t[2]) }, &group, infinite, 0));
    }
    return {};
  }

  // most: that no point of the triangle is beyond, as far as is known without its group.
  Status VisitTriangle(const Corner3& corners, Group* group, double most, unsigned cuts)
  {
    Ball ball{ CentreOfTriangle(corners) };
    ball.radius = RadiusAround(ball.centre, corners);
    if (this->IsDone(ball, SearchedPart::none))
    {
      return {};
    }
    most = std::min({ most, ball.Farthest(), this->FarthestCorner(corners, ball.nearest) });
    if (most <= this->Enough)
    {
      return {};
    }
    most = std::min(most, this->FarthestOf(group));
    KDSTREAM_TRY(this->LookFarther(ball));
    most = std::min(most, ball.Farthest());
    if (most <= this->Enough)
    {
      return {};
    }
    if (this->IsClose(ball) || most <= (1 + tolerated) * ball.distance || cuts == mostCuts)
    {
      this->Enough = most;
      return {};
    }
    const std::size_t i = LongestEdge(corners);
    const Vec3 &a = corners[i], &b = corners[(i + 1) % 3], &c = corners[(i + 2) % 3];
    const Vec3 middle{ a[0] / 2 + b[0] / 2, a[1] / 2 + b[1] / 2, a[2] / 2 + b[2] / 2 };
    KDSTREAM_TRY(this->VisitTriangle({ a, middle, c }, group, most, cuts + 1));
    return this->VisitTriangle({ middle, b, c }, group, most, cuts + 1);
  }

  // That no point of any of the groups is beyond. What is done early is in one of them.
  double FarthestOf(Group* group) const
  {
    double most = infinite;
    for (; group; group = group->above)
    {
      Ball& ball = group->ball;
      if (ball.distance == infinite)
      {
        double squared = infinite;
        this->To.near.Nearest(ball.centre, 0, squared);
        ball.distance = std::sqrt(squared);
      }
      most = std::min(most, ball.Farthest());
    }
    return most;
  }

  // The point that is guessed for the first group in a node.
  VertexId GuessOf(std::size_t level, std::size_t index) const
  {
    for (; level > 0; --level)
    {
      index = this->From.Levels()[level][index].begin;
    }
    return this->To.guesses.empty() ? SearchedPart::none : this->To.guesses[index];
  }

  // Whether what is in the ball is near enough. If not, its centre's distance is known. guess: a
  // point of the near part.
  bool IsDone(Ball& ball, VertexId guess)
  {
    const double left = this->Enough - ball.radius;
    const double enough = left > 0 ? left * left : 0;
    if (left > 0 && guess != SearchedPart::none &&
        SquaredDistance(this->To.near.At(guess), ball.centre) <= enough)
    {
      return true;
    }
    if (this->Hint != SearchedPart::none && left >= 0 &&
        (SquaredDistance(this->To.near.At(this->To.near.Triangles()[this->Hint][0]), ball.centre) <=
            enough ||
          this->To.near.SquaredTo(this->Hint, ball.centre) <= enough))
    {
      return true;
    }
    double squared = infinite;
    ball.nearest = this->To.near.Nearest(ball.centre, enough, squared);
    ball.distance = std::sqrt(squared);
    this->Hint = ball.nearest;
    return left >= 0 && squared <= enough;
  }

  // Whether the ball is small beside its distance, or both are small.
  bool IsClose(const Ball& ball) const
  {
    return ball.radius <= tolerated * ball.distance ||
           (ball.radius <= this->To.smallest && ball.distance <= this->To.smallest);
  }

  // What is farther from the near part than it is large may be nearer to another one.
  Status LookFarther(Ball& ball) const
  {
    if (ball.distance < ball.radius)
    {
      return {};
    }
    double squared = ball.distance * ball.distance;
    KDSTREAM_TRY(this->To.lookFarther(ball.centre, squared));
    ball.distance = std::min(ball.distance, std::sqrt(squared));
    return {};
  }

  double FarthestCorner(const Corner3& corners, std::uint32_t triangle) const
  {
    if (triangle == SearchedPart::none)
    {
      return infinite;
    }
    double squared = 0;
    for (const Vec3& corner : corners)
    {
      squared = std::max(squared, this->To.near.SquaredTo(triangle, corner));
    }
    return std::sqrt(squared);
  }

  static std::size_t LongestEdge(const Corner3& corners)
  {
    std::size_t longest = 0;
    double most = -1;
    for (std::size_t i = 0; i < 3; ++i)
    {
      const double squared = SquaredDistance(corners[i], corners[(i + 1) % 3]);
      if (squared > most)
      {
        most = squared;
        longest = i;
      }
    }
    return longest;
  }

  const SearchedPart& From;
  const MeasuredSurface& To;
  double Enough;                           // the bound so far
  std::uint32_t Hint = SearchedPart::none; // what was near last
};

}

SearchedPart::SearchedPart(std::vector<Vec3> points, std::vector<Triangle> triangles,
  std::span<const std::vector<std::uint32_t>> groupEnds)
  : Points(std::move(points))
  , Corners(
      groupEnds.empty() ? OrderedInSpace(this->Points, triangles, arity) : std::move(triangles))
{
  if (this->Corners.empty())
  {
    return;
  }
  const auto group = [](std::size_t size)
  {
    std::vector<Node> nodes((size + arity - 1) / arity);
    for (std::size_t i = 0; i < nodes.size(); ++i)
    {
      nodes[i].begin = static_cast<std::uint32_t>(i * arity);
      nodes[i].end = static_cast<std::uint32_t>(std::min(size, (i + 1) * arity));
    }
    return nodes;
  };
  std::size_t below = this->Corners.size();
  std::span<const std::uint32_t> endsBelow; // in triangles
  for (const std::vector<std::uint32_t>& ends : groupEnds)
  {
    std::vector<Node> nodes;
    std::uint32_t begin = 0;
    for (const std::uint32_t end : ends)
    {
      const auto last =
        endsBelow.empty()
          ? end
          : static_cast<std::uint32_t>(
              std::lower_bound(endsBelow.begin(), endsBelow.end(), end) - endsBelow.begin() + 1);
      nodes.push_back({ {}, {}, 0, begin, last });
      begin = last;
    }
    below = nodes.size();
    endsBelow = ends;
    this->AddLevel(std::move(nodes));
  }
  while (this->Nodes.empty() || below > 1)
  {
    std::vector<Node> nodes = group(below);
    below = nodes.size();
    this->AddLevel(std::move(nodes));
  }
}

void SearchedPart::AddLevel(std::vector<Node> nodes)
{
  const std::vector<Node>* const below = this->Nodes.empty() ? nullptr : &this->Nodes.back();
  for (Node& node : nodes)
  {
    std::uint32_t first = node.begin, last = node.end; // of triangles
    if (!below)
    {
      this->ForEachCorner(first, last, [&](const Vec3& p) { node.box.Add(p); });
    }
    for (std::uint32_t i = node.begin; below && i < node.end; ++i)
    {
      node.box.Add((*below)[i].box);
    }
    node.centre = CentreOfBox(node.box);
    if (this->Nodes.size() < closeLevels)
    {
      first = below ? (*below)[node.begin].begin : first;
      last = below ? (*below)[node.end - 1].end : last;
      double squared = 0;
      this->ForEachCorner(first, last,
        [&](const Vec3& p) { squared = std::max(squared, SquaredDistance(node.centre, p)); });
      node.radius = std::sqrt(squared);
    }
    else // that of the balls in it, or of its box
    {
      for (std::uint32_t i = node.begin; i < node.end; ++i)
      {
        const Node& inner = (*below)[i];
        node.radius = std::max(
          node.radius, std::sqrt(SquaredDistance(node.centre, inner.centre)) + inner.radius);
      }
      node.radius = std::min(node.radius, std::sqrt(SquaredDistance(node.centre, node.box.hi)));
    }
    node.radius += RoundedAway(node.centre);
  }
  this->Nodes.push_back(std::move(nodes));
}

double SearchedPart::Spacing() const
{
  double twice = 0; // area
  for (const Triangle& t : this->Corners)
  {
    twice +=
      Length(Cross(Minus(this->At(t[1]), this->At(t[0])), Minus(this->At(t[2]), this->At(t[0]))));
  }
  return this->Corners.empty() ? 0 : std::sqrt(twice / double(this->Corners.size()));
}

double SearchedPart::SquaredTo(std::uint32_t triangle, const Vec3& place) const
{
  const Triangle& t = this->Corners[triangle];
  return SquaredToTriangle(place, this->Points[t[0]], this->Points[t[1]], this->Points[t[2]]);
}

std::uint32_t SearchedPart::Nearest(const Vec3& place, double enough, double& squared) const
{
  std::uint32_t nearest = none;
  if (!this->Nodes.empty() && SquaredToBox(this->Bounds(), place) < squared)
  {
    this->Search(this->Nodes.size() - 1, 0, place, enough, squared, nearest);
  }
  return nearest;
}

void SearchedPart::Search(std::size_t level, std::size_t index, const Vec3& place, double enough,
  double& squared, std::uint32_t& nearest) const
{
  const Node& node = this->Nodes[level][index];
  for (std::uint32_t i = node.begin; level == 0 && enough > 0 && i < node.end; ++i)
  {
    // No triangle is farther than its corners: what is enough is found soon.
    const double corner = SquaredDistance(place, this->At(this->Corners[i][0]));
    if (corner <= enough && corner < squared)
    {
      squared = corner;
      nearest = i;
      return;
    }
  }
  for (std::uint32_t i = node.begin; level == 0 && i < node.end && squared > enough; ++i)
  {
    const double here = this->SquaredTo(i, place);
    if (here < squared)
    {
      squared = here;
      nearest = i;
    }
  }
  if (level == 0)
  {
    return;
  }
  std::array<std::pair<double, std::uint32_t>, arity> below;
  std::size_t count = 0;
  for (std::uint32_t i = node.begin; i < node.end; ++i)
  {
    below[count++] = { SquaredToBox(this->Nodes[level - 1][i].box, place), i };
  }
  std::sort(below.begin(), below.begin() + static_cast<std::ptrdiff_t>(count));
  for (std::size_t i = 0; i < count && below[i].first < squared && squared > enough; ++i)
  {
    this->Search(level - 1, below[i].second, place, enough, squared, nearest);
  }
}

Result<double> FarthestPoint(const SearchedPart& from, const MeasuredSurface& to, double enough)
{
  return FarthestSearch(from, to, enough).Run();
}

}
