// SPDX-License-Identifier: BSD-3-Clause
// Bounds of distances by branch and bound: see SurfaceBound.h.
//   1. What is within a ball is no farther than its centre is, and its radius. Balls that are
//   thereby near enough are done; a guess, or what was near last, mostly shows it without a search.
//   2. Others are parted, down to those of clusters and, where these are not small, to triangles. A
//   triangle is also as near to any one triangle of the other surface as its corners are, since the
//   distance to that is convex.
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
#include <numeric>
#include <utility>

namespace kdstream
{
namespace
{

constexpr double tolerated = 0.15;    // radius of what raises the bound, to its distance
constexpr unsigned mostCuts = 10;     // of a triangle, one after the other
constexpr double roundedAway = 1e-14; // of coordinates: more than a radius loses by rounding
constexpr std::size_t arity = 4;      // of trees
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

class FarthestSearch
{
public:
  FarthestSearch(MeasuredPart& from, const LevelSurface& to, double enough)
    : From(from)
    , To(to)
    , Enough(enough)
  {
  }

  Result<double> Run()
  {
    if (!this->From.Levels().empty())
    {
      KDSTREAM_TRY(this->VisitBall(this->From.Levels().size() - 1, 0, nullptr));
    }
    return this->Enough;
  }

private:
  // What is known of a ball.
  struct Ball
  {
    Vec3 centre{};
    double radius = 0;
    VertexId guess = SearchedPart::none;        // point of To.near
    double distance = infinite;                 // of the centre
    std::uint32_t nearest = SearchedPart::none; // triangle of To.near
    double Farthest() const { return this->distance + this->radius; }
  };
  // A ball, and those that it is in.
  struct Group
  {
    Ball ball;
    Group* above = nullptr;
  };

  Status VisitBall(std::size_t level, std::size_t index, Group* above)
  {
    const MeasuredPart::Ball& measured = this->From.Levels()[level][index];
    if (measured.radius < 0)
    {
      return {};
    }
    Group group{ { measured.centre, measured.radius, this->GuessOf(level, index) }, above };
    Ball& ball = group.ball;
    if (this->IsNear(ball))
    {
      return {};
    }
    const bool isSmall = ball.radius <= (level == 0 ? this->To.smallest : this->To.smallestGroup);
    // A search for what would hardly be done is saved.
    const double likely = level == 0 ? ball.radius : 2 * ball.radius;
    if ((isSmall || likely <= this->Enough) && this->IsDone(ball))
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
    if (level > 0)
    {
      const auto [begin, end] = this->From.GroupOf(level, index);
      for (std::size_t i = begin; i < end; ++i)
      {
        KDSTREAM_TRY(this->VisitBall(level - 1, i, &group));
      }
      return {};
    }
    for (const Triangle& t : this->From.TrianglesOf(index))
    {
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
    if (this->IsNear(ball) || this->IsDone(ball))
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
        double squared = this->SquaredToGuess(ball);
        this->To.near.Nearest(ball.centre, 0, squared);
        ball.distance = std::sqrt(squared);
      }
      most = std::min(most, ball.Farthest());
    }
    return most;
  }

  // The point that is guessed for the first ball in a group.
  VertexId GuessOf(std::size_t level, std::size_t index) const
  {
    for (; level > 0; --level)
    {
      index = this->From.GroupOf(level, index).first;
    }
    return this->To.guesses.empty() ? SearchedPart::none : this->To.guesses[index];
  }

  double SquaredToGuess(const Ball& ball) const
  {
    return ball.guess == SearchedPart::none
             ? infinite
             : SquaredDistance(this->To.near.At(ball.guess), ball.centre);
  }

  // Whether a guess, or what was near last, shows that what is in the ball is near enough.
  bool IsNear(const Ball& ball) const
  {
    const double left = this->Enough - ball.radius;
    if (left < 0)
    {
      return false;
    }
    const double enough = left * left;
    const SearchedPart& near = this->To.near;
    return this->SquaredToGuess(ball) <= enough ||
           std::any_of(this->Hints.begin(), this->Hints.end(),
             [&](std::uint32_t hint)
             { return hint != SearchedPart::none && near.SquaredTo(hint, ball.centre) <= enough; });
  }

  // Whether a search shows it. If not, the centre's distance is known.
  bool IsDone(Ball& ball)
  {
    const double left = this->Enough - ball.radius;
    const double enough = left > 0 ? left * left : 0;
    double squared = this->SquaredToGuess(ball);
    ball.nearest = this->To.near.Nearest(ball.centre, enough, squared);
    ball.distance = std::sqrt(squared);
    if (ball.nearest != SearchedPart::none && ball.nearest != this->Hints[0])
    {
      std::rotate(this->Hints.begin(), this->Hints.end() - 1, this->Hints.end());
      this->Hints[0] = ball.nearest;
    }
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

  MeasuredPart& From;
  const LevelSurface& To;
  double Enough; // the bound so far
  std::array<std::uint32_t, 3> Hints{ SearchedPart::none, SearchedPart::none,
    SearchedPart::none }; // triangles that were near last
};

}

SearchedPart::SearchedPart(std::vector<Vec3> points, std::vector<Triangle> triangles)
  : Points(std::move(points))
  , Corners(std::move(triangles))
{
  for (std::size_t below = this->Corners.size(); below > 0 && (this->Boxes.empty() || below > 1);
       below = this->Boxes.back().size())
  {
    std::vector<Box> boxes((below + arity - 1) / arity);
    for (std::size_t i = 0; i < below; ++i)
    {
      Box& box = boxes[i / arity];
      if (!this->Boxes.empty())
      {
        box.Add(this->Boxes.back()[i]);
        continue;
      }
      for (const VertexId v : this->Corners[i])
      {
        box.Add(this->Points[v]);
      }
    }
    this->Boxes.push_back(std::move(boxes));
  }
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
  if (!this->Boxes.empty() && SquaredToBox(this->Boxes.back().front(), place) < squared)
  {
    this->Search(this->Boxes.size() - 1, 0, place, enough, squared, nearest);
  }
  return nearest;
}

void SearchedPart::Search(std::size_t level, std::size_t index, const Vec3& place, double enough,
  double& squared, std::uint32_t& nearest) const
{
  const std::size_t begin = index * arity;
  if (level == 0)
  {
    const std::size_t end = std::min(this->Corners.size(), begin + arity);
    for (std::size_t i = begin; enough > 0 && i < end; ++i)
    {
      // No triangle is farther than its corners: what is enough is found soon.
      const double corner = SquaredDistance(place, this->At(this->Corners[i][0]));
      if (corner <= enough && corner < squared)
      {
        squared = corner;
        nearest = static_cast<std::uint32_t>(i);
        return;
      }
    }
    for (std::size_t i = begin; i < end && squared > enough; ++i)
    {
      const double here = this->SquaredTo(static_cast<std::uint32_t>(i), place);
      if (here < squared)
      {
        squared = here;
        nearest = static_cast<std::uint32_t>(i);
      }
    }
    return;
  }
  const std::vector<Box>& boxes = this->Boxes[level - 1];
  std::array<std::pair<double, std::size_t>, arity> below;
  std::size_t count = 0;
  for (std::size_t i = begin; i < std::min(boxes.size(), begin + arity); ++i)
  {
    const std::pair<double, std::size_t> next{ SquaredToBox(boxes[i], place), i };
    std::size_t at = count++;
    for (; at > 0 && next < below[at - 1]; --at)
    {
      below[at] = below[at - 1];
    }
    below[at] = next;
  }
  for (std::size_t i = 0; i < count && below[i].first < squared && squared > enough; ++i)
  {
    this->Search(level - 1, below[i].second, place, enough, squared, nearest);
  }
}

MeasuredPart::MeasuredPart(std::vector<Vec3> points, std::span<const Triangle> triangles,
  std::vector<std::int32_t> ballOf, std::span<const Vec3> centres)
  : Points(std::move(points))
  , Triangles(triangles)
  , BallOfPoint(std::move(ballOf))
{
  if (triangles.empty())
  {
    return;
  }
  std::vector<Ball> balls(centres.size());
  for (std::size_t i = 0; i < balls.size(); ++i)
  {
    balls[i].centre = centres[i];
  }
  for (const Triangle& t : triangles)
  {
    if (const std::size_t of = this->BallOf(t); of < balls.size())
    {
      Ball& ball = balls[of];
      for (const VertexId v : t)
      {
        ball.radius = std::max(ball.radius, SquaredDistance(ball.centre, this->Points[v]));
      }
    }
  }
  for (Ball& ball : balls)
  {
    ball.radius = ball.radius < 0 ? -1 : std::sqrt(ball.radius) + RoundedAway(ball.centre);
  }
  this->Balls.push_back(std::move(balls));
  while (this->Balls.back().size() > 1)
  {
    std::vector<Ball> around((this->Balls.back().size() + arity - 1) / arity);
    this->Balls.push_back({});
    for (std::size_t i = 0; i < around.size(); ++i)
    {
      around[i] = this->BallAround(this->Balls.size() - 1, i);
    }
    this->Balls.back() = std::move(around);
  }
}

MeasuredPart::Ball MeasuredPart::BallAround(std::size_t level, std::size_t index) const
{
  const auto [begin, end] = this->GroupOf(level, index);
  const std::span<const Ball> balls(
    this->Balls[level - 1].data() + begin, this->Balls[level - 1].data() + end);
  Box box; // of centres
  for (const Ball& ball : balls)
  {
    if (ball.radius >= 0)
    {
      box.Add(ball.centre);
    }
  }
  Ball around;
  if (box.Empty())
  {
    return around;
  }
  around.centre = { box.lo[0] / 2 + box.hi[0] / 2, box.lo[1] / 2 + box.hi[1] / 2,
    box.lo[2] / 2 + box.hi[2] / 2 };
  for (const Ball& ball : balls)
  {
    if (ball.radius >= 0)
    {
      around.radius = std::max(
        around.radius, std::sqrt(SquaredDistance(around.centre, ball.centre)) + ball.radius);
    }
  }
  around.radius += RoundedAway(around.centre);
  return around;
}

std::pair<std::size_t, std::size_t> MeasuredPart::GroupOf(
  std::size_t level, std::size_t index) const
{
  return { index * arity, std::min((index + 1) * arity, this->Balls[level - 1].size()) };
}

std::span<const Triangle> MeasuredPart::TrianglesOf(std::size_t ball)
{
  if (this->Begin.empty())
  {
    const std::size_t balls = this->Balls.front().size();
    this->Begin.resize(balls + 1);
    for (const Triangle& t : this->Triangles)
    {
      if (const std::size_t of = this->BallOf(t); of < balls)
      {
        ++this->Begin[of + 1];
      }
    }
    std::partial_sum(this->Begin.begin(), this->Begin.end(), this->Begin.begin());
    this->Ordered.resize(this->Begin.back());
    std::vector<std::uint32_t> next(this->Begin.begin(), this->Begin.end() - 1);
    for (const Triangle& t : this->Triangles)
    {
      if (const std::size_t of = this->BallOf(t); of < balls)
      {
        this->Ordered[next[of]++] = t;
      }
    }
  }
  return std::span(this->Ordered)
    .subspan(this->Begin[ball], this->Begin[ball + 1] - this->Begin[ball]);
}

Result<double> FarthestPoint(MeasuredPart& from, const LevelSurface& to, double enough)
{
  return FarthestSearch(from, to, enough).Run();
}

}
