// SPDX-License-Identifier: BSD-3-Clause
// Colours of a finer piece: see FinerColors.h.
#include "filters/texture/levels/FinerColors.h"

#include "filters/core/TriangleDistance.h"
#include "filters/core/VectorMath.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kdstream
{
namespace
{

// Of a box, for its grid: a longer one has cells of this size, and all sums stay finite.
constexpr double largestSide = 1e300;

}

FinerColors::FinerColors(const FinerTile& finer, const Picture& picture)
  : Finer(finer)
  , Image(picture)
  , Linear(LinearOfBytes())
{
  const std::vector<Triangle>& triangles = finer.piece.triangles;
  double edges = 0;
  for (const Triangle& t : triangles)
  {
    Ball ball{};
    const Vec3 &a = this->PointOf(t[0]), &b = this->PointOf(t[1]), &c = this->PointOf(t[2]);
    ball.middle = Times(Plus(Plus(a, b), c), 1.0 / 3);
    ball.radius = std::sqrt(std::max({ SquaredDistance(ball.middle, a),
      SquaredDistance(ball.middle, b), SquaredDistance(ball.middle, c) }));
    ball.normal = Cross(Minus(b, a), Minus(c, a));
    edges += ball.radius;
    this->Balls.push_back(ball);
    for (const VertexId corner : t)
    {
      this->Bounds.Add(this->PointOf(corner));
    }
  }
  this->Side = triangles.empty() ? 0 : 1.5 * edges / double(triangles.size());
  this->MakeGrid();
}

Color FinerColors::At(const Vec3& place, const Vec3& normal, std::uint32_t& near) const
{
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Search search{ place, normal, infinity, infinity, noNear };
  if (near < this->Balls.size())
  {
    if (const auto coordinates = this->CloseAbove(near, place, normal))
    {
      return this->ColorOn(near, *coordinates);
    }
    this->Look(near, search);
  }
  this->FindNearest(search);
  near = search.found;
  if (near == noNear)
  {
    return { 0, 0, 0, 255 };
  }
  const Triangle& corners = this->Finer.piece.triangles[near];
  const Vec3 nearest = NearestOnTriangle(
    place, this->PointOf(corners[0]), this->PointOf(corners[1]), this->PointOf(corners[2]));
  return this->ColorOn(near, this->CoordinatesOf(near, nearest));
}

// Whether a grid of cells of this.Side is small: it has few cells, and triangles that span many of
// them are few. Sets Counts.
bool FinerColors::CountCells()
{
  constexpr double mostCells = 1 << 20, cellsOfTriangle = 32;
  double cells = 1;
  for (std::size_t k = 0; k < 3; ++k)
  {
    const double side = this->Bounds.hi[k] - this->Bounds.lo[k];
    const double count = std::floor(std::min(side, largestSide) / this->Side) + 1;
    cells *= count;
    this->Counts[k] = static_cast<std::int64_t>(std::min(count, mostCells));
  }
  if (!(cells <= mostCells))
  {
    return false;
  }
  double listed = 0;
  for (std::uint32_t t = 0; t < this->Balls.size(); ++t)
  {
    const auto [lo, hi] = this->CellsOf(t);
    listed += double(hi[0] - lo[0] + 1) * double(hi[1] - lo[1] + 1) * double(hi[2] - lo[2] + 1);
  }
  return listed <= std::max(mostCells, cellsOfTriangle * double(this->Balls.size()));
}

void FinerColors::MakeGrid()
{
  if (this->Bounds.Empty())
  {
    return;
  }
  const Vec3 sides = Minus(this->Bounds.hi, this->Bounds.lo);
  const double longest = std::min(std::max({ sides[0], sides[1], sides[2] }), largestSide);
  this->Side = std::isfinite(this->Side) ? std::max(this->Side, longest * 1e-4) : longest;
  this->Side = this->Side > 0 ? this->Side : 1;
  while (!this->CountCells())
  {
    this->Side *= 1.5;
  }
  const auto cells = static_cast<std::size_t>(this->Counts[0] * this->Counts[1] * this->Counts[2]);
  this->First.assign(cells + 1, 0);
  const auto triangles = static_cast<std::uint32_t>(this->Balls.size());
  for (std::uint32_t t = 0; t < triangles; ++t)
  {
    this->VisitCells(t, [this](std::size_t cell) { ++this->First[cell + 1]; });
  }
  for (std::size_t cell = 0; cell < cells; ++cell)
  {
    this->First[cell + 1] += this->First[cell];
  }
  this->Listed.resize(this->First.back());
  std::vector<std::uint32_t> next(this->First.begin(), this->First.end() - 1);
  for (std::uint32_t t = 0; t < triangles; ++t)
  {
    this->VisitCells(t, [&](std::size_t cell) { this->Listed[next[cell]++] = t; });
  }
}

FinerColors::Cell FinerColors::CellOf(const Vec3& place) const
{
  Cell cell{};
  for (std::size_t k = 0; k < 3; ++k)
  {
    const double at = (place[k] - this->Bounds.lo[k]) / this->Side;
    cell[k] = at > 0 ? static_cast<std::int64_t>(std::min(at, double(this->Counts[k] - 1))) : 0;
  }
  return cell;
}

std::pair<FinerColors::Cell, FinerColors::Cell> FinerColors::CellsOf(std::uint32_t t) const
{
  Box box;
  for (const VertexId corner : this->Finer.piece.triangles[t])
  {
    box.Add(this->PointOf(corner));
  }
  return { this->CellOf(box.lo), this->CellOf(box.hi) };
}

template <class Visit>
void FinerColors::VisitCells(std::uint32_t t, const Visit& visit) const
{
  const auto [lo, hi] = this->CellsOf(t);
  for (std::int64_t z = lo[2]; z <= hi[2]; ++z)
  {
    for (std::int64_t y = lo[1]; y <= hi[1]; ++y)
    {
      for (std::int64_t x = lo[0]; x <= hi[0]; ++x)
      {
        visit(this->NumberOf(x, y, z));
      }
    }
  }
}

// Cells in shells around the place's own, until no shell can have what is nearer; but where little
// is as near as what is known already, just that.
void FinerColors::FindNearest(Search& search) const
{
  if (search.found != noNear && search.reach <= this->Side)
  {
    const Vec3 reach{ search.reach, search.reach, search.reach };
    const Cell lo = this->CellOf(Minus(search.from, reach));
    const Cell hi = this->CellOf(Plus(search.from, reach));
    for (std::int64_t z = lo[2]; z <= hi[2]; ++z)
    {
      for (std::int64_t y = lo[1]; y <= hi[1]; ++y)
      {
        for (std::int64_t x = lo[0]; x <= hi[0]; ++x)
        {
          this->SearchCell(this->NumberOf(x, y, z), search);
        }
      }
    }
    return;
  }
  const Cell middle = this->CellOf(search.from);
  const std::int64_t last = std::max({ this->Counts[0], this->Counts[1], this->Counts[2] });
  for (std::int64_t shell = 0; shell <= last && !this->First.empty(); ++shell)
  {
    if (shell > 1 && search.reach <= double(shell - 1) * this->Side)
    {
      return;
    }
    this->SearchShell(middle, shell, search);
  }
}

void FinerColors::SearchShell(const Cell& middle, std::int64_t shell, Search& search) const
{
  Cell lo{}, hi{};
  for (std::size_t k = 0; k < 3; ++k)
  {
    lo[k] = std::max<std::int64_t>(middle[k] - shell, 0);
    hi[k] = std::min(middle[k] + shell, this->Counts[k] - 1);
  }
  for (std::int64_t z = lo[2]; z <= hi[2]; ++z)
  {
    for (std::int64_t y = lo[1]; y <= hi[1]; ++y)
    {
      const bool isFace =
        std::abs(z - middle[2]) == shell || std::abs(y - middle[1]) == shell || shell == 0;
      for (std::int64_t x = isFace ? lo[0] : middle[0] - shell; x <= hi[0];
           x += isFace ? 1 : 2 * shell)
      {
        if (x >= 0)
        {
          this->SearchCell(this->NumberOf(x, y, z), search);
        }
      }
    }
  }
}

void FinerColors::SearchCell(std::size_t cell, Search& search) const
{
  for (std::uint32_t i = this->First[cell]; i < this->First[cell + 1]; ++i)
  {
    const std::uint32_t t = this->Listed[i];
    const double reach = this->Balls[t].radius + search.reach;
    if (SquaredDistance(search.from, this->Balls[t].middle) <= reach * reach)
    {
      this->Look(t, search);
    }
  }
}

void FinerColors::Look(std::uint32_t t, Search& search) const
{
  const Triangle& corners = this->Finer.piece.triangles[t];
  const double turned = Dot(this->Balls[t].normal, search.normal) < 0 ? this->Side * this->Side : 0;
  const double squared = turned + SquaredToTriangle(search.from, this->PointOf(corners[0]),
                                    this->PointOf(corners[1]), this->PointOf(corners[2]));
  if (squared < search.best || (squared == search.best && t < search.found))
  {
    search.best = squared;
    search.reach = std::sqrt(squared);
    search.found = t;
  }
}

// Of the projection on the triangle's plane: along its first and its third edge, from its first
// corner. 0 where it has no area.
std::array<double, 2> FinerColors::CoordinatesOf(std::uint32_t t, const Vec3& place) const
{
  const Triangle& corners = this->Finer.piece.triangles[t];
  const Vec3& a = this->PointOf(corners[0]);
  const Vec3 u = Minus(this->PointOf(corners[1]), a), v = Minus(this->PointOf(corners[2]), a);
  const Vec3 w = Minus(place, a);
  const double uu = Dot(u, u), uv = Dot(u, v), vv = Dot(v, v);
  const double wu = Dot(w, u), wv = Dot(w, v), determinant = uu * vv - uv * uv;
  return determinant > 0 ? std::array<double, 2>{ (vv * wu - uv * wv) / determinant,
    (uu * wv - uv * wu) / determinant }
                         : std::array<double, 2>{};
}

// If a place is so close to the inside of a triangle that none is looked for that is nearer.
std::optional<std::array<double, 2>> FinerColors::CloseAbove(
  std::uint32_t t, const Vec3& place, const Vec3& normal) const
{
  constexpr double close = 0.25; // of the triangle's size
  const Ball& ball = this->Balls[t];
  const double above =
    Dot(ball.normal, Minus(place, this->PointOf(this->Finer.piece.triangles[t][0])));
  const double squared = Dot(ball.normal, ball.normal), most = close * ball.radius;
  if (!(Dot(ball.normal, normal) > 0 && above * above <= most * most * squared))
  {
    return {};
  }
  const auto at = this->CoordinatesOf(t, place);
  return at[0] >= 0 && at[1] >= 0 && at[0] + at[1] <= 1 ? std::optional(at) : std::nullopt;
}

Color FinerColors::ColorOn(std::uint32_t t, const std::array<double, 2>& coordinates) const
{
  const double s = std::clamp(coordinates[0], 0.0, 1.0);
  const double r = std::clamp(coordinates[1], 0.0, 1.0 - s);
  const auto& at = this->Finer.tile.corners[t];
  const auto along = [&](std::size_t k)
  { return (1 - s - r) * double(at[0][k]) + s * double(at[1][k]) + r * double(at[2][k]); };
  return this->ColorAt(along(0) - 0.5, along(1) - 0.5);
}

// Between the middles of four texels.
Color FinerColors::ColorAt(double x, double y) const
{
  const auto inside = [](double at, std::size_t side)
  { return std::clamp(at, 0.0, double(side - 1)); };
  x = inside(x, this->Image.width);
  y = inside(y, this->Image.height);
  const auto left = static_cast<std::size_t>(x), upper = static_cast<std::size_t>(y);
  const std::size_t right = std::min(left + 1, this->Image.width - 1);
  const std::size_t lower = std::min(upper + 1, this->Image.height - 1);
  const double h = x - double(left), w = y - double(upper);
  Color color{};
  this->AddTexel(left, upper, (1 - h) * (1 - w), color);
  this->AddTexel(right, upper, h * (1 - w), color);
  this->AddTexel(left, lower, (1 - h) * w, color);
  this->AddTexel(right, lower, h * w, color);
  return color;
}

void FinerColors::AddTexel(std::size_t x, std::size_t y, double weight, Color& color) const
{
  const std::size_t components = this->Image.components;
  const auto texel =
    RgbaOf(&this->Image.texels[(y * this->Image.width + x) * components], components);
  for (std::size_t k = 0; k < 3; ++k)
  {
    color[k] += weight * this->Linear[texel[k]];
  }
  color[3] += weight * texel[3];
}

}
