// SPDX-License-Identifier: BSD-3-Clause
// Pictures of textured surfaces without light, so that they differ only by colours and outline.
#pragma once

#include "filters/core/Attribute.h"
#include "filters/core/Types.h"

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace kdstream::bench
{

struct FlatPicture
{
  std::vector<std::array<float, 3>>
    colors;                  // of each pixel, 0-255, from the lower left; the background is grey
  std::vector<bool> covered; // whether a part of the surface is visible there
};

// Draws a surface from 24 cameras around a box: eight directions, each from below, horizontally and
// from above. The whole box is visible. Four samples for each pixel.
class FlatPainter
{
public:
  static constexpr std::size_t cameras = 24;

  // side: width and height of the pictures, in pixels.
  FlatPainter(const Box& box, std::size_t side);

  // colors: of the vertices, uint8, three components or more. They are interpolated linearly in
  // each triangle.
  std::vector<FlatPicture> DrawAll(std::span<const Vec3> points,
    std::span<const Triangle> triangles, const Attribute& colors) const;
  // Errors: InputOutput.
  Status WritePpm(const FlatPicture& picture, const std::string& file) const;

private:
  std::vector<Vec3> Project(std::size_t camera, std::span<const Vec3> points) const;
  FlatPicture Draw(
    std::span<const Vec3> seen, std::span<const Triangle> triangles, const Attribute& colors) const;

  Vec3 Centre;
  double Radius;
  std::size_t Side;
};

// The mean difference of the channels, in grey values, over the pixels that either surface covers,
// as the mean over all cameras.
double MeanDifference(std::span<const FlatPicture> a, std::span<const FlatPicture> b);

}
