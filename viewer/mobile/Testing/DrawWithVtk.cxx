// SPDX-License-Identifier: BSD-3-Clause
// Draws the compared scenes with VTK into PNG files in the current folder. This is a separate
// program, because the OpenGL symbols of VTK and of OpenGL ES cannot be in one program.
#include "viewer/mobile/Testing/ComparedScenes.h"
#include "viewer/mobile/Testing/PngFile.h"
#include "viewer/mobile/Testing/TiledScenes.h"
#include "viewer/offscreen/OffscreenWindow.h"
#include "viewer/rendering/Picture.h"
#include "viewer/rendering/SurfaceScene.h"

#include <vtkLight.h>
#include <vtkLightCollection.h>
#include <vtkRenderer.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <utility>

namespace
{

using namespace kdstream;
using namespace kdstream::test;

Status DrawTo(const std::string& file, vtkRenderWindow& window)
{
  const Result<WindowPicture> picture = Pixels(window);
  KDSTREAM_TRY(picture);
  WritePngFile(file, picture->rgb, picture->width, picture->height);
  return {};
}

Result<TilePicture> PictureOf(const TextureTile& tile)
{
  return TilePicture{ tile.width, tile.height, PatternOf(tile) };
}

Status DrawAll(const ComparedScene& compared)
{
  const auto window = MakeOffscreenWindow(WindowBackend::Egl, compared.width, compared.height);
  KDSTREAM_TRY(window);
  SurfaceScene drawn;
  (*window)->AddRenderer(&drawn.Renderer());
  SceneStyle style;
  style.coloring = compared.coloring;
  drawn.SetStyle(style);
  drawn.SetTileDecoder(PictureOf);
  const ViewerScene& scene = compared.scene;
  const Vec3 center = scene.box.lo * 0.5 + scene.box.hi * 0.5;
  drawn.SetLighting(scene.lighting);
  for (const Status& status : { drawn.Update(*scene.surface, scene.depths, center, scene.tiles),
         drawn.SetCamera({ scene.eye, scene.focal, scene.up, scene.viewAngle }) })
  {
    KDSTREAM_TRY(status);
  }
  drawn.SetSection(scene.section, scene.cap, scene.capVersion);
  KDSTREAM_TRY(DrawTo(compared.name + usualSuffix, **window));
  style.occlusion = true;
  drawn.SetStyle(style);
  KDSTREAM_TRY(DrawTo(compared.name + occlusionSuffix, **window));
  style.occlusion = false;
  drawn.SetStyle(style);
  auto* fill = vtkLight::SafeDownCast(drawn.Renderer().GetLights()->GetItemAsObject(1));
  fill->SwitchOff();
  KDSTREAM_TRY(DrawTo(compared.name + darkerSuffix, **window));
  fill->SwitchOn();
  drawn.Renderer().GradientBackgroundOff();
  drawn.Renderer().SetBackground(0.0, 0.0, 0.0);
  KDSTREAM_TRY(DrawTo(compared.name + blackSuffix, **window));
  drawn.Renderer().SetBackground(1.0, 1.0, 1.0);
  return DrawTo(compared.name + whiteSuffix, **window);
}

// Draws with tiles, with the whole photograph, and in the colours of the resolutions.
Status DrawTiled(const TiledScene& tiled)
{
  const auto window = MakeOffscreenWindow(WindowBackend::Egl, tiled.width, tiled.height);
  KDSTREAM_TRY(window);
  SurfaceScene drawn;
  (*window)->AddRenderer(&drawn.Renderer());
  drawn.Renderer().GradientBackgroundOff();
  drawn.Renderer().SetBackground(0.0, 0.0, 0.0);
  drawn.SetTileDecoder(
    [](const TextureTile& tile) -> Result<TilePicture>
    {
      auto texels = TexelsOf(tile);
      KDSTREAM_TRY(texels);
      return TilePicture{ tile.width, tile.height, std::move(*texels) };
    });
  const ViewerScene& scene = tiled.scene;
  const Vec3 center = scene.box.lo * 0.5 + scene.box.hi * 0.5;
  drawn.SetLighting(scene.lighting);
  for (const auto& [tiles, suffix] : { std::pair{ scene.tiles, tiledSuffix },
         { tiled.whole, wholeSuffix }, { tiled.resolutions, resolutionsSuffix } })
  {
    if (!tiles)
    {
      continue;
    }
    KDSTREAM_TRY(drawn.Update(*scene.surface, scene.depths, center, tiles));
    KDSTREAM_TRY(drawn.SetCamera({ scene.eye, scene.focal, scene.up, scene.viewAngle }));
    KDSTREAM_TRY(DrawTo(tiled.name + suffix, **window));
  }
  return {};
}

int TellOf(const std::string& name, const Status& status)
{
  if (!status)
  {
    std::fprintf(stderr, "%s: %s\n", name.c_str(), status.GetError().message.c_str());
  }
  return status ? 0 : 1;
}

}

int main()
{
  int exitCode = 0;
  for (const ComparedScene& compared : MakeComparedScenes())
  {
    exitCode = std::max(exitCode, TellOf(compared.name, DrawAll(compared)));
  }
  for (const TiledScene& tiled : MakeTiledScenes())
  {
    exitCode = std::max(exitCode, TellOf(tiled.name, DrawTiled(tiled)));
  }
  const TiledScene ofLevels = MakeSceneOfLevels();
  exitCode = std::max(exitCode, TellOf(ofLevels.name, DrawTiled(ofLevels)));
  return exitCode;
}
