// SPDX-License-Identifier: BSD-3-Clause
// Draws in a VTK renderer what a session says is to be shown. Step "render" of the pipeline
// picture.
#pragma once

#include "filters/core/Result.h"
#include "viewer/rendering/SurfaceScene.h"
#include "viewer/session/SessionTypes.h"

#include <cstdint>
#include <memory>
#include <optional>

namespace kdstream
{

class SessionScene
{
public:
  SessionScene();

  // For vtkRenderWindow::AddRenderer. It is always the same renderer.
  vtkRenderer& Renderer() { return this->Scene.Renderer(); }
  // Sets the colouring and ambient occlusion from the next picture on; occlusion: see SceneStyle.
  // For every model that is shown, the colouring is derived from this choice (ColoringOf).
  void SetAppearance(const ColorChoice& colors, bool occlusion);

  // Updates the surface and the camera. This takes time only if the surface has changed since the
  // last call. Errors: those of SurfaceScene.
  Status Follow(const ViewerScene& scene);

  // The origin of the surface's coordinates in the renderer.
  const Vec3& Center() const { return this->Middle; }

private:
  SurfaceScene Scene;
  ColorChoice Colors;
  bool HasOcclusion = false;
  ScalarDescriptions Scalars; // of the scene
  Vec3 Middle{};
  std::optional<std::uint64_t> ShownVersion;
  std::shared_ptr<const TileList> ShownTiles;
};

}
