// SPDX-License-Identifier: BSD-3-Clause
// Looks up colours of a finer piece: see FinerColors.h.
#include "filters/texture/levels/FinerColors.h"

#include "filters/core/TriangleDistance.h"
#include "filters/core/UnitVector.h"
#include "filters/core/VectorMath.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace kdstream
{
namespace
{

// The largest side of a grid cell: with this limit, all sums stay finite.
constexpr double largestSide = 1e300;
constexpr std::uint64_t texelsOfLargeImage = 1 << 21;
// Cosines between normals. Above the first, surfaces face the same way: such as a rough surface and
// the simpler one that replaces it. Below the second, a walk stops, because it would go around an
// edge.
constexpr double agreeing = 0.7, turningAway = 0.5;

// Catmull and Rom's cubic weights for a place along one axis, in texels from the centre of texel 0:
// of the two texels on either side of it. Beyond the picture its edge goes on.
struct CubicTaps
{
  std::array<std::size_t, 4> texels{};
  std::array<double, 4> weights{};

  CubicTaps(double place, std::size_t side)
  {
    place = std::clamp(place, 0.0, double(side - 1));
    const auto first = static_cast<std::size_t>(place);
    const double t = place - double(first);
    this->texels = { first - std::min<std::size_t>(first, 1), first, std::min(first + 1, side - 1),
      std::min(first + 2, side - 1) };
    this->weights = { t * (-0.5 + t * (1 - 0.5 * t)), 1 + t * t * (-2.5 + 1.5 * t),
      t * (0.5 + t * (2 - 1.5 * t)), t * t * (-0.5 + 0.5 * t) };
  }
};

}

Picture HalfOf(const Picture& picture)
{
  const std::array<double, 256>& linear = LinearOfBytes();
  const std::size_t components = picture.components, row = picture.width * components;
  const bool hasAlpha = components % 2 == 0;
  Picture half{ (picture.width + 1) / 2, (picture.height + 1) / 2, components, {} };
  half.texels.reserve(half.width * half.height * components);
  for (std::size_t y = 0; y < half.height; ++y)
  {
    for (std::size_t x = 0; x < half.width; ++x)
    {
      const std::size_t right = 2 * x + 1 < picture.width ? components : 0;
      const std::size_t down = 2 * y + 1 < picture.height ? row : 0;
      const std::uint8_t* texel = &picture.texels[2 * y * row + 2 * x * components];
      for (std::size_t k = 0; k < components; ++k, ++texel)
      {
        const std::array<std::uint8_t, 4> four{ texel[0], texel[right], texel[down],
          texel[right + down] };
        const bool isAlpha = hasAlpha && k + 1 == components;
        half.texels.push_back(
          isAlpha ? static_cast<std::uint8_t>((four[0] + four[1] + four[2] + four[3] + 2) / 4)
                  : QuickByteOfLinear(
                      (linear[four[0]] + linear[four[1]] + linear[four[2]] + linear[four[3]]) / 4));
      }
    }
  }
  return half;
}

std::uint8_t QuickByteOfLinear(double value)
{
  constexpr std::size_t steps = 1 << 14;
  static const std::vector<std::uint8_t> table = []
  {
    std::vector<std::uint8_t> bytes;
    for (std::size_t i = 0; i <= steps; ++i)
    {
      bytes.push_back(ByteOfLinear(double(i) / steps));
    }
    return bytes;
  }();
  return table[static_cast<std::size_t>(std::clamp(value, 0.0, 1.0) * steps + 0.5)];
}

FinerColors::FinerColors(FinerTile finer)
  : Finer(std::move(finer))
  , Linear(LinearOfBytes())
{
  const std::vector<Triangle>& triangles = this->Finer.piece.triangles;
  double edges = 0;
  for (const Triangle& t : triangles)
  {
    Ball ball{};
    const Vec3 &a = this->PointOf(t[0]), &b = this->PointOf(t[1]), &c = this->PointOf(t[2]);
    ball.middle = Times(Plus(Plus(a, b), c), 1.0 / 3);
    ball.radius = std::sqrt(std::max({ SquaredDistance(ball.middle, a),
      SquaredDistance(ball.middle, b), SquaredDistance(ball.middle, c) }));
    const Vec3 u = Minus(b, a), v = Minus(c, a);
    ball.normal = UnitVector(Cross(u, v));
    const double uu = Dot(u, u), uv = Dot(u, v), vv = Dot(v, v), determinant = uu * vv - uv * uv;
    if (determinant > 0)
    {
      ball.first = Times(Minus(Times(u, vv), Times(v, uv)), 1 / determinant);
      ball.third = Times(Minus(Times(v, uu), Times(u, uv)), 1 / determinant);
    }
    edges += ball.radius;
    this->Balls.push_back(ball);
    for (const VertexId corner : t)
    {
      this->Bounds.Add(this->PointOf(corner));
    }
  }
  this->Side = triangles.empty() ? 0 : 1.5 * edges / double(triangles.size());
  this->MakeGrid();
  this->FindNeighbours();
}

std::size_t FinerColors::Bytes() const
{
  constexpr std::size_t bytesOfTriangle = 250, bytesOfTexel = 4;
  return bytesOfTriangle * this->Finer.piece.triangles.size() +
         bytesOfTexel * this->Finer.tile.width * this->Finer.tile.height;
}

bool FinerColors::IsLarge() const
{
  return std::uint64_t{ this->Finer.tile.width } * this->Finer.tile.height > texelsOfLargeImage;
}

Result<FinerColors::Shown> FinerColors::HalvedBy(unsigned halvings, std::mutex* oneLarge) const
{
  const std::lock_guard lock(this->Decoding);
  const auto known = this->Pictures.find(halvings);
  const double scale = std::ldexp(1.0, -static_cast<int>(halvings));
  if (known != this->Pictures.end())
  {
    return Shown{ &known->second, scale };
  }
  if (oneLarge && this->IsLarge() && !this->OneLarge.owns_lock())
  {
    this->OneLarge = std::unique_lock(*oneLarge);
  }
  const TextureTile& tile = this->Finer.tile;
  Result<Picture> picture = DecodePicture(tile.image, std::uint64_t{ tile.width } * tile.height);
  KDSTREAM_TRY(picture);
  if (picture->width != tile.width || picture->height != tile.height)
  {
    return Error{ ErrorCode::Damaged, "a tile's image does not have the size that it states" };
  }
  for (unsigned i = 0; i < halvings; ++i)
  {
    *picture = HalfOf(*picture);
  }
  return Shown{ &this->Pictures.emplace(halvings, std::move(*picture)).first->second, scale };
}

Color FinerColors::At(const Shown& shown, const Vec3& place, const Vec3& normal,
  std::uint32_t& near, double& squared) const
{
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Search search{ place, normal, infinity, infinity, noNear };
  if (near < this->Balls.size())
  {
    std::array<double, 2> coordinates{};
    if (this->WalkFrom(near, place, normal, coordinates))
    {
      squared = this->AboveOf(near, place) * this->AboveOf(near, place);
      return this->ColorOn(shown, near, coordinates);
    }
    this->Look(near, search);
  }
  this->FindNearest(search);
  near = search.found;
  squared = search.best;
  if (near == noNear)
  {
    return { 0, 0, 0, 255 };
  }
  const Triangle& corners = this->Finer.piece.triangles[near];
  const Vec3 nearest = NearestOnTriangle(
    place, this->PointOf(corners[0]), this->PointOf(corners[1]), this->PointOf(corners[2]));
  return this->ColorOn(shown, near, this->CoordinatesOf(near, nearest));
}

// Whether a grid with cells of side this->Side is small: it has few cells, and few triangles span
// many of them. Sets Counts.
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

// If an edge has more than two triangles, only the first two are neighbours.
void FinerColors::FindNeighbours()
{
  struct EdgeSide
  {
    std::uint64_t vertices; // the lower vertex in the upper half of the number
    std::uint32_t triangle, edge;
  };
  const std::vector<Triangle>& triangles = this->Finer.piece.triangles;
  std::vector<EdgeSide> sides;
  sides.reserve(3 * triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
  {
    for (std::uint32_t k = 0; k < 3; ++k)
    {
      const auto [low, high] = std::minmax(triangles[t][k], triangles[t][(k + 1) % 3]);
      sides.push_back({ (std::uint64_t{ low } << 32U) | high, t, k });
    }
  }
  std::sort(sides.begin(), sides.end(),
    [](const EdgeSide& a, const EdgeSide& b)
    {
      return a.vertices != b.vertices   ? a.vertices < b.vertices
             : a.triangle != b.triangle ? a.triangle < b.triangle
                                        : a.edge < b.edge;
    });
  this->Beside.assign(triangles.size(), { noNear, noNear, noNear });
  for (std::size_t i = 1; i < sides.size(); ++i)
  {
    const EdgeSide &one = sides[i - 1], &other = sides[i];
    if (one.vertices == other.vertices && (i < 2 || sides[i - 2].vertices != one.vertices))
    {
      this->Beside[one.triangle][one.edge] = other.triangle;
      this->Beside[other.triangle][other.edge] = one.triangle;
    }
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

// Searches cells in shells around the place's own cell, until no further shell can have a nearer
// triangle. If the triangle known so far is near, searches only the few cells within its distance.
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
  // A triangle that faces elsewhere counts as farther away: at a right angle by one cell side, from
  // behind by more than two.
  const double turned =
    std::max(agreeing - Dot(this->Balls[t].normal, search.normal), 0.0) / agreeing * this->Side;
  const double squared = turned * turned + SquaredToTriangle(search.from, this->PointOf(corners[0]),
                                             this->PointOf(corners[1]), this->PointOf(corners[2]));
  if (squared < search.best || (squared == search.best && t < search.found))
  {
    search.best = squared;
    search.reach = std::sqrt(squared);
    search.found = t;
  }
}

// The coordinates of the place, projected to the triangle's plane: along the first and the third
// edge, from the first corner; 0 if the triangle has no area.
std::array<double, 2> FinerColors::CoordinatesOf(std::uint32_t t, const Vec3& place) const
{
  const Vec3 way = Minus(place, this->PointOf(this->Finer.piece.triangles[t][0]));
  return { Dot(way, this->Balls[t].first), Dot(way, this->Balls[t].third) };
}

// Whether a place is so near to a triangle's plane that no nearer triangle is searched for.
bool FinerColors::IsClose(std::uint32_t t, const Vec3& place, const Vec3& normal) const
{
  constexpr double close = 0.25; // relative to the triangle's size
  const Ball& ball = this->Balls[t];
  const double above = this->AboveOf(t, place), most = close * ball.radius;
  return Dot(ball.normal, normal) >= turningAway && above * above <= most * most;
}

// Walks to the triangle over which a place lies. False if it is not found in a few steps, or is not
// close; t is then a triangle on the way.
bool FinerColors::WalkFrom(
  std::uint32_t& t, const Vec3& place, const Vec3& normal, std::array<double, 2>& coordinates) const
{
  constexpr int mostSteps = 8;
  for (int step = 0; step < mostSteps && this->IsClose(t, place, normal); ++step)
  {
    coordinates = this->CoordinatesOf(t, place);
    const auto [s, r] = coordinates;
    const double least = std::min({ s, r, 1 - s - r });
    if (least >= 0)
    {
      return true;
    }
    const std::uint32_t next = this->Beside[t][least == r ? 0 : least == s ? 2 : 1];
    if (!(least < 0) || next == noNear)
    {
      return false;
    }
    t = next;
  }
  return false;
}

Color FinerColors::ColorOn(
  const Shown& shown, std::uint32_t t, const std::array<double, 2>& coordinates) const
{
  const double s = coordinates[0] > 0 ? std::min(coordinates[0], 1.0) : 0;
  const double r = coordinates[1] > 0 ? std::min(coordinates[1], 1.0 - s) : 0;
  const auto& at = this->Finer.tile.corners[t];
  const auto along = [&](std::size_t k)
  { return (1 - s - r) * double(at[0][k]) + s * double(at[1][k]) + r * double(at[2][k]); };
  return this->ColorAt(*shown.picture, along(0) * shown.scale - 0.5, along(1) * shown.scale - 0.5);
}

// Catmull and Rom's cubic interpolation between the centres of sixteen texels. Between four it
// would blur: a level is sampled from the next finer one, so a coarse one has been through it many
// times.
Color FinerColors::ColorAt(const Picture& picture, double x, double y) const
{
  const CubicTaps across(x, picture.width), down(y, picture.height);
  Color color{};
  for (std::size_t j = 0; j < 4; ++j)
  {
    for (std::size_t i = 0; i < 4; ++i)
    {
      this->AddTexel(
        picture, across.texels[i], down.texels[j], across.weights[i] * down.weights[j], color);
    }
  }
  for (std::size_t k = 0; k < color.size(); ++k)
  {
    color[k] = std::clamp(color[k], 0.0, k < 3 ? 1.0 : 255.0);
  }
  return color;
}

void FinerColors::AddTexel(
  const Picture& picture, std::size_t x, std::size_t y, double weight, Color& color) const
{
  const std::size_t components = picture.components;
  const auto texel = RgbaOf(&picture.texels[(y * picture.width + x) * components], components);
  for (std::size_t k = 0; k < 3; ++k)
  {
    color[k] += weight * this->Linear[texel[k]];
  }
  color[3] += weight * texel[3];
}

}
