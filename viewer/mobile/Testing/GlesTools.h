// SPDX-License-Identifier: BSD-3-Clause
// What the tests of viewer/mobile share: models, cameras, pictures.
#pragma once

#include "viewer/mobile/GlesRenderer.h"
#include "viewer/mobile/Testing/EglOffscreen.h"
#include "viewer/mobile/Testing/Images.h"

#include <GLES3/gl3.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <vector>

namespace kdstream::test
{

// A tile's picture for GlesRenderer::SetTileUpload, as the page brings it
// (viewer/mobile/web/gl.js): with halves and quarters. texels: red, green and blue bytes, rows from
// the top down.
inline void UploadTexels(
  unsigned texture, const TextureTile& tile, const std::vector<std::uint8_t>& texels)
{
  ASSERT_EQ(texels.size(), std::size_t{ 3 } * tile.width * tile.height);
  glBindTexture(GL_TEXTURE_2D, texture);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB, static_cast<GLsizei>(tile.width),
    static_cast<GLsizei>(tile.height), 0, GL_RGB, GL_UNSIGNED_BYTE, texels.data());
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 2);
  glGenerateMipmap(GL_TEXTURE_2D);
}

// A renderer and what it draws into. Throws, and so fails its test, where there is no OpenGL ES.
struct Easel
{
  int width, height;
  std::unique_ptr<EglOffscreen> target;
  std::unique_ptr<GlesRenderer> renderer;

  Easel(int pixelsWide, int pixelsHigh)
    : width(pixelsWide)
    , height(pixelsHigh)
  {
    auto made = EglOffscreen::Make(width, height);
    if (!made)
    {
      throw std::runtime_error(made.GetError().message);
    }
    this->target = std::move(*made);
    auto drawing = GlesRenderer::Make();
    if (!drawing)
    {
      throw std::runtime_error(drawing.GetError().message);
    }
    this->renderer = std::move(*drawing);
  }
  ~Easel()
  {
    EXPECT_TRUE(this->target->MakeCurrent());
    this->renderer.reset();
  }
  Easel(const Easel&) = delete;
  Easel& operator=(const Easel&) = delete;

  Status Try(const ViewerScene& scene)
  {
    EXPECT_TRUE(this->target->MakeCurrent());
    return this->renderer->Draw(scene, { this->width, this->height, 1 });
  }
  Image Read()
  {
    const auto pixels = this->target->Pixels();
    EXPECT_TRUE(pixels) << (pixels ? "" : pixels.GetError().message);
    return pixels ? *pixels : Image{};
  }
  Image Draw(const ViewerScene& scene)
  {
    const Status status = this->Try(scene);
    EXPECT_TRUE(status) << (status ? "" : status.GetError().message);
    return this->Read();
  }
};

// Depths of a tree of 8 partitions whose finest level and stitch depth are 7.
inline constexpr TreeDepths depths{ 3, 7, 7 };

// Rounds to a multiple of 2^-20, so that adding an offset of a few millions loses nothing.
inline double OnGrid(double x)
{
  return std::round(x * 1048576.0) / 1048576.0;
}

// A closed sphere of radius about 1 with bumps; `rows` rings of 2 × rows quads. Its vertices are
// originals, each in the partition of its octant; those below are of two levels.
inline Surface BumpySphere(std::uint32_t rows, const Vec3& offset = { 0.0, 0.0, 0.0 })
{
  Surface surface;
  const std::uint32_t columns = 2 * rows;
  const auto add = [&](double polar, double azimuth)
  {
    const double radius = 1.0 + 0.08 * std::sin(5.0 * polar) * std::sin(6.0 * azimuth);
    const Vec3 p{ OnGrid(radius * std::sin(polar) * std::cos(azimuth)),
      OnGrid(radius * std::cos(polar)), OnGrid(radius * std::sin(polar) * std::sin(azimuth)) };
    const auto octant = static_cast<std::uint32_t>(
      (p[0] > 0.0 ? 1 : 0) + (p[1] > 0.0 ? 2 : 0) + (p[2] > 0.0 ? 4 : 0));
    const auto index = static_cast<std::uint32_t>(surface.points.size());
    const Resolution resolution =
      p[1] > -0.3 ? Resolution::Original() : Resolution::Level(p[1] > -0.7 ? 7 : 3);
    surface.sources.push_back({ resolution, MakeKey(octant, index) });
    surface.points.push_back({ p[0] + offset[0], p[1] + offset[1], p[2] + offset[2] });
  };
  add(0.0, 0.0);
  for (std::uint32_t r = 1; r < rows; ++r)
  {
    for (std::uint32_t c = 0; c < columns; ++c)
    {
      add(std::numbers::pi * r / rows, 2.0 * std::numbers::pi * c / columns);
    }
  }
  add(std::numbers::pi, 0.0);
  const auto last = static_cast<VertexId>(surface.points.size() - 1);
  const auto at = [&](std::uint32_t r, std::uint32_t c)
  { return 1 + (r - 1) * columns + c % columns; };
  for (std::uint32_t c = 0; c < columns; ++c)
  {
    surface.triangles.push_back({ 0, at(1, c + 1), at(1, c) });
    for (std::uint32_t r = 1; r + 1 < rows; ++r)
    {
      surface.triangles.push_back({ at(r, c), at(r, c + 1), at(r + 1, c + 1) });
      surface.triangles.push_back({ at(r, c), at(r + 1, c + 1), at(r + 1, c) });
    }
    surface.triangles.push_back({ at(rows - 1, c), at(rows - 1, c + 1), last });
  }
  return surface;
}

// The surface as a session shows it, from a little above and to the right; `version` as the
// session's.
inline ViewerScene SceneOf(Surface surface, std::uint64_t version = 1)
{
  ViewerScene scene;
  for (const Vec3& point : surface.points)
  {
    scene.box.Add(point);
  }
  if (!scene.box.Empty())
  {
    scene.focal = scene.box.lo * 0.5 + scene.box.hi * 0.5;
  }
  scene.surface = std::make_shared<const DrawnSurface>(std::move(surface));
  scene.surfaceVersion = version;
  scene.eye = scene.focal + Vec3{ 1.5, 1.2, 4.8 };
  scene.viewAngle = 0.7;
  scene.depths = depths;
  return scene;
}

}
