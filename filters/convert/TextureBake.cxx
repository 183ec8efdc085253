// SPDX-License-Identifier: BSD-3-Clause
// A texture as colours of vertices: see TextureBake.h.
//   1. How finely each triangle is looked at, from its size in texels and what there is to spend.
//   2. The sums of the texels at its parts, for its three corners.
//   3. The means; once more through all parts for what is lost.
#include "filters/convert/TextureBake.h"

#include "filters/core/VectorMath.h"

#include <algorithm>
#include <cmath>

namespace kdstream
{
namespace
{

constexpr std::size_t fewestCuts = 3;  // of a side
constexpr double partsOfTexel = 8;     // of the picture, for all triangles together
constexpr double partsOfTriangle = 64; // on top of that
constexpr double mostCuts = 1 << 15;   // of a side; before the limit for all

bool IsNumber(const PlaceOnTexture& c)
{
  return std::isfinite(c[0]) && std::isfinite(c[1]);
}

// The texels of a picture in linear light.
class Texels
{
public:
  explicit Texels(const TexturePicture& picture)
    : Picture(picture)
  {
    for (std::size_t value = 0; value < this->Linear.size(); ++value)
    {
      this->Linear[value] = ToLinear(double(value) / 255);
    }
  }

  // The one that is nearest.
  Color At(const PlaceOnTexture& c) const
  {
    const TexturePicture& p = this->Picture;
    const std::size_t column = Cell(c[0], p.width, p.wrapU);
    const std::size_t row = p.height - 1 - Cell(c[1], p.height, p.wrapV);
    const std::uint8_t* const texel = &p.texels[(row * p.width + column) * p.components];
    const bool grey = p.components < 3;
    const std::uint8_t alpha = p.components % 2 == 0 ? texel[p.components - 1] : 255;
    return { this->Linear[texel[0]], this->Linear[texel[grey ? 0 : 1]],
      this->Linear[texel[grey ? 0 : 2]], alpha / 255.0 };
  }

private:
  static std::size_t Cell(double t, std::size_t size, TextureWrap wrap)
  {
    double inside = t;
    if (wrap == TextureWrap::Repeat)
    {
      inside = t - std::floor(t);
    }
    else if (wrap == TextureWrap::Mirror)
    {
      const double twice = t / 2 - std::floor(t / 2);
      inside = 1 - std::abs(1 - 2 * twice);
    }
    return static_cast<std::size_t>(std::clamp(inside * double(size), 0.0, double(size - 1)));
  }

  const TexturePicture& Picture;
  std::array<double, 256> Linear{};
};

class Baker
{
public:
  Baker(const TexturePicture& picture, std::span<const PlaceOnTexture> coordinates,
    std::span<const Vec3> points, std::span<const Triangle> triangles)
    : Picture(picture)
    , Source(picture)
    , Coordinates(coordinates)
    , Points(points)
    , Triangles(triangles)
  {
  }

  BakedTexture Bake()
  {
    this->FindThinning();
    std::vector<Color> sums(this->Points.size(), Color{});
    std::vector<double> weights(this->Points.size(), 0);
    this->ForEachPart(
      [&](const Triangle& t, const Vec3& shares, double area, const Color& texel)
      {
        for (std::size_t corner = 0; corner < 3; ++corner)
        {
          const double weight = shares[corner] * area;
          for (std::size_t k = 0; k < 4; ++k)
          {
            sums[t[corner]][k] += weight * texel[k];
          }
          weights[t[corner]] += weight;
        }
      });
    for (std::size_t v = 0; v < sums.size(); ++v)
    {
      this->Baked.colors.push_back(weights[v] > 0 && std::isfinite(weights[v])
                                     ? Color{ sums[v][0] / weights[v], sums[v][1] / weights[v],
                                         sums[v][2] / weights[v], sums[v][3] / weights[v] }
                                   : IsNumber(this->Coordinates[v])
                                     ? this->Source.At(this->Coordinates[v])
                                     : Color{ 1, 1, 1, 1 });
    }
    this->MeasureLoss();
    return std::move(this->Baked);
  }

private:
  // Where a coordinate is in the picture, in texels.
  Vec3 PlaceOf(VertexId v) const
  {
    const PlaceOnTexture& c = this->Coordinates[v];
    return { c[0] * double(this->Picture.width), c[1] * double(this->Picture.height), 0 };
  }

  bool HasNumbers(const Triangle& t) const
  {
    return std::all_of(
      t.begin(), t.end(), [&](VertexId v) { return IsNumber(this->Coordinates[v]); });
  }

  // Into how many parts a side is cut, if nothing were too many.
  double CutsOf(const Triangle& t) const
  {
    const Vec3 a = this->PlaceOf(t[0]), b = this->PlaceOf(t[1]), c = this->PlaceOf(t[2]);
    const double longest =
      std::max({ SquaredDistance(a, b), SquaredDistance(b, c), SquaredDistance(c, a) });
    return std::clamp(std::ceil(std::sqrt(longest)), double(fewestCuts), mostCuts);
  }

  // Adds up the texels, and finds by how much too many parts all would have.
  void FindThinning()
  {
    double parts = 0;
    for (const Triangle& t : this->Triangles)
    {
      if (this->HasNumbers(t))
      {
        const double cuts = this->CutsOf(t);
        parts += cuts * cuts;
        const Vec3 a = this->PlaceOf(t[0]);
        const double covered =
          Length(Cross(Minus(this->PlaceOf(t[1]), a), Minus(this->PlaceOf(t[2]), a))) / 2;
        this->Baked.texels += std::isfinite(covered) ? covered : 0;
      }
    }
    const double most = partsOfTexel * double(this->Picture.width * this->Picture.height) +
                        partsOfTriangle * double(this->Triangles.size());
    this->Thinning = parts > most ? std::sqrt(most / parts) : 1;
  }

  // Calls visit(triangle, how near the part is to each corner, its area, its texel).
  template <class Visit>
  void ForEachPart(const Visit& visit) const
  {
    for (const Triangle& t : this->Triangles)
    {
      const Vec3 normal = Cross(Minus(this->Points[t[1]], this->Points[t[0]]),
        Minus(this->Points[t[2]], this->Points[t[0]]));
      const double area = Length(normal) / 2;
      if (!this->HasNumbers(t) || !(area > 0) || !std::isfinite(area))
      {
        continue;
      }
      const auto cuts = std::max(
        fewestCuts, static_cast<std::size_t>(std::floor(this->CutsOf(t) * this->Thinning)));
      const double ofPart = area / double(cuts * cuts);
      // Rows of small triangles, upright and upside down by turns: their middles.
      for (std::size_t row = 0; row < cuts; ++row)
      {
        for (std::size_t i = 0; i < 2 * (cuts - row) - 1; ++i)
        {
          const double third = i % 2 == 0 ? 1.0 / 3 : 2.0 / 3;
          const double second = (double(i / 2) + third) / double(cuts);
          const double last = (double(row) + third) / double(cuts);
          this->VisitPart(t, { 1 - second - last, second, last }, ofPart, visit);
        }
      }
    }
  }

  template <class Visit>
  void VisitPart(const Triangle& t, const Vec3& shares, double area, const Visit& visit) const
  {
    const PlaceOnTexture &a = this->Coordinates[t[0]], &b = this->Coordinates[t[1]],
                            &c = this->Coordinates[t[2]];
    const PlaceOnTexture at{ shares[0] * a[0] + shares[1] * b[0] + shares[2] * c[0],
      shares[0] * a[1] + shares[1] * b[1] + shares[2] * c[1] };
    if (IsNumber(at)) // the sum of huge numbers may be none
    {
      visit(t, shares, area, this->Source.At(at));
    }
  }

  // Colours between vertices are as viewers draw them: of the bytes, not in linear light.
  void MeasureLoss()
  {
    std::vector<Color> shown = this->Baked.colors;
    for (Color& color : shown)
    {
      std::transform(color.begin(), color.begin() + 3, color.begin(), FromLinear);
    }
    double sum = 0, all = 0;
    this->ForEachPart(
      [&](const Triangle& t, const Vec3& shares, double area, const Color& texel)
      {
        for (std::size_t k = 0; k < 3; ++k)
        {
          const double between =
            shares[0] * shown[t[0]][k] + shares[1] * shown[t[1]][k] + shares[2] * shown[t[2]][k];
          sum += area * std::abs(FromLinear(texel[k]) - between) * 255 / 3;
        }
        all += area;
      });
    this->Baked.loss = all > 0 && std::isfinite(sum / all) ? sum / all : 0;
  }

  const TexturePicture& Picture;
  const Texels Source;
  std::span<const PlaceOnTexture> Coordinates;
  std::span<const Vec3> Points;
  std::span<const Triangle> Triangles;
  double Thinning = 1;
  BakedTexture Baked;
};

}

BakedTexture BakeTexture(const TexturePicture& picture,
  std::span<const PlaceOnTexture> coordinates, std::span<const Vec3> points,
  std::span<const Triangle> triangles)
{
  return Baker(picture, coordinates, points, triangles).Bake();
}

}
