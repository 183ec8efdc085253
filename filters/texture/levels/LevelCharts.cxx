// SPDX-License-Identifier: BSD-3-Clause
// Makes charts of a level's piece: see LevelCharts.h.
#include "filters/texture/levels/LevelCharts.h"

#include "filters/core/VectorMath.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace kdstream
{
namespace
{

constexpr std::uint32_t noChart = std::numeric_limits<std::uint32_t>::max();
constexpr double growsTo = 0.6, steepest = 0.4; // cosines of the angle to the chart's normal
constexpr double mostSquares = 1 << 22;         // the most squares that are examined for a chart
constexpr double largestChart = 1e300;          // longer sides are cut to this length
constexpr int turns = 8;                        // directions of the axes, within a quarter turn

using ChartPlace = std::array<double, 2>;

// An edge; once for each of its triangles.
struct ChartEdge
{
  std::uint64_t vertices; // the lower vertex in the upper half of the number
  std::uint32_t triangle;
  bool operator<(const ChartEdge& other) const
  {
    return this->vertices != other.vertices ? this->vertices < other.vertices
                                            : this->triangle < other.triangle;
  }
};

// On which side of a line a place is. A place on the line counts as on one side, the same for both
// directions of the line.
bool IsLeftOf(const ChartPlace& a, const ChartPlace& b, const ChartPlace& p)
{
  const bool turned = b < a;
  const ChartPlace &from = turned ? b : a, &to = turned ? a : b;
  const double side = (to[0] - from[0]) * (p[1] - from[1]) - (to[1] - from[1]) * (p[0] - from[0]);
  return turned ? side < 0 : side >= 0;
}

// Which squares of a plane are already covered.
class TakenSquares
{
public:
  TakenSquares(const ChartPlace& lo, const ChartPlace& hi, double side)
    : Lo(lo)
    , Side(side)
  {
    const auto count = [&](std::size_t k)
    {
      const double extent = hi[k] - lo[k];
      return extent > 0 ? std::floor(std::min(extent, largestChart) / this->Side) + 1 : 1;
    };
    while (!(count(0) * count(1) <= mostSquares))
    {
      this->Side *= 2;
    }
    this->Width = static_cast<std::int64_t>(count(0));
    this->Height = static_cast<std::int64_t>(count(1));
    this->Taken.assign(static_cast<std::size_t>(this->Width * this->Height), false);
  }

  // Takes the squares whose centres a counter-clockwise triangle covers. If one of them is already
  // taken, takes none and returns false.
  bool Take(const std::array<ChartPlace, 3>& corners)
  {
    this->Found.clear();
    std::array<std::int64_t, 2> first{}, last{};
    for (std::size_t k = 0; k < 2; ++k)
    {
      const auto [least, most] = std::minmax({ corners[0][k], corners[1][k], corners[2][k] });
      const std::int64_t end = k == 0 ? this->Width : this->Height;
      first[k] = std::clamp<std::int64_t>(this->Square(least, k) - 1, 0, end - 1);
      last[k] = std::clamp<std::int64_t>(this->Square(most, k) + 1, 0, end - 1);
    }
    for (std::int64_t y = first[1]; y <= last[1]; ++y)
    {
      for (std::int64_t x = first[0]; x <= last[0]; ++x)
      {
        const ChartPlace middle{ this->Lo[0] + (double(x) + 0.5) * this->Side,
          this->Lo[1] + (double(y) + 0.5) * this->Side };
        if (IsLeftOf(corners[0], corners[1], middle) && IsLeftOf(corners[1], corners[2], middle) &&
            IsLeftOf(corners[2], corners[0], middle))
        {
          const auto square = static_cast<std::size_t>(y * this->Width + x);
          if (this->Taken[square])
          {
            return false;
          }
          this->Found.push_back(square);
        }
      }
    }
    for (const std::size_t square : this->Found)
    {
      this->Taken[square] = true;
    }
    return true;
  }

private:
  std::int64_t Square(double at, std::size_t k) const
  {
    const double square = (at - this->Lo[k]) / this->Side;
    return square > 0 ? static_cast<std::int64_t>(std::min(square, mostSquares)) : 0;
  }

  ChartPlace Lo;
  double Side;
  std::int64_t Width = 1, Height = 1;
  std::vector<bool> Taken;
  std::vector<std::size_t> Found;
};

class ChartGrower
{
public:
  ChartGrower(std::span<const Vec3> points, std::span<const Triangle> triangles, double spacing)
    : Points(points)
    , Triangles(triangles)
    , Spacing(spacing)
  {
  }

  std::vector<LevelChart> Grow()
  {
    this->FindNormals();
    this->FindNeighbours();
    this->ChartOf.assign(this->Triangles.size(), noChart);
    this->Seen.assign(this->Triangles.size(), noChart);
    for (std::uint32_t t = 0; t < this->Triangles.size(); ++t)
    {
      while (this->ChartOf[t] == noChart) // a chart may leave out its first triangle
      {
        this->Charts.push_back(this->ChartFrom(t));
      }
    }
    return std::move(this->Charts);
  }

private:
  bool HasArea(std::uint32_t t) const { return this->Areas[t] > 0; }

  void FindNormals()
  {
    for (const Triangle& t : this->Triangles)
    {
      const Vec3& a = this->Points[t[0]];
      const Vec3 normal = Cross(Minus(this->Points[t[1]], a), Minus(this->Points[t[2]], a));
      const double length = Length(normal);
      const bool has = length > 0 && std::isfinite(length);
      this->Areas.push_back(has ? length : 0);
      this->Normals.push_back(has ? Times(normal, 1 / length) : Vec3{});
    }
  }

  void FindNeighbours()
  {
    std::vector<ChartEdge> edges;
    edges.reserve(3 * this->Triangles.size());
    for (std::uint32_t t = 0; t < this->Triangles.size(); ++t)
    {
      for (std::size_t k = 0; k < 3; ++k)
      {
        const auto [low, high] =
          std::minmax(this->Triangles[t][k], this->Triangles[t][(k + 1) % 3]);
        edges.push_back({ (std::uint64_t{ low } << 32U) | high, t });
      }
    }
    std::sort(edges.begin(), edges.end());
    // If several triangles share an edge, each is a neighbour of the one before it and the one
    // after it in the list.
    std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
    for (std::size_t i = 1; i < edges.size(); ++i)
    {
      if (edges[i].vertices == edges[i - 1].vertices)
      {
        pairs.emplace_back(edges[i].triangle, edges[i - 1].triangle);
        pairs.emplace_back(edges[i - 1].triangle, edges[i].triangle);
      }
    }
    std::sort(pairs.begin(), pairs.end());
    this->FirstBeside.assign(this->Triangles.size() + 1, 0);
    for (const auto& [of, beside] : pairs)
    {
      ++this->FirstBeside[of + 1];
      this->Beside.push_back(beside);
    }
    for (std::size_t t = 0; t < this->Triangles.size(); ++t)
    {
      this->FirstBeside[t + 1] += this->FirstBeside[t];
    }
  }

  LevelChart ChartFrom(std::uint32_t seed)
  {
    Vec3 sum{}; // sum of normals, weighted by area
    std::vector<std::uint32_t> grown = this->GrownFrom(seed, sum);
    const double length = Length(sum);
    LevelChart chart;
    chart.triangles =
      length > 0 ? this->Unfold(std::move(grown), Times(sum, 1 / length)) : std::move(grown);
    Vec3 normal = length > 0 ? Times(sum, 1 / length) : Vec3{ 0, 0, 1 };
    if (chart.triangles.empty())
    {
      chart.triangles = { seed };
      normal = this->HasArea(seed) ? this->Normals[seed] : normal;
    }
    const auto number = static_cast<std::uint32_t>(this->Charts.size());
    for (const std::uint32_t t : chart.triangles)
    {
      this->ChartOf[t] = number;
    }
    this->ChooseAxes(chart, normal);
    return chart;
  }

  std::vector<std::uint32_t> GrownFrom(std::uint32_t seed, Vec3& sum)
  {
    const auto number = static_cast<std::uint32_t>(this->Charts.size());
    std::vector<std::uint32_t> grown{ seed };
    this->Seen[seed] = number;
    sum = Times(this->Normals[seed], this->Areas[seed]);
    for (std::size_t i = 0; i < grown.size(); ++i)
    {
      for (std::uint32_t k = this->FirstBeside[grown[i]]; k < this->FirstBeside[grown[i] + 1]; ++k)
      {
        const std::uint32_t t = this->Beside[k];
        if (this->ChartOf[t] == noChart && this->Seen[t] != number &&
            Dot(this->Normals[t], sum) >= (this->HasArea(t) ? growsTo * Length(sum) : 0))
        {
          this->Seen[t] = number;
          grown.push_back(t);
          sum = Plus(sum, Times(this->Normals[t], this->Areas[t]));
        }
      }
    }
    return grown;
  }

  static std::pair<Vec3, Vec3> AxesOf(const Vec3& normal)
  {
    std::size_t least = 0;
    for (std::size_t k = 1; k < 3; ++k)
    {
      least = std::abs(normal[k]) < std::abs(normal[least]) ? k : least;
    }
    Vec3 along{};
    along[least] = 1;
    const Vec3 across = Cross(along, normal);
    const Vec3 u = Times(across, 1 / Length(across));
    return { u, Cross(normal, u) };
  }

  std::array<ChartPlace, 3> Project(std::uint32_t t, const Vec3& u, const Vec3& v) const
  {
    std::array<ChartPlace, 3> places{};
    for (std::size_t k = 0; k < 3; ++k)
    {
      const Vec3& point = this->Points[this->Triangles[t][k]];
      places[k] = { Dot(point, u), Dot(point, v) };
    }
    return places;
  }

  // The triangles that can lie side by side on the plane.
  std::vector<std::uint32_t> Unfold(std::vector<std::uint32_t> grown, const Vec3& normal) const
  {
    const auto [u, v] = AxesOf(normal);
    std::erase_if(grown, [&, &n = normal](std::uint32_t t)
      { return this->HasArea(t) && Dot(this->Normals[t], n) < steepest; });
    if (grown.empty())
    {
      return grown;
    }
    LevelChart box;
    box.triangles = grown;
    this->MeasureBox(box, u, v);
    TakenSquares squares(box.lo, box.hi, this->Spacing);
    std::erase_if(grown, [&, &along = u, &across = v](std::uint32_t t)
      { return this->HasArea(t) && !squares.Take(this->Project(t, along, across)); });
    return grown;
  }

  void MeasureBox(LevelChart& chart, const Vec3& u, const Vec3& v) const
  {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    chart.u = u;
    chart.v = v;
    chart.lo = { infinity, infinity };
    chart.hi = { -infinity, -infinity };
    for (const std::uint32_t t : chart.triangles)
    {
      for (const ChartPlace& place : this->Project(t, u, v))
      {
        for (std::size_t k = 0; k < 2; ++k)
        {
          chart.lo[k] = std::min(chart.lo[k], place[k]);
          chart.hi[k] = std::max(chart.hi[k], place[k]);
        }
      }
    }
  }

  // Chooses the box of the smallest area, and lays it on its longer side, so that shelves are low.
  void ChooseAxes(LevelChart& chart, const Vec3& normal) const
  {
    const auto [u, v] = AxesOf(normal);
    const auto turned = [](const Vec3& a, const Vec3& b, double cosine, double sine)
    { return Plus(Times(a, cosine), Times(b, sine)); };
    double least = std::numeric_limits<double>::infinity();
    LevelChart best;
    for (int turn = 0; turn < turns; ++turn)
    {
      // Nearly even angles, without a sine: from the tangent of half the angle.
      const double half = 0.41421356237309503 * turn / turns;
      const double cosine = (1 - half * half) / (1 + half * half);
      const double sine = 2 * half / (1 + half * half);
      for (const bool quarter : { false, true })
      {
        const Vec3 along = turned(u, v, quarter ? -sine : cosine, quarter ? cosine : sine);
        const Vec3 across = turned(u, v, quarter ? -cosine : -sine, quarter ? -sine : cosine);
        this->MeasureBox(chart, along, across);
        const double width = chart.hi[0] - chart.lo[0], height = chart.hi[1] - chart.lo[1];
        if (width >= height && width * height < least)
        {
          least = width * height;
          best.u = chart.u;
          best.v = chart.v;
        }
      }
    }
    if (least == std::numeric_limits<double>::infinity())
    {
      best.u = u;
      best.v = v;
    }
    this->MeasureBox(chart, best.u, best.v);
  }

  const std::span<const Vec3> Points;
  const std::span<const Triangle> Triangles;
  const double Spacing;
  std::vector<Vec3> Normals; // of length 1; 0 for a triangle without area
  std::vector<double> Areas; // twice the areas
  // For each triangle, the triangles that share an edge with it.
  std::vector<std::uint32_t> FirstBeside, Beside;
  std::vector<std::uint32_t> ChartOf, Seen; // by number of the chart
  std::vector<LevelChart> Charts;
};

}

std::vector<LevelChart> GrowLevelCharts(
  std::span<const Vec3> points, std::span<const Triangle> triangles, double spacing)
{
  return ChartGrower(points, triangles, spacing).Grow();
}

}
