// SPDX-License-Identifier: BSD-3-Clause
// What a VTK renderer sees of a model: for the session, which chooses what to show, and for the
// actors, which draw it.
#pragma once

#include "viewer/rendering/SurfaceActors.h"
#include "viewer/session/appearance/SceneRules.h"

#include <optional>

class vtkMatrix4x4;
class vtkRenderer;

namespace kdstream
{

struct RendererView
{
  // A symmetric perspective view in the model's coordinates that contains the whole picture, at its
  // resolution. For a tiled picture: the whole picture. For a parallel projection: seen from a
  // distant eye.
  SceneCamera camera;
  int width = 1, height = 1;
  // What is drawn now; of a picture in tiles, this tile.
  SurfaceActors::Sight sight;
};

// The view of the active camera, with all its properties: angle, window centre, explicit and
// off-axis projections, transforms. placed: world from model. A window without a size counts as
// VTK's default, 300 x 300. Nothing if nothing can be seen: a viewport or tile without pixels, a
// matrix that cannot be inverted. REQUIRES: the renderer has a window and a camera.
std::optional<RendererView> ViewOf(vtkRenderer& renderer, vtkMatrix4x4& placed);

}
