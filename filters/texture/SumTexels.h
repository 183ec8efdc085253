// SPDX-License-Identifier: BSD-3-Clause
// Sums the texels of a triangle for its corners. Part of step "read" of the pipeline picture.
#pragma once

#include "filters/core/Light.h"
#include "filters/texture/PictureTexels.h"
#include "filters/texture/TexturedMesh.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace kdstream
{

// The sums of texels for a place.
struct PlaceSum
{
  Color light{}; // colour × weight
  double weight = 0;
  std::array<double, 3> shown{}; // sRGB, 0-255, × weight: for the loss

  void Add(double partWeight, const Color& partLight, const std::array<double, 3>& partShown)
  {
    for (std::size_t k = 0; k < 4; ++k)
    {
      this->light[k] += partWeight * partLight[k];
    }
    for (std::size_t k = 0; k < 3; ++k)
    {
      this->shown[k] += partWeight * partShown[k];
    }
    this->weight += partWeight;
  }
  void Add(const PlaceSum& other)
  {
    for (std::size_t k = 0; k < 4; ++k)
    {
      this->light[k] += other.light[k];
    }
    for (std::size_t k = 0; k < 3; ++k)
    {
      this->shown[k] += other.shown[k];
    }
    this->weight += other.weight;
  }
};

// The same sums for the texels of a triangle, for each of its corners.
struct TriangleSum
{
  std::array<PlaceSum, 3> corners{};
  double squares = 0; // squared sRGB values × area
  std::uint16_t cuts = 0;
};

inline double SquareOf(const std::array<double, 3>& shown)
{
  return shown[0] * shown[0] + shown[1] * shown[1] + shown[2] * shown[2];
}

// Cuts each side into `cuts` parts. This gives rows of small triangles, alternately upright and
// upside down, which are sampled at their centres and multiplied by the material's factor. at: the
// corners' places in the picture. area: of the triangle. REQUIRES: 0 < cuts < 65536. O(cuts^2).
TriangleSum SumTexels(const TexturedMaterial& material, const PictureTexels& texels,
  const std::array<PlaceInPicture, 3>& at, double area, std::size_t cuts);

}
