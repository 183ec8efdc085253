// SPDX-License-Identifier: BSD-3-Clause
// A textured mesh, as the readers of textured formats return it, before its textures are baked to
// vertex colours. Part of step "read" of the pipeline picture.
#pragma once

#include "filters/core/Light.h"
#include "filters/core/Types.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

namespace kdstream
{

// How the texture continues beyond the picture's edge.
enum class TextureWrap
{
  Repeat,
  Mirror,
  Clamp
};

// u goes to the right and v down from the picture's upper edge, as in glTF; 0-1 is the picture. Any
// number is allowed; NaN for a corner without coordinates.
using PictureCoordinate = std::array<float, 2>;
inline constexpr PictureCoordinate noPictureCoordinate{ std::numeric_limits<float>::quiet_NaN(),
  std::numeric_limits<float>::quiet_NaN() };

// Maps the coordinates of corners to those in the picture: u' = u[0] u + u[1] v + u[2], and v'
// likewise.
struct TextureTransform
{
  std::array<double, 3> u{ 1, 0, 0 }, v{ 0, 1, 0 };
};
// For formats whose v goes up from the lower edge.
inline constexpr TextureTransform upsideDown{ { 1, 0, 0 }, { 0, -1, 1 } };

// Where a picture's bytes are: in `bytes`, or else in a file, or a part of it.
struct PictureSource
{
  std::string name; // for messages; with the line that names it, if known
  std::filesystem::path file;
  std::uint64_t offset = 0;
  std::uint64_t size = std::numeric_limits<std::uint64_t>::max(); // up to the end
  std::vector<std::uint8_t> bytes{};
  std::string wrong{}; // why there is no picture; empty: try to read
};

inline constexpr std::uint32_t noPicture = std::numeric_limits<std::uint32_t>::max();

struct TexturedMaterial
{
  std::string name;
  Color color{ 1, 1, 1, 1 };  // linear light; used if there is no picture
  Color factor{ 1, 1, 1, 1 }; // multiplies the picture's light
  std::uint32_t picture = noPicture;
  TextureWrap wrapU = TextureWrap::Repeat, wrapV = TextureWrap::Repeat;
  TextureTransform transform{};
  bool opaque = true; // whether alpha counts as 1
};

struct TexturedMesh
{
  Mesh mesh; // vertices need not be split where charts meet
  std::vector<std::array<PictureCoordinate, 3>> corners; // of each triangle
  std::vector<std::uint32_t> materialOf;                 // of each triangle
  std::vector<TexturedMaterial> materials;
  std::vector<PictureSource> pictures;
};

}
