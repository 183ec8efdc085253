// SPDX-License-Identifier: BSD-3-Clause
// Compares tiles with the whole photograph: few pixels differ between what both renderers draw with
// a model's tiles, and what VTK draws with the whole photograph. This holds from near, from far
// away where several texels share a pixel, and where tiles of several resolutions meet. DrawWithVtk
// must have run before in the same folder.
#include "viewer/mobile/Testing/GlesTools.h"
#include "viewer/mobile/Testing/PngFile.h"
#include "viewer/mobile/Testing/TiledScenes.h"

#include <algorithm>
#include <iostream>

namespace kdstream::test
{
namespace
{

// The share of the object's pixels, or of those at borders, that may differ by more than 8 of 255.
constexpr double mostDiffering = 0.005;

void UploadTile(unsigned texture, const TextureTile& tile)
{
  const auto texels = TexelsOf(tile);
  ASSERT_TRUE(texels) << texels.GetError().message;
  UploadTexels(texture, tile, *texels);
}

double Differing(const Image& a, const Image& b)
{
  std::size_t object = 0, differing = 0;
  for (std::size_t i = 0; i + 3 <= std::min(a.size(), b.size()); i += 3)
  {
    int most = 0, light = 0;
    for (std::size_t k = i; k < i + 3; ++k)
    {
      most = std::max(most, std::abs(int{ a[k] } - int{ b[k] }));
      light += a[k] + b[k];
    }
    object += light > 0 ? 1 : 0;
    differing += most > 8 ? 1 : 0;
  }
  EXPECT_GT(object, 2000U);
  return double(differing) / double(object);
}

// Whether the pixels at a distance of at most two from each pixel show several resolutions, which
// are red, green and blue.
std::vector<bool> BordersOf(const Image& resolutions, int width, int height)
{
  const auto resolutionAt = [&](int x, int y)
  {
    const auto first = resolutions.begin() + 3 * (y * width + x);
    const auto most = std::max_element(first, first + 3);
    return *most > 0 ? 1 << (most - first) : 0;
  };
  std::vector<bool> isBorder;
  for (int y = 0; y < height && !resolutions.empty(); ++y)
  {
    for (int x = 0; x < width; ++x)
    {
      int seen = 0;
      for (int v = std::max(y - 2, 0); v <= std::min(y + 2, height - 1); ++v)
      {
        for (int u = std::max(x - 2, 0); u <= std::min(x + 2, width - 1); ++u)
        {
          seen |= resolutionAt(u, v);
        }
      }
      isBorder.push_back((seen & (seen - 1)) != 0);
    }
  }
  return isBorder;
}

double DifferingAt(const std::vector<bool>& chosen, const Image& a, const Image& b)
{
  std::size_t all = 0, differing = 0;
  for (std::size_t i = 0; i < chosen.size() && 3 * i + 3 <= std::min(a.size(), b.size()); ++i)
  {
    int most = 0;
    for (std::size_t k = 3 * i; k < 3 * i + 3; ++k)
    {
      most = std::max(most, std::abs(int{ a[k] } - int{ b[k] }));
    }
    all += chosen[i] ? 1 : 0;
    differing += chosen[i] && most > 8 ? 1 : 0;
  }
  EXPECT_GT(all, 500U);
  return double(differing) / double(all);
}

Image FromVtk(const TiledScene& tiled, const char* suffix)
{
  Image image = ReadPngFile(tiled.name + suffix, tiled.width, tiled.height);
  EXPECT_FALSE(image.empty()) << tiled.name + suffix << " is missing: run DrawWithVtk here";
  return image;
}

TEST(GlesTiles, NothingIsSeenOfThem)
{
  GlesRenderer::SetTileUpload(UploadTile);
  for (const TiledScene& tiled : MakeTiledScenes())
  {
    SCOPED_TRACE(tiled.name);
    Canvas canvas(tiled.width, tiled.height);
    canvas.renderer->SetBackground({ 0, 0, 0 }, { 0, 0, 0 });
    const Image here = canvas.Draw(tiled.scene);
    WritePngFile(tiled.name + ".gles.png", here, tiled.width, tiled.height);
    const Image whole = FromVtk(tiled, wholeSuffix);
    const double desktop = Differing(FromVtk(tiled, tiledSuffix), whole),
                 phone = Differing(here, whole);
    EXPECT_LE(desktop, mostDiffering);
    EXPECT_LE(phone, mostDiffering);
    ViewerScene plain = tiled.scene;
    plain.tiles = nullptr;
    EXPECT_GT(Differing(canvas.Draw(plain), whole), 0.5);
    std::cout << tiled.name << ": tiles by VTK " << desktop << ", by OpenGL ES " << phone << "\n";
  }
}

TEST(GlesTiles, NothingIsSeenWhereResolutionsMeet)
{
  GlesRenderer::SetTileUpload(UploadTile);
  const TiledScene tiled = MakeSceneOfLevels();
  Canvas canvas(tiled.width, tiled.height);
  canvas.renderer->SetBackground({ 0, 0, 0 }, { 0, 0, 0 });
  const Image here = canvas.Draw(tiled.scene);
  WritePngFile(tiled.name + ".gles.png", here, tiled.width, tiled.height);
  const Image whole = FromVtk(tiled, wholeSuffix);
  const std::vector<bool> borders =
    BordersOf(FromVtk(tiled, resolutionsSuffix), tiled.width, tiled.height);
  const double desktop = DifferingAt(borders, FromVtk(tiled, tiledSuffix), whole),
               phone = DifferingAt(borders, here, whole);
  EXPECT_LE(desktop, mostDiffering);
  EXPECT_LE(phone, mostDiffering);
  ViewerScene plain = tiled.scene;
  plain.tiles = nullptr;
  EXPECT_GT(DifferingAt(borders, canvas.Draw(plain), whole), 0.5);
  std::cout << tiled.name << ": tiles by VTK " << desktop << ", by OpenGL ES " << phone << "\n";
}

}
}
