// SPDX-License-Identifier: BSD-3-Clause
// Pictures without light: see FlatPictures.h.
#include "Testing/Benchmarks/FlatPictures.h"

#include "filters/core/VectorMath.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>

namespace kdstream::bench
{
namespace
{

constexpr std::size_t finer = 2; // samples along a pixel's side
constexpr float behind = 128;    // grey

// The samples, among `count` of them, whose centres are between two coordinates: [first, second).
std::pair<std::size_t, std::size_t> SamplesBetween(double low, double high, std::size_t count)
{
  const double most = double(count);
  return { static_cast<std::size_t>(std::clamp(std::ceil(low - 0.5), 0.0, most)),
    static_cast<std::size_t>(std::clamp(std::floor(high - 0.5) + 1, 0.0, most)) };
}

// The samples of a picture; each shows the nearest surface.
class Canvas
{
public:
  explicit Canvas(std::size_t side)
    : Side(side)
    , Depths(side * side, -std::numeric_limits<double>::infinity())
    , Colors(side * side, { behind, behind, behind })
  {
  }

  // at: the corners as x and y, in samples, and nearness.
  void Draw(const std::array<Vec3, 3>& at, const std::array<const std::uint8_t*, 3>& colors)
  {
    const auto& [a, b, c] = at;
    const double area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    const auto [left, right] =
      SamplesBetween(std::min({ a[0], b[0], c[0] }), std::max({ a[0], b[0], c[0] }), this->Side);
    const auto [low, high] =
      SamplesBetween(std::min({ a[1], b[1], c[1] }), std::max({ a[1], b[1], c[1] }), this->Side);
    for (std::size_t row = low; row < high && area != 0; ++row)
    {
      for (std::size_t column = left; column < right; ++column)
      {
        const double x = double(column) + 0.5, y = double(row) + 0.5;
        const double ofA = ((b[0] - x) * (c[1] - y) - (b[1] - y) * (c[0] - x)) / area;
        const double ofB = ((c[0] - x) * (a[1] - y) - (c[1] - y) * (a[0] - x)) / area;
        const double ofC = 1 - ofA - ofB, near = ofA * a[2] + ofB * b[2] + ofC * c[2];
        const std::size_t sample = row * this->Side + column;
        if (ofA >= 0 && ofB >= 0 && ofC >= 0 && near > this->Depths[sample])
        {
          this->Depths[sample] = near;
          for (std::size_t k = 0; k < 3; ++k)
          {
            this->Colors[sample][k] =
              static_cast<float>(ofA * colors[0][k] + ofB * colors[1][k] + ofC * colors[2][k]);
          }
        }
      }
    }
  }

  FlatPicture Shrunk() const
  {
    const std::size_t side = this->Side / finer;
    FlatPicture picture{ std::vector<std::array<float, 3>>(side * side),
      std::vector<bool>(side * side, false) };
    for (std::size_t sample = 0; sample < this->Colors.size(); ++sample)
    {
      const std::size_t pixel = sample / this->Side / finer * side + sample % this->Side / finer;
      for (std::size_t k = 0; k < 3; ++k)
      {
        picture.colors[pixel][k] += this->Colors[sample][k] / (finer * finer);
      }
      picture.covered[pixel] = picture.covered[pixel] || std::isfinite(this->Depths[sample]);
    }
    return picture;
  }

private:
  std::size_t Side;
  std::vector<double> Depths;
  std::vector<std::array<float, 3>> Colors;
};

double MeanDifference(const FlatPicture& a, const FlatPicture& b)
{
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < a.colors.size(); ++i)
  {
    for (std::size_t k = 0; k < 3 && (a.covered[i] || b.covered[i]); ++k)
    {
      sum += std::abs(double(a.colors[i][k]) - double(b.colors[i][k]));
      ++count;
    }
  }
  return count > 0 ? sum / count : 0;
}

}

FlatPainter::FlatPainter(const Box& box, std::size_t side)
  : Centre(Times(Plus(box.lo, box.hi), 0.5))
  , Radius(Length(Minus(box.hi, box.lo)) / 2)
  , Side(side)
{
}

std::vector<FlatPicture> FlatPainter::DrawAll(
  std::span<const Vec3> points, std::span<const Triangle> triangles, const Attribute& colors) const
{
  std::vector<FlatPicture> pictures;
  for (std::size_t camera = 0; camera < cameras; ++camera)
  {
    pictures.push_back(this->Draw(this->Project(camera, points), triangles, colors));
  }
  return pictures;
}

// Projects each point to x and y in samples, and its nearness.
std::vector<Vec3> FlatPainter::Project(std::size_t camera, std::span<const Vec3> points) const
{
  constexpr std::size_t around = 8;
  constexpr double step = 0.6; // radians, between two heights
  const double turn = double(camera % around) * std::acos(0.0) * 4 / around + 0.1;
  const double over = (double(camera / around) - 1) * step;
  const Vec3 back{ std::sin(turn) * std::cos(over), std::sin(over),
    std::cos(turn) * std::cos(over) };
  const Vec3 right{ std::cos(turn), 0, -std::sin(turn) };
  const Vec3 up = Cross(back, right);
  const double half = double(this->Side * finer) / 2, scale = half / this->Radius;
  std::vector<Vec3> seen(points.size());
  std::transform(points.begin(), points.end(), seen.begin(),
    [&](const Vec3& point) -> Vec3
    {
      const Vec3 p = Minus(point, this->Centre);
      return { Dot(p, right) * scale + half, Dot(p, up) * scale + half, Dot(p, back) };
    });
  return seen;
}

FlatPicture FlatPainter::Draw(
  std::span<const Vec3> seen, std::span<const Triangle> triangles, const Attribute& colors) const
{
  Canvas canvas(this->Side * finer);
  const auto colorOf = [&](VertexId v) { return &colors.values[v * colors.components]; };
  for (const Triangle& t : triangles)
  {
    canvas.Draw(
      { seen[t[0]], seen[t[1]], seen[t[2]] }, { colorOf(t[0]), colorOf(t[1]), colorOf(t[2]) });
  }
  return canvas.Shrunk();
}

Status FlatPainter::WritePpm(const FlatPicture& picture, const std::string& file) const
{
  std::ofstream out(file, std::ios::binary);
  out << "P6\n" << this->Side << " " << this->Side << "\n255\n";
  for (std::size_t row = this->Side; row-- > 0;)
  {
    for (std::size_t pixel = row * this->Side; pixel < (row + 1) * this->Side; ++pixel)
    {
      for (const float channel : picture.colors[pixel])
      {
        out.put(static_cast<char>(std::lround(channel)));
      }
    }
  }
  return out.flush() ? Status{} : Error{ ErrorCode::InputOutput, file + " cannot be written" };
}

double MeanDifference(std::span<const FlatPicture> a, std::span<const FlatPicture> b)
{
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
  {
    sum += MeanDifference(a[i], b[i]);
  }
  return sum / double(a.size());
}

}
