// SPDX-License-Identifier: BSD-3-Clause
// Tiles compared with the whole picture: what both renderers draw with a model's tiles differs at
// few pixels from what VTK draws with the whole picture, near, and far away where several texels
// share a pixel. DrawWithVtk must have run in the same folder.
#include "viewer/mobile/Testing/GlesTools.h"
#include "viewer/mobile/Testing/PngFile.h"
#include "viewer/mobile/Testing/TiledScenes.h"

#include <algorithm>
#include <iostream>

namespace kdstream::test
{
namespace
{

// Of the object's pixels, those that differ by more than 8 of 255.
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

}
}
