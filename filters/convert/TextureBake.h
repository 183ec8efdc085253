// SPDX-License-Identifier: BSD-3-Clause
// A texture as colours of vertices. Part of step "read" of the README's picture. No VTK in it.
#pragma once

#include "filters/core/Types.h"
#include "filters/texture/TexturedMesh.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// Bytes, `components` a texel: grey, grey and alpha, RGB, RGBA; rows from the lowest up.
struct TexturePicture
{
  std::size_t width = 0, height = 0; // at least 1
  std::size_t components = 3;        // 1-4
  std::span<const std::uint8_t> texels;
  TextureWrap wrapU = TextureWrap::Repeat, wrapV = TextureWrap::Repeat;
};

// Coordinates: u to the right, v down from the picture's upper edge, as glTF has them. Any numbers.
using PlaceOnTexture = std::array<double, 2>;

struct BakedTexture
{
  std::vector<Color> colors; // of each point; red, green and blue in linear light
  double texels = 0;         // that the triangles cover, one that several cover as often
  // How far the texels are from what the vertices' colours are between them, on average over the
  // area: in grey values (of 255) of a channel.
  double loss = 0;
};

// The colour of a point is the mean of the texels that its triangles cover, in linear light,
// weighted by their area on the surface and the more the nearer they are to the point: as much as
// the point's colour counts there when triangles are drawn. A point whose triangles have no area,
// or a coordinate that is no number, has the texel at its own coordinate; without a number too,
// white.
//
// Each triangle is looked at in equal parts, about one for each texel, but in all no more than
// eight for each texel of the picture and 64 for each triangle: so coordinates that repeat a
// picture a million times take no longer. Time: O(parts). Source: what is usual; ours is the limit.
BakedTexture BakeTexture(const TexturePicture& picture,
  std::span<const PlaceOnTexture> coordinates, std::span<const Vec3> points,
  std::span<const Triangle> triangles);

}
