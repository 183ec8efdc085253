// SPDX-License-Identifier: BSD-3-Clause
// Sums the texels of a triangle for its corners: see SumTexels.h.
#include "filters/texture/SumTexels.h"

#include <algorithm>

namespace kdstream
{
namespace
{

typedef float Four __attribute__((vector_size(16))); // a vector type of GCC and Clang

// The values of a texel that are summed. `shown` has whole numbers, and so have their squares.
struct TexelValues
{
  Four light; // linear light, and alpha
  Four shown; // sRGB, 0-255, and the sum of their squares
};

// Sums over parts that are all upright, or all upside down. They are floats; because the parts are
// few, sums of whole numbers stay exact, except the products with rows and columns.
struct FewSums
{
  static constexpr std::size_t most = 64;   // parts; squares of white texels: 0.7 × 2^24
  TexelValues whole{}, byColumn{}, byRow{}; // values; values times column; values times row
  std::size_t parts = 0;
};

// Sums over the parts of a triangle, which all have the same size.
struct PartSums
{
  using Values = std::array<double, 8>; // light, sRGB values, their square
  // The sum of the values, and sums of the values times the weights of the second and the last
  // corner.
  Values whole{}, second{}, last{};

  // The weight of the second corner in a part is (its column + third) / cuts; that of the last
  // corner is the same with its row.
  void Add(const FewSums& few, double third, double cuts)
  {
    for (std::size_t k = 0; k < 8; ++k)
    {
      const auto of = [k](const TexelValues& v) -> double
      { return k < 4 ? v.light[k] : v.shown[k - 4]; };
      const double sum = of(few.whole);
      this->whole[k] += sum;
      this->second[k] += (of(few.byColumn) + third * sum) / cuts;
      this->last[k] += (of(few.byRow) + third * sum) / cuts;
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
        place.weight = area / 3; // the sum of its shares in all parts
      }
    }
    return sum;
  }
};

// Sums the parts of a row from column `first` to `end`. Their centres begin at `at`, `step` apart.
template <class ValueOf>
void SumRow(FewSums& few, std::size_t row, std::size_t first, std::size_t end,
  const PlaceInPicture& at, const PlaceInPicture& step, const ValueOf& valueOf)
{
  TexelValues whole{}, byColumn{};
  for (std::size_t i = first; i < end; ++i)
  {
    const auto column = static_cast<float>(i - first);
    const TexelValues values = valueOf(at[0] + double(i) * step[0], at[1] + double(i) * step[1]);
    whole.light += values.light;
    whole.shown += values.shown;
    byColumn.light += column * values.light;
    byColumn.shown += column * values.shown;
  }
  few.whole.light += whole.light;
  few.whole.shown += whole.shown;
  few.byColumn.light += byColumn.light + static_cast<float>(first) * whole.light;
  few.byColumn.shown += byColumn.shown + static_cast<float>(first) * whole.shown;
  few.byRow.light += static_cast<float>(row) * whole.light;
  few.byRow.shown += static_cast<float>(row) * whole.shown;
  few.parts += end - first;
}

// Sums over the upright parts, or over the inverted ones; each row has one inverted part fewer.
template <class ValueOf>
void SumAlike(PartSums& sums, const std::array<PlaceInPicture, 3>& at, std::size_t cuts,
  bool upright, const ValueOf& valueOf)
{
  const auto sides = double(cuts);
  const double third = upright ? 1.0 / 3 : 2.0 / 3;
  const PlaceInPicture step{ (at[1][0] - at[0][0]) / sides, (at[1][1] - at[0][1]) / sides };
  const PlaceInPicture down{ (at[2][0] - at[0][0]) / sides, (at[2][1] - at[0][1]) / sides };
  FewSums few;
  for (std::size_t row = 0; row < cuts; ++row)
  {
    const double rows = double(row) + third;
    const PlaceInPicture begin{ at[0][0] + rows * down[0] + third * step[0],
      at[0][1] + rows * down[1] + third * step[1] };
    const std::size_t count = cuts - row - (upright ? 0 : 1);
    for (std::size_t first = 0; first < count; first += FewSums::most)
    {
      const std::size_t end = std::min(count, first + FewSums::most);
      if (few.parts + end - first > FewSums::most)
      {
        sums.Add(few, third, sides);
        few = {};
      }
      SumRow(few, row, first, end, begin, step, valueOf);
    }
  }
  sums.Add(few, third, sides);
}

// valueOf(x, y): the values at a place in the triangle `at`.
template <class ValueOf>
PartSums SumParts(const std::array<PlaceInPicture, 3>& at, std::size_t cuts, const ValueOf& valueOf)
{
  PartSums sums;
  SumAlike(sums, at, cuts, true, valueOf);
  SumAlike(sums, at, cuts, false, valueOf);
  return sums;
}

TexelValues Plain(const std::array<float, 256>& lights, const Texel& texel, bool opaque)
{
  const std::array<int, 3> bytes{ texel[0], texel[1], texel[2] };
  const int square = bytes[0] * bytes[0] + bytes[1] * bytes[1] + bytes[2] * bytes[2];
  const float alpha = opaque || texel[3] == 255 ? 1 : float(texel[3]) / 255;
  return { Four{ lights[texel[0]], lights[texel[1]], lights[texel[2]], alpha },
    Four{ float(bytes[0]), float(bytes[1]), float(bytes[2]), float(square) } };
}

const std::array<float, 256>& LightOfBytes()
{
  static const std::array<float, 256> lights = []
  {
    std::array<float, 256> floats{};
    std::transform(LinearOfBytes().begin(), LinearOfBytes().end(), floats.begin(),
      [](double light) { return static_cast<float>(light); });
    return floats;
  }();
  return lights;
}

// The values of a texel, multiplied by the material's factor.
TexelValues Tinted(
  const TexturedMaterial& material, const PictureTexels& texels, const Texel& texel)
{
  Color light = texels.LightOf(texel);
  std::array<double, 3> shown{};
  for (std::size_t k = 0; k < 3; ++k)
  {
    light[k] *= material.factor[k];
    shown[k] = 255 * FromLinear(light[k]);
  }
  light[3] = material.opaque ? 1 : light[3] * material.factor[3];
  return { Four{ float(light[0]), float(light[1]), float(light[2]), float(light[3]) },
    Four{ float(shown[0]), float(shown[1]), float(shown[2]), float(SquareOf(shown)) } };
}

}

TriangleSum SumTexels(const TexturedMaterial& material, const PictureTexels& texels,
  const std::array<PlaceInPicture, 3>& at, double area, std::size_t cuts)
{
  const std::array<float, 256>& lights = LightOfBytes();
  const auto sum = [&](const std::array<PlaceInPicture, 3>& places, const auto& texelAt)
  {
    if (material.factor != Color{ 1, 1, 1, 1 })
    {
      return SumParts(
        places, cuts, [&](double x, double y) { return Tinted(material, texels, texelAt(x, y)); });
    }
    return SumParts(places, cuts,
      [&, opaque = material.opaque](double x, double y)
      { return Plain(lights, texelAt(x, y), opaque); });
  };
  const auto cells = texels.CellsOf(at, material.wrapU, material.wrapV);
  if (!cells)
  {
    return sum(at,
      [&](double u, double v) {
        return texels.At({ u, v }, material.wrapU, material.wrapV);
      })
      .OfTriangle(area, cuts);
  }
  const PartSums parts =
    texels.InSquares()
      ? sum(*cells, [&](double column, double row) { return texels.AtSquareCell(column, row); })
      : sum(*cells, [&](double column, double row) { return texels.AtCell(column, row); });
  return parts.OfTriangle(area, cuts);
}

}
