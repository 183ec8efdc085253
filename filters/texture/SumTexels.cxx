// SPDX-License-Identifier: BSD-3-Clause
// What the texels of a triangle add up to for its corners: see SumTexels.h.
#include "filters/texture/SumTexels.h"

#include <algorithm>

namespace kdstream
{
namespace
{

// What the parts of a triangle add up to, all of them of one size.
struct PartSums
{
  using Values = std::array<double, 8>; // light, what is shown, its square
  Values whole{}, second{}, last{};     // as it is, and by the second and the last corner's shares

  void Add(const Values& values, double secondShare, double lastShare)
  {
    for (std::size_t k = 0; k < values.size(); ++k)
    {
      this->whole[k] += values[k];
      this->second[k] += secondShare * values[k];
      this->last[k] += lastShare * values[k];
    }
  }

  TriangleSum OfTriangle(double area, std::size_t cuts) const
  {
    const double part = area / double(cuts * cuts);
    TriangleSum sum;
    sum.squares = part * this->whole[7];
    sum.cuts = static_cast<std::uint16_t>(cuts);
    for (std::size_t k = 0; k < 7; ++k)
    {
      const std::array<double, 3> values{ this->whole[k] - this->second[k] - this->last[k],
        this->second[k], this->last[k] };
      for (std::size_t corner = 0; corner < 3; ++corner)
      {
        PlaceSum& place = sum.corners[corner];
        (k < 4 ? place.light[k] : place.shown[k - 4]) = part * values[corner];
        place.weight = area / 3; // its shares of all parts
      }
    }
    return sum;
  }
};

// valueOf(x, y): of places between `at`.
template <class ValueOf>
PartSums SumParts(const std::array<PlaceInPicture, 3>& at, std::size_t cuts, const ValueOf& valueOf)
{
  const PlaceInPicture toSecond{ at[1][0] - at[0][0], at[1][1] - at[0][1] };
  const PlaceInPicture toLast{ at[2][0] - at[0][0], at[2][1] - at[0][1] };
  const double part = 1 / double(cuts);
  PartSums sums;
  for (std::size_t row = 0; row < cuts; ++row)
  {
    for (std::size_t i = 0; i < 2 * (cuts - row) - 1; ++i)
    {
      const double third = i % 2 == 0 ? 1.0 / 3 : 2.0 / 3;
      const double second = (double(i / 2) + third) * part;
      const double last = (double(row) + third) * part;
      sums.Add(valueOf(at[0][0] + second * toSecond[0] + last * toLast[0],
                 at[0][1] + second * toSecond[1] + last * toLast[1]),
        second, last);
    }
  }
  return sums;
}

PartSums::Values Joined(const Color& light, const std::array<double, 3>& shown)
{
  return { light[0], light[1], light[2], light[3], shown[0], shown[1], shown[2], SquareOf(shown) };
}

// Under the material's factor.
PartSums::Values Tinted(const TexturedMaterial& material, Color light)
{
  std::array<double, 3> shown{};
  for (std::size_t k = 0; k < 4; ++k)
  {
    light[k] *= k < 3 || !material.opaque ? material.factor[k] : 1;
  }
  std::transform(light.begin(), light.begin() + 3, shown.begin(),
    [](double value) { return 255 * FromLinear(value); });
  return Joined(light, shown);
}

}

TriangleSum SumTexels(const TexturedMaterial& material, const PictureTexels& texels,
  const std::array<PlaceInPicture, 3>& at, double area, std::size_t cuts)
{
  const bool opaque = material.opaque;
  const auto lightOf = [&](const Texel& texel)
  {
    Color light = texels.LightOf(texel);
    light[3] = opaque ? 1 : light[3];
    return light;
  };
  const auto sum = [&](const std::array<PlaceInPicture, 3>& places, const auto& texelAt)
  {
    if (material.factor != Color{ 1, 1, 1, 1 })
    {
      return SumParts(
        places, cuts, [&](double x, double y) { return Tinted(material, lightOf(texelAt(x, y))); });
    }
    return SumParts(places, cuts,
      [&](double x, double y)
      {
        const Texel texel = texelAt(x, y);
        return Joined(lightOf(texel), PictureTexels::ShownOf(texel));
      });
  };
  const auto cells = texels.CellsOf(at, material.wrapU, material.wrapV);
  const PartSums parts =
    cells ? sum(*cells, [&](double column, double row) { return texels.AtCell(column, row); })
          : sum(at,
              [&](double u, double v) {
                return texels.At({ u, v }, material.wrapU, material.wrapV);
              });
  return parts.OfTriangle(area, cuts);
}

}
