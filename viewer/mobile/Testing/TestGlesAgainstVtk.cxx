// SPDX-License-Identifier: BSD-3-Clause
// Compares the phone's renderer with the desktop's. The same scenes are drawn here with OpenGL ES,
// and by DrawWithVtk with VTK; DrawWithVtk must have run before in the same folder.
#include "viewer/mobile/Testing/ComparedScenes.h"
#include "viewer/mobile/Testing/GlesTools.h"
#include "viewer/mobile/Testing/PngFile.h"
#include "viewer/session/appearance/SceneAppearance.h"

#include <algorithm>
#include <iostream>
#include <memory>
#include <string>

namespace kdstream::test
{
namespace
{

// Limits, and the values measured with Mesa 22.3's llvmpipe. The mean absolute difference of all
// channels, 0-255; measured: at most 0.14 for a cloud, 0.023 for surfaces.
constexpr double mostMean = 0.2;
// The same with ambient occlusion; measured: at most 0.145 for the torus, and for a cloud, where
// each splat has a depth of its own, 0.255 with Mesa 22 and 0.79 with Mesa 25.
constexpr double mostOcclusionMean = 0.28, mostOcclusionMeanOfClouds = 0.9;
// The pixels that show the model in only one of the pictures, as a share of those that show it in
// either; measured: at most 0.0022 on the outline of a cloud's splats, and 0.0012 for the dragon.
constexpr double mostSilhouette = 0.0025;

const std::vector<ComparedScene>& Scenes()
{
  static const std::vector<ComparedScene> scenes = MakeComparedScenes();
  return scenes;
}

void UploadPattern(unsigned texture, const TextureTile& tile)
{
  UploadTexels(texture, tile, PatternOf(tile));
}

Image FromVtk(const ComparedScene& compared, const char* suffix)
{
  const Image image = ReadPngFile(compared.name + suffix, compared.width, compared.height);
  EXPECT_FALSE(image.empty()) << compared.name + suffix << " is missing: run DrawWithVtk here";
  return image;
}

std::vector<bool> SilhouetteHere(Canvas& canvas, const ViewerScene& scene)
{
  canvas.renderer->SetBackground({ 0, 0, 0 }, { 0, 0, 0 });
  const Image black = canvas.Draw(scene);
  canvas.renderer->SetBackground({ 1, 1, 1 }, { 1, 1, 1 });
  const Image white = canvas.Draw(scene);
  canvas.renderer->SetBackground(backgroundBottom, backgroundTop);
  return Silhouette(black, white);
}

double SilhouetteDistance(const std::vector<bool>& here, const std::vector<bool>& there)
{
  std::size_t model = 0;
  std::size_t differing = 0;
  for (std::size_t i = 0; i < std::min(here.size(), there.size()); ++i)
  {
    model += here[i] || there[i] ? 1 : 0;
    differing += here[i] != there[i] ? 1 : 0;
  }
  EXPECT_GT(model, here.size() / 20);
  return static_cast<double>(differing) / static_cast<double>(model);
}

void CompareScene(const ComparedScene& compared)
{
  SCOPED_TRACE(compared.name);
  Canvas canvas(compared.width, compared.height);
  canvas.renderer->SetColoring(compared.coloring);
  const Image here = canvas.Draw(compared.scene);
  WritePngFile(compared.name + ".gles.png", here, compared.width, compared.height);
  const double mean = Compare(here, FromVtk(compared, usualSuffix)).mean;
  const auto there = Silhouette(FromVtk(compared, blackSuffix), FromVtk(compared, whiteSuffix));
  const double silhouette = SilhouetteDistance(SilhouetteHere(canvas, compared.scene), there);
  EXPECT_LE(mean, mostMean);
  EXPECT_LE(silhouette, mostSilhouette);

  // The limits are tight enough to notice a missing light, or a camera that is 1 % too far away.
  const double lightMean = Compare(here, FromVtk(compared, darkerSuffix)).mean;
  EXPECT_GT(lightMean, 4 * mostMean);
  ViewerScene off = compared.scene;
  off.eye = off.focal + (off.eye - off.focal) * 1.01;
  const double offMean = Compare(canvas.Draw(off), FromVtk(compared, usualSuffix)).mean;
  const double offSilhouette = SilhouetteDistance(SilhouetteHere(canvas, off), there);
  EXPECT_GT(offMean, 2 * mostMean);
  EXPECT_GT(offSilhouette, 4 * mostSilhouette);
  std::cout << compared.name << ": mean difference " << mean << ", silhouette " << silhouette
            << "; without the fill light " << lightMean << "; 1 % farther away " << offMean << ", "
            << offSilhouette << "\n";
}

void CompareOcclusion(const ComparedScene& compared)
{
  SCOPED_TRACE(compared.name);
  Canvas canvas(compared.width, compared.height);
  canvas.renderer->SetColoring(compared.coloring);
  const Image plain = canvas.Draw(compared.scene);
  canvas.renderer->SetOcclusion(true);
  const Image here = canvas.Draw(compared.scene);
  WritePngFile(compared.name + ".gles.hollow.png", here, compared.width, compared.height);
  const Image there = FromVtk(compared, occlusionSuffix);
  const double mean = Compare(here, there).mean;
  const double plainMean = Compare(plain, there).mean;
  const bool cloud = compared.name.rfind("Cloud", 0) == 0;
  const double most = cloud ? mostOcclusionMeanOfClouds : mostOcclusionMean;
  EXPECT_LE(mean, most);
  EXPECT_GT(plainMean, 2 * most);
  std::cout << compared.name << ": mean difference with occlusion " << mean << "; here without "
            << plainMean << "\n";
  canvas.renderer->SetOcclusion(false);
  EXPECT_EQ(canvas.Draw(compared.scene), plain);
}

TEST(GlesAgainstVtk, DarkensTheSameByOcclusion)
{
  GlesRenderer::SetTileUpload(UploadPattern);
  for (const ComparedScene& compared : Scenes())
  {
    CompareOcclusion(compared);
  }
}

// The comparison of whole scenes would notice only by chance that textures are at a wrong place.
TEST(GlesAgainstVtk, DrawsTextures)
{
  GlesRenderer::SetTileUpload(UploadPattern);
  const auto textured = std::find_if(Scenes().begin(), Scenes().end(),
    [](const ComparedScene& scene) { return scene.name == "Textured"; });
  ASSERT_NE(textured, Scenes().end());
  const Image there = FromVtk(*textured, usualSuffix);
  Canvas canvas(textured->width, textured->height);
  EXPECT_LE(Compare(canvas.Draw(textured->scene), there).mean, mostMean);
  const std::size_t bytes = canvas.renderer->GraphicsBytes();
  ViewerScene plain = textured->scene;
  plain.tiles = nullptr;
  EXPECT_GT(Compare(canvas.Draw(plain), there).mean, 10 * mostMean);
  EXPECT_LT(canvas.renderer->GraphicsBytes() + 4 * 128 * 128, bytes);
  auto moved = std::make_shared<TileList>(*textured->scene.tiles);
  for (TexturedPiece& each : *moved)
  {
    TextureTile tile = *each.tile;
    for (auto& corners : tile.corners)
    {
      for (TileCoordinate& corner : corners)
      {
        corner[0] += 1; // by one texel
      }
    }
    each.tile = std::make_shared<const TextureTile>(std::move(tile));
  }
  plain.tiles = moved;
  EXPECT_GT(Compare(canvas.Draw(plain), there).mean, 2 * mostMean);
}

TEST(GlesAgainstVtk, DrawsTheSamePictures)
{
  GlesRenderer::SetTileUpload(UploadPattern);
  for (const ComparedScene& compared : Scenes())
  {
    CompareScene(compared);
  }
}

TEST(GlesAgainstVtk, DrawsTheDragon)
{
  if (!HasDragon())
  {
    GTEST_SKIP() << "no dragon: Data/fetch-dragon fetches it";
  }
  EXPECT_EQ(Scenes().back().name, "DragonPartitions");
}

}
}
