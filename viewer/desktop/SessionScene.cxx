// SPDX-License-Identifier: BSD-3-Clause
// Draws what a session says is to be shown: see SessionScene.h.
#include "viewer/desktop/SessionScene.h"

#include "viewer/rendering/DecodeTile.h"

namespace kdstream
{

SessionScene::SessionScene()
{
  this->Scene.SetTileDecoder(DecodeTile);
}

void SessionScene::SetAppearance(const ColorChoice& colors, bool occlusion)
{
  this->Colors = colors;
  this->HasOcclusion = occlusion;
  this->Scene.SetStyle({ ColoringOf(colors, this->Scalars), false, occlusion });
}

Status SessionScene::Follow(const ViewerScene& scene)
{
  if (this->Scalars != scene.scalars)
  {
    this->Scalars = scene.scalars;
    this->SetAppearance(this->Colors, this->HasOcclusion);
  }
  if (this->ShownVersion != scene.surfaceVersion || this->ShownTiles != scene.tiles)
  {
    this->Middle = scene.box.Empty() ? Vec3{} : scene.box.lo * 0.5 + scene.box.hi * 0.5;
    KDSTREAM_TRY(this->Scene.Update(*scene.surface, scene.depths, this->Middle, scene.tiles));
    this->ShownVersion = scene.surfaceVersion;
    this->ShownTiles = scene.tiles;
  }
  this->Scene.SetSection(scene.section, scene.cap, scene.capVersion);
  this->Scene.SetLighting(scene.lighting);
  return this->Scene.SetCamera({ scene.eye, scene.focal, scene.up, scene.viewAngle });
}

}
