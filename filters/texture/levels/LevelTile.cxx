// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. decide how far apart texels are
// 2. make charts, and pack them
// 3. find out which triangle each texel shows
// 4. find the texels' colours, finer piece by finer piece
// 5. fill texels that no chart covers
// 6. encode; if the image is too large, repeat with fewer texels.
#include "filters/texture/levels/LevelTile.h"

#include "filters/core/Light.h"
#include "filters/core/UnitVector.h"
#include "filters/core/VectorMath.h"
#include "filters/texture/PackBoxes.h"
#include "filters/texture/Picture.h"
#include "filters/texture/WritePicture.h"
#include "filters/texture/levels/FillTexels.h"
#include "filters/texture/levels/FinerColors.h"
#include "filters/texture/levels/LevelCharts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace kdstream
{
namespace
{

constexpr std::int64_t levelGutter = 2; // in texels of the tile
constexpr unsigned mostPictureHalvings = 6;
constexpr double mostTexelsOff = 1; // from the finer surface, where no other piece is tried
constexpr double wider = 1.15;      // factor for the next try
constexpr std::uint32_t noOwner = std::numeric_limits<std::uint32_t>::max();

using TexelPlaces = std::array<std::array<double, 2>, 3>; // of a triangle's corners, in texels

// The plane in space on which texels lie: a triangle's corner, and steps of one texel to the right
// and down.
struct TexelPlane
{
  std::array<double, 2> from{}; // the corner, in texels
  Vec3 corner{}, right{}, down{};
};

double TwiceAreaOf(const Vec3& a, const Vec3& b, const Vec3& c)
{
  const double area = Length(Cross(Minus(b, a), Minus(c, a)));
  return std::isfinite(area) ? area : 0;
}

double TwiceAreaOf(const std::array<TileCoordinate, 3>& at)
{
  return std::abs((double(at[1][0]) - at[0][0]) * (double(at[2][1]) - at[0][1]) -
                  (double(at[1][1]) - at[0][1]) * (double(at[2][0]) - at[0][0]));
}

class LevelTileMaker
{
public:
  LevelTileMaker(const Piece& piece, const FinerTiles& finer, const LevelTileOptions& options)
    : P(piece)
    , Finer(finer)
    , Options(options)
  {
  }

  Result<MadeTile> Make()
  {
    KDSTREAM_TRY(this->ChooseSpacing());
    this->FindNormals();
    this->Charts = GrowLevelCharts(this->P.positions, this->P.triangles, this->Spacing);
    this->TurnCharts();
    constexpr int mostTries = 30;
    for (int tries = 0; tries < mostTries; ++tries)
    {
      KDSTREAM_TRY(this->Pack());
      this->PlaceCharts();
      this->FindOwners();
      KDSTREAM_TRY(this->Sample());
      FillTexels(this->Texels, this->HasColor, this->Packed.width);
      KDSTREAM_TRY(this->Encode());
      const std::size_t bytes = this->Tile.image.size();
      if (this->Options.mostBytes == 0 || bytes <= this->Options.mostBytes || this->IsLeast())
      {
        break;
      }
      this->Spacing *=
        std::max(wider, std::min(2.0, std::sqrt(double(bytes) / double(this->Options.mostBytes))));
    }
    this->Counts.tiles = 1;
    this->Counts.texels = static_cast<std::uint64_t>(this->Packed.width * this->Packed.height);
    this->Counts.triangles = this->P.triangles.size();
    return MadeTile{ std::move(this->Tile), this->Counts };
  }

private:
  // Turns the axes of charts a little, to what a tile stores: all that follows uses these.
  void TurnCharts()
  {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    for (LevelChart& chart : this->Charts)
    {
      this->Tile.planar.charts.push_back({ {}, TurnOf(chart) });
      const auto axes = AxesOf(this->Tile.planar.charts.back());
      chart.u = axes[0];
      chart.v = axes[1];
      chart.lo = { infinity, infinity };
      chart.hi = { -infinity, -infinity };
      for (const std::uint32_t t : chart.triangles)
      {
        for (const VertexId vertex : this->P.triangles[t])
        {
          const Vec3 from = Minus(this->P.positions[vertex], this->P.positions[0]);
          for (std::size_t k = 0; k < 2; ++k)
          {
            chart.lo[k] = std::min(chart.lo[k], Dot(from, axes[k]));
            chart.hi[k] = std::max(chart.hi[k], Dot(from, axes[k]));
          }
        }
      }
    }
  }

  // The quaternion of the rotation whose first rows are the chart's axes: from the row of the
  // matrix of its products with the largest square.
  static std::array<std::int32_t, 3> TurnOf(const LevelChart& chart)
  {
    const Vec3 &a = chart.u, &b = chart.v, c = Cross(a, b);
    const std::array<std::array<double, 4>, 4> products{ {
      { 1 + a[0] - b[1] - c[2], a[1] + b[0], a[2] + c[0], c[1] - b[2] },
      { a[1] + b[0], 1 - a[0] + b[1] - c[2], b[2] + c[1], a[2] - c[0] },
      { a[2] + c[0], b[2] + c[1], 1 - a[0] - b[1] + c[2], b[0] - a[1] },
      { c[1] - b[2], a[2] - c[0], b[0] - a[1], 1 + a[0] + b[1] + c[2] },
    } };
    std::size_t largest = 0;
    for (std::size_t i = 1; i < 4; ++i)
    {
      largest = products[i][i] > products[largest][largest] ? i : largest;
    }
    const std::array<double, 4>& row = products[largest];
    double squared = 0;
    for (const double product : row)
    {
      squared += product * product;
    }
    const double scale = (row[3] < 0 ? -turnSteps : turnSteps) / std::sqrt(squared);
    std::array<std::int32_t, 3> turn{};
    for (std::size_t k = 0; k < 3; ++k)
    {
      turn[k] = static_cast<std::int32_t>(std::nearbyint(row[k] * scale));
    }
    return turn;
  }

  Status ChooseSpacing()
  {
    double area = 0;
    for (const Triangle& t : this->P.triangles)
    {
      area +=
        TwiceAreaOf(this->P.positions[t[0]], this->P.positions[t[1]], this->P.positions[t[2]]);
    }
    double finerVertices = 0;
    KDSTREAM_TRY(this->MeasureFiner(this->Finest, finerVertices));
    const double doublings = finerVertices / 2 / std::max(1U, this->P.ownVertices);
    const double texels = this->Options.texelsPerVertex * std::max(1.0, doublings) *
                          std::max(1U, this->P.VertexCount());
    this->Spacing = std::max(std::sqrt(area / 2 / texels), this->Finest);
    if (!(this->Spacing > 0))
    {
      this->Spacing = 1;
    }
    return {};
  }

  void FindNormals()
  {
    for (const Triangle& t : this->P.triangles)
    {
      const Vec3& a = this->P.positions[t[0]];
      this->Normals.push_back(
        UnitVector(Cross(Minus(this->P.positions[t[1]], a), Minus(this->P.positions[t[2]], a))));
    }
  }

  // Measures how far apart the finer texels are, 0 if they show no surface; and counts the vertices
  // below the piece.
  Status MeasureFiner(double& spacing, double& vertices) const
  {
    double area = 0, texels = 0;
    for (std::size_t i = 0; i < this->Finer.places.size(); ++i)
    {
      if (!this->Finer.places[i].below)
      {
        continue;
      }
      const auto read = this->Finer.read(i);
      KDSTREAM_TRY(read);
      const FinerTile& finer = (*read)->Of();
      const std::vector<Vec3>& at = finer.piece.positions;
      vertices += double(finer.piece.ownVertices);
      for (std::size_t t = 0; t < finer.piece.triangles.size(); ++t)
      {
        const Triangle& corners = finer.piece.triangles[t];
        const double covered = TwiceAreaOf(finer.tile.corners[t]);
        area += covered > 0 ? TwiceAreaOf(at[corners[0]], at[corners[1]], at[corners[2]]) : 0;
        texels += covered;
      }
    }
    spacing = texels > 0 ? std::sqrt(area / texels) : 0;
    return {};
  }

  std::array<std::int64_t, 2> SizeOf(const LevelChart& chart) const
  {
    std::array<std::int64_t, 2> size{};
    for (std::size_t k = 0; k < 2; ++k)
    {
      // The limit is far more than any tile has; such a tile is tried again with fewer texels.
      const double texels = std::min((chart.hi[k] - chart.lo[k]) / this->Spacing, 1e6);
      size[k] = static_cast<std::int64_t>(std::ceil(texels > 0 ? texels : 0)) + 1 + 2 * levelGutter;
    }
    return size;
  }

  bool IsLeast() const
  {
    return std::all_of(this->Charts.begin(), this->Charts.end(),
      [this](const LevelChart& chart)
      { return std::max(this->SizeOf(chart)[0], this->SizeOf(chart)[1]) <= 2 + 2 * levelGutter; });
  }

  Status Pack()
  {
    for (std::int64_t side = this->Options.mostSide;;)
    {
      std::vector<std::array<std::int64_t, 2>> sizes;
      std::transform(this->Charts.begin(), this->Charts.end(), std::back_inserter(sizes),
        [this](const LevelChart& chart) { return this->SizeOf(chart); });
      if (auto packed = PackBoxes(sizes, side))
      {
        this->Packed = std::move(*packed);
        return {};
      }
      if (!this->IsLeast())
      {
        this->Spacing *= wider;
        continue;
      }
      if (side >= std::int64_t{ longestTileSide })
      {
        return Error{ ErrorCode::LimitExceeded,
          "a piece of a level has too many charts for a tile" };
      }
      side = std::min<std::int64_t>(2 * side, longestTileSide);
    }
  }

  // Decides where charts lie, as a tile stores it.
  void PlaceCharts()
  {
    this->Tile.planar.texels = 1 / this->Spacing;
    for (std::size_t i = 0; i < this->Charts.size(); ++i)
    {
      for (std::size_t k = 0; k < 2; ++k)
      {
        const double from = double(this->Packed.places[i][k] + levelGutter) + 0.5;
        this->Tile.planar.charts[i].offset[k] = static_cast<std::int64_t>(std::nearbyint(
          (from - this->Charts[i].lo[k] * this->Tile.planar.texels) * coarseTileSteps));
      }
    }
  }

  TexelPlaces PlacesOf(std::size_t chart, std::uint32_t t) const
  {
    TexelPlaces places{};
    for (std::size_t k = 0; k < 3; ++k)
    {
      const Vec3& point = this->P.positions[this->P.triangles[t][k]];
      const TileCoordinate at = PlaceOfCorner(this->Tile.planar, this->Tile.planar.charts[chart],
        { this->Charts[chart].u, this->Charts[chart].v }, Minus(point, this->P.positions[0]));
      places[k] = { double(at[0]), double(at[1]) };
    }
    return places;
  }

  // Finds the nearest triangle of each texel, and where corners lie.
  void FindOwners()
  {
    const auto size = static_cast<std::size_t>(this->Packed.width * this->Packed.height);
    this->Owners.assign(size, noOwner);
    this->Tile.corners.assign(this->P.triangles.size(), {});
    this->Planes.assign(this->P.triangles.size(), {});
    this->Charted.assign(this->P.triangles.size(), 0);
    std::vector<float> outside(size, float(levelGutter));
    for (std::size_t chart = 0; chart < this->Charts.size(); ++chart)
    {
      for (const std::uint32_t t : this->Charts[chart].triangles)
      {
        const TexelPlaces at = this->PlacesOf(chart, t);
        this->Planes[t] = this->PlaneOf(t, at);
        this->Charted[t] = static_cast<std::uint32_t>(chart);
        for (std::size_t k = 0; k < 3; ++k)
        {
          this->Tile.corners[t][k] = { float(at[k][0]), float(at[k][1]) };
        }
        this->Claim(chart, t, at, outside);
      }
    }
  }

  // Claims the texels in a triangle, and those in the gutter around it to which no other triangle
  // is nearer.
  void Claim(std::size_t chart, std::uint32_t t, const TexelPlaces& at, std::vector<float>& outside)
  {
    std::array<std::array<double, 3>, 3> lines{}; // distance outside of each edge
    for (std::size_t k = 0; k < 3; ++k)
    {
      const auto &a = at[k], &b = at[(k + 1) % 3];
      const double x = b[0] - a[0], y = b[1] - a[1], length = std::sqrt(x * x + y * y);
      if (!(length > 1e-6))
      {
        return;
      }
      lines[k] = { y / length, -x / length, (x * a[1] - y * a[0]) / length };
    }
    const auto size = this->SizeOf(this->Charts[chart]);
    std::array<std::int64_t, 2> first{}, end{};
    for (std::size_t k = 0; k < 2; ++k)
    {
      const std::int64_t begin = this->Packed.places[chart][k];
      const auto [least, most] = std::minmax({ at[0][k], at[1][k], at[2][k] });
      first[k] = std::max(begin, static_cast<std::int64_t>(least) - levelGutter);
      end[k] = std::min(begin + size[k], static_cast<std::int64_t>(most) + levelGutter + 1);
    }
    for (std::int64_t y = first[1]; y < end[1]; ++y)
    {
      for (std::int64_t x = first[0]; x < end[0]; ++x)
      {
        const auto far = [&](const std::array<double, 3>& line)
        { return line[0] * (double(x) + 0.5) + line[1] * (double(y) + 0.5) + line[2]; };
        const double most = std::max({ far(lines[0]), far(lines[1]), far(lines[2]), 0.0 });
        const auto texel = static_cast<std::size_t>(y * this->Packed.width + x);
        if (float(most) < outside[texel])
        {
          outside[texel] = float(most);
          this->Owners[texel] = t;
        }
      }
    }
  }

  // Also for texels beyond the triangle's edges.
  TexelPlane PlaneOf(std::uint32_t t, const TexelPlaces& at) const
  {
    constexpr double leastTexels = 1e-9; // twice the area; less is a point
    const Triangle& corners = this->P.triangles[t];
    const Vec3& a = this->P.positions[corners[0]];
    const double ux = at[1][0] - at[0][0], uy = at[1][1] - at[0][1];
    const double vx = at[2][0] - at[0][0], vy = at[2][1] - at[0][1];
    const double determinant = ux * vy - uy * vx;
    TexelPlane plane{ at[0], a, {}, {} };
    if (std::abs(determinant) > leastTexels)
    {
      const Vec3 u = Times(Minus(this->P.positions[corners[1]], a), 1 / determinant);
      const Vec3 v = Times(Minus(this->P.positions[corners[2]], a), 1 / determinant);
      plane.right = Minus(Times(u, vy), Times(v, uy));
      plane.down = Minus(Times(v, ux), Times(u, vx));
    }
    return plane;
  }

  double SquaredToPlace(std::size_t place, const Vec3& point) const
  {
    const Box& box = this->Finer.places[place].box;
    double squared = 0;
    for (std::size_t k = 0; k < 3; ++k)
    {
      const double outside = std::max({ box.lo[k] - point[k], point[k] - box.hi[k], 0.0 });
      squared += outside * outside;
    }
    return squared;
  }

  // The finer piece with the nearest box; `last` if no box is nearer than its box.
  std::size_t NearestPlace(const Vec3& point, std::size_t last) const
  {
    std::size_t nearest = last;
    double least = this->SquaredToPlace(last, point);
    for (std::size_t i = 0; i < this->Finer.places.size() && least > 0; ++i)
    {
      const double squared = this->SquaredToPlace(i, point);
      if (squared < least)
      {
        least = squared;
        nearest = i;
      }
    }
    return nearest;
  }

  Status Sample()
  {
    constexpr double mostRatio = 1.5; // size of a texel relative to the sampled texels
    double ratio = this->Finest > 0 ? this->Spacing / this->Finest : 1;
    for (this->Halvings = 0; ratio > mostRatio && this->Halvings < mostPictureHalvings; ratio /= 2)
    {
      ++this->Halvings;
    }
    const std::size_t size = this->Owners.size();
    this->Texels.assign(4 * size, 255);
    this->HasColor.assign(size, false);
    this->HasAlpha = false;
    this->Squared.assign(size, std::numeric_limits<float>::infinity());
    this->From.assign(size, 0);
    std::vector<std::vector<std::uint32_t>> texelsOf(this->Finer.places.size());
    std::size_t place = 0;
    for (std::uint32_t texel = 0; texel < size && !texelsOf.empty(); ++texel)
    {
      if (this->Owners[texel] != noOwner)
      {
        KDSTREAM_TRY(this->AskToGoOn());
        place = this->NearestPlace(this->PointOf(texel), place);
        this->From[texel] = static_cast<std::uint32_t>(place);
        texelsOf[place].push_back(texel);
      }
    }
    KDSTREAM_TRY(this->SampleFromAll(texelsOf));
    KDSTREAM_TRY(this->FindFarTexels(texelsOf));
    KDSTREAM_TRY(this->SampleFromAll(texelsOf));
    for (std::size_t texel = 0; texel < size && !this->HasAlpha; ++texel)
    {
      this->HasAlpha = this->Texels[4 * texel + 3] != 255;
    }
    this->Squared = {};
    this->From = {};
    return {};
  }

  Status SampleFromAll(const std::vector<std::vector<std::uint32_t>>& texelsOf)
  {
    for (std::size_t i = 0; i < texelsOf.size(); ++i)
    {
      if (!texelsOf[i].empty())
      {
        KDSTREAM_TRY(this->SampleFrom(i, texelsOf[i]));
      }
    }
    return {};
  }

  // The box of a piece's own vertices can be nearest although another piece's surface is: its
  // triangles are as large as a flat wall lets them be. So the texels that are far from what was
  // found are looked up in the other pieces too whose surface may be nearer: a triangle over a
  // place has its corners at most about as far away as those of the coarser piece are from each
  // other.
  Status FindFarTexels(std::vector<std::vector<std::uint32_t>>& texelsOf)
  {
    for (std::vector<std::uint32_t>& texels : texelsOf)
    {
      texels.clear();
    }
    const double far = mostTexelsOff * this->Spacing;
    const double longest = this->LongestEdge();
    for (std::uint32_t texel = 0; texel < this->Owners.size() && texelsOf.size() > 1; ++texel)
    {
      const double squared = double(this->Squared[texel]);
      if (this->Owners[texel] == noOwner || squared <= far * far)
      {
        continue;
      }
      KDSTREAM_TRY(this->AskToGoOn());
      const Vec3 point = this->PointOf(texel);
      const double reach = std::sqrt(squared) + longest;
      for (std::size_t i = 0; i < texelsOf.size(); ++i)
      {
        if (i != this->From[texel] && this->SquaredToPlace(i, point) <= reach * reach)
        {
          texelsOf[i].push_back(texel);
        }
      }
    }
    return {};
  }

  double LongestEdge() const
  {
    double squared = 0;
    for (const Triangle& t : this->P.triangles)
    {
      for (std::size_t k = 0; k < 3; ++k)
      {
        squared = std::max(
          squared, SquaredDistance(this->P.positions[t[k]], this->P.positions[t[(k + 1) % 3]]));
      }
    }
    return std::sqrt(squared);
  }

  // The centre of a texel that has an owner.
  Vec3 PointOf(std::uint32_t texel) const
  {
    const TexelPlane& plane = this->Planes[this->Owners[texel]];
    const double x = double(texel % this->Packed.width) + 0.5 - plane.from[0];
    const double y = double(texel / this->Packed.width) + 0.5 - plane.from[1];
    return Plus(plane.corner, Plus(Times(plane.right, x), Times(plane.down, y)));
  }

  // Called for each texel: asks after every texelsBetween of them.
  Status AskToGoOn()
  {
    if (++this->SinceAsked < FinerTiles::texelsBetween || !this->Finer.goesOn)
    {
      return {};
    }
    this->SinceAsked = 0;
    return this->Finer.goesOn() ? Status{} : Status(Error{ ErrorCode::Cancelled, "cancelled" });
  }

  Status SampleFrom(std::size_t place, const std::vector<std::uint32_t>& texels)
  {
    const auto finer = this->Finer.read(place);
    KDSTREAM_TRY(finer);
    const FinerColors& colors = **finer;
    if (colors.Of().piece.triangles.empty())
    {
      return {};
    }
    const auto shown = colors.HalvedBy(this->Halvings, this->Options.oneLarge);
    KDSTREAM_TRY(shown);
    // Where searches begin: at the triangle found for the texel to the left, or above.
    std::vector<std::uint32_t> nearAbove(
      static_cast<std::size_t>(this->Packed.width), FinerColors::noNear);
    std::uint32_t near = FinerColors::noNear;
    for (std::size_t i = 0; i < texels.size(); ++i)
    {
      std::uint32_t& above = nearAbove[texels[i] % this->Packed.width];
      const bool follows = i > 0 && texels[i - 1] + 1 == texels[i] &&
                           this->ChartOf(texels[i - 1]) == this->ChartOf(texels[i]);
      near = follows ? near : above;
      KDSTREAM_TRY(this->AskToGoOn());
      this->SampleTexel(texels[i], colors, *shown, near);
      above = near;
    }
    return {};
  }

  std::uint32_t ChartOf(std::uint32_t texel) const { return this->Charted[this->Owners[texel]]; }

  void SampleTexel(std::uint32_t texel, const FinerColors& colors, const FinerColors::Shown& shown,
    std::uint32_t& near)
  {
    double squared = 0;
    const Color color =
      colors.At(shown, this->PointOf(texel), this->Normals[this->Owners[texel]], near, squared);
    if (!(float(squared) < this->Squared[texel]))
    {
      return;
    }
    this->Squared[texel] = float(squared);
    for (std::size_t k = 0; k < 3; ++k)
    {
      this->Texels[4 * std::size_t{ texel } + k] = QuickByteOfLinear(color[k]);
    }
    const auto alpha = static_cast<std::uint8_t>(std::min(color[3] + 0.5, 255.0));
    this->Texels[4 * std::size_t{ texel } + 3] = alpha;
    this->HasColor[texel] = true;
  }

  Status Encode()
  {
    this->Tile.width = static_cast<std::uint32_t>(this->Packed.width);
    this->Tile.height = static_cast<std::uint32_t>(this->Packed.height);
    this->Tile.format = TileImage::Webp;
    this->Tile.isPlanar = true;
    this->Tile.planar.chartOf = this->Charted;
    Result<std::vector<std::uint8_t>> image =
      EncodeWebp({ this->Tile.width, this->Tile.height, 4, std::move(this->Texels) },
        this->Options.quality, this->HasAlpha, 4);
    KDSTREAM_TRY(image);
    this->Tile.image = std::move(*image);
    return {};
  }

  const Piece& P;
  const FinerTiles& Finer;
  const LevelTileOptions& Options;
  // The distance of texels, and of texels of the finer tiles (0: none), in model units.
  double Spacing = 1, Finest = 0;
  unsigned Halvings = 0;     // of the finer pictures
  std::vector<Vec3> Normals; // of the triangles, of length 1; 0 without area
  std::vector<LevelChart> Charts;
  PackedBoxes Packed;
  std::vector<std::uint32_t> Owners;  // for each texel, a triangle
  std::vector<std::uint32_t> Charted; // for each triangle, its chart
  std::vector<TexelPlane> Planes;     // for each triangle
  std::vector<std::uint8_t> Texels;   // RGBA
  std::vector<float> Squared;         // for each texel, FinerColors::At's of its colour
  std::vector<std::uint32_t> From;    // for each texel, the finer piece that was searched first
  std::vector<bool> HasColor;
  bool HasAlpha = false;
  std::size_t SinceAsked = 0; // texels since Finer.goesOn was called
  TextureTile Tile;
  TileCounts Counts;
};

}

Result<MadeTile> MakeLevelTile(
  const Piece& piece, const FinerTiles& finer, const LevelTileOptions& options)
{
  return LevelTileMaker(piece, finer, options).Make();
}

}
