// SPDX-License-Identifier: BSD-3-Clause
// Shared by the tests of viewer/mobile: models, cameras, pictures.
#pragma once

#include "Testing/Fixtures/BumpySphere.h"
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

// Loads a tile's picture, for GlesRenderer::SetTileUpload, as the page does
// (viewer/mobile/web/gl.js): with mipmaps. texels: red, green and blue bytes, with the top row
// first.
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

// A renderer and a target that it draws into. Throws, and so fails the test, if there is no OpenGL
// ES.
struct Canvas
{
  int width, height;
  std::unique_ptr<EglOffscreen> target;
  std::unique_ptr<GlesRenderer> renderer;

  Canvas(int pixelsWide, int pixelsHigh)
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
  ~Canvas()
  {
    EXPECT_TRUE(this->target->MakeCurrent());
    this->renderer.reset();
  }
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;

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

inline Surface BumpySphere(std::uint32_t rows, const Vec3& offset = { 0.0, 0.0, 0.0 })
{
  return BumpySphere(rows, offset, 0, true);
}

// A scene with the surface as a session shows it, seen from a little above and to the right.
// version: of the surface, as a session counts it.
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
