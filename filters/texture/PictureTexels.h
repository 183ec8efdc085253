// SPDX-License-Identifier: BSD-3-Clause
// Looks up the texels of a picture at texture coordinates. Part of step "read" of the pipeline
// picture.
#pragma once

#include "filters/texture/Picture.h"
#include "filters/texture/TexturedMesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>

namespace kdstream
{

using PlaceInPicture = std::array<double, 2>; // from the left and from above; 0-1 is the picture
using Texel = std::array<std::uint8_t, 4>;    // RGBA, sRGB

// How texels are stored: row by row, or in squares (TextureFolder.h).
struct TexelLayout
{
  static constexpr std::size_t squareSide = 64;
  static constexpr std::size_t squareBytes = 4 * squareSide * squareSide;

  std::size_t width = 0, height = 0, components = 0;
  const std::uint8_t* texels = nullptr;
  bool squares = false; // in squares of RGBA

  const std::uint8_t* At(std::size_t column, std::size_t row) const
  {
    if (!this->squares)
    {
      return this->texels + (row * this->width + column) * this->components;
    }
    const std::size_t across = (this->width + squareSide - 1) / squareSide;
    const std::size_t square = row / squareSide * across + column / squareSide;
    return this->texels + square * squareBytes +
           4 * (row % squareSide * squareSide + column % squareSide);
  }
};

// Looks up the nearest texel, without interpolation. The picture must outlive it.
class PictureTexels
{
public:
  explicit PictureTexels(const Picture& picture)
    : PictureTexels(
        TexelLayout{ picture.width, picture.height, picture.components, picture.texels.data() })
  {
  }
  explicit PictureTexels(const TexelLayout& layout)
    : Source(layout)
    , Linear(LinearOfBytes())
  {
  }

  double Count() const { return double(this->Source.width) * double(this->Source.height); }

  Texel At(const PlaceInPicture& place, TextureWrap wrapU, TextureWrap wrapV) const
  {
    const TexelLayout& p = this->Source;
    return this->InCell(Cell(place[0], p.width, wrapU), Cell(place[1], p.height, wrapV));
  }

  // The corners of a triangle as columns and rows of texels. They count from the upper left corner
  // of that copy of the picture in which the triangle lies. Nothing if the triangle does not lie
  // within a single copy of the unmirrored picture.
  std::optional<std::array<PlaceInPicture, 3>> CellsOf(
    const std::array<PlaceInPicture, 3>& at, TextureWrap wrapU, TextureWrap wrapV) const
  {
    const std::array<TextureWrap, 2> wraps{ wrapU, wrapV };
    const std::array<double, 2> sizes{ double(this->Source.width), double(this->Source.height) };
    std::array<PlaceInPicture, 3> cells = at;
    for (std::size_t k = 0; k < 2; ++k)
    {
      const double copy = wraps[k] == TextureWrap::Repeat ? std::floor(at[0][k]) : 0;
      for (PlaceInPicture& cell : cells)
      {
        cell[k] = (cell[k] - copy) * sizes[k];
        if (!(cell[k] >= 0 && cell[k] <= sizes[k]))
        {
          return {};
        }
      }
    }
    return cells;
  }
  // The texel at a place that CellsOf returned, or between such places.
  Texel AtCell(double column, double row) const
  {
    const auto inside = [](double at, std::size_t size)
    { return std::min(static_cast<std::size_t>(std::max(at, 0.0)), size - 1); };
    return this->InCell(inside(column, this->Source.width), inside(row, this->Source.height));
  }

  bool InSquares() const { return this->Source.squares; }
  // The same, but faster. REQUIRES: InSquares().
  Texel AtSquareCell(double column, double row) const
  {
    const auto inside = [](double at, std::size_t size)
    {
      return std::min(static_cast<std::uint32_t>(std::max(static_cast<std::int32_t>(at), 0)),
        static_cast<std::uint32_t>(size - 1));
    };
    const std::uint32_t x = inside(column, this->Source.width);
    const std::uint32_t y = inside(row, this->Source.height);
    Texel texel;
    std::memcpy(texel.data(), this->Source.At(x, y), texel.size());
    return texel;
  }

  // The texel's colour in linear light.
  Color LightOf(const Texel& texel) const
  {
    return { this->Linear[texel[0]], this->Linear[texel[1]], this->Linear[texel[2]],
      texel[3] == 255 ? 1 : texel[3] / 255.0 };
  }

  // The longest side, in texels, of a triangle between these places.
  double LongestSide(const std::array<PlaceInPicture, 3>& at) const
  {
    double longest = 0;
    for (std::size_t k = 0; k < 3; ++k)
    {
      const double x = (at[k][0] - at[(k + 1) % 3][0]) * double(this->Source.width);
      const double y = (at[k][1] - at[(k + 1) % 3][1]) * double(this->Source.height);
      longest = std::max(longest, x * x + y * y);
    }
    return std::sqrt(longest);
  }
  // The largest distance of these coordinates from 0, in texels.
  double Farthest(const std::array<PlaceInPicture, 3>& at) const
  {
    double farthest = 0;
    for (const PlaceInPicture& place : at)
    {
      farthest = std::max({ farthest, std::abs(place[0]) * double(this->Source.width),
        std::abs(place[1]) * double(this->Source.height) });
    }
    return farthest;
  }
  // How many texels the triangle covers; each counts at most once.
  double Covered(const std::array<PlaceInPicture, 3>& at) const
  {
    const double cross =
      (at[1][0] - at[0][0]) * (at[2][1] - at[0][1]) - (at[1][1] - at[0][1]) * (at[2][0] - at[0][0]);
    const double covered = std::abs(cross) / 2 * this->Count();
    return std::isnan(covered) ? 0 : std::min(covered, this->Count());
  }

private:
  // REQUIRES: column and row lie within the picture.
  Texel InCell(std::size_t column, std::size_t row) const
  {
    const TexelLayout& p = this->Source;
    const std::uint8_t* const texel = p.At(column, row);
    const bool grey = p.components < 3;
    const std::uint8_t alpha = p.components % 2 == 0 ? texel[p.components - 1] : 255;
    return { texel[0], texel[grey ? 0 : 1], texel[grey ? 0 : 2], alpha };
  }

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
    // NaN, from a transform of huge numbers, gives the first texel.
    return inside > 0 ? static_cast<std::size_t>(std::min(inside * double(size), double(size - 1)))
                      : 0;
  }

  const TexelLayout Source;
  const std::array<double, 256>& Linear;
};

}
