// SPDX-License-Identifier: BSD-3-Clause
// What a session says is to be drawn, in a VTK renderer. Step "render" of the pipeline picture.
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

  // For vtkRenderWindow::AddRenderer. It stays the same.
  vtkRenderer& Renderer() { return this->Scene.Renderer(); }
  // Sets the colouring and ambient occlusion from the next picture on; occlusion: SceneStyle. The
  // colours are the choice's for every model that is shown (ColoringOf).
  void SetAppearance(const ColorChoice& colors, bool occlusion);

  // Updates surface and camera. Only a surface that has changed since the last call takes time.
  // Errors: those of SurfaceScene.
  Status Follow(const ViewerScene& scene);

  // What the surface's coordinates in the renderer are relative to.
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
