// SPDX-License-Identifier: BSD-3-Clause
// How a VTK renderer sees a model: for the session, which chooses what to show, and for the actors,
// which draw it.
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
  // A symmetric perspective view, in the model's coordinates, that contains the whole picture at
  // its resolution. If the picture is taken in tiles, it contains all tiles. A parallel projection
  // is replaced by a view from a distant eye.
  SceneCamera camera;
  int width = 1, height = 1;
  // How the window sees what it draws now: the whole picture, or one tile of it.
  SurfaceActors::Sight sight;
};

// Returns the view of the active camera, with all its properties: angle, window centre, explicit
// and off-axis projections, transforms. placed: the matrix from the model's to world coordinates. A
// window without a size counts as 300 x 300, VTK's default. Returns nothing if nothing can be seen:
// the viewport or tile has no pixels, or a matrix cannot be inverted. REQUIRES: the renderer has a
// window and a camera.
std::optional<RendererView> ViewOf(vtkRenderer& renderer, vtkMatrix4x4& placed);

}
