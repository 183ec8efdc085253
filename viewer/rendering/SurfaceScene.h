// SPDX-License-Identifier: BSD-3-Clause
// Draws one surface in a VTK renderer. Step "render" of the pipeline picture: the surface is
// DrawSurface's.
//
// The model stands like a piece in a museum: stone before a soft gradient, lit by the lights of
// viewer/session/appearance/SceneAppearance.h, which follow the camera.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/drawing/DrawnSurface.h"
#include "filters/core/tree/KdTree.h"
#include "viewer/rendering/Picture.h"
#include "viewer/session/appearance/Coloring.h"
#include "viewer/session/appearance/SceneAppearance.h"
#include "viewer/session/appearance/SceneRules.h"
#include "viewer/session/section/SectionPlane.h"
#include "viewer/session/texture/TileList.h"

#include <vtkNew.h>
#include <vtkSmartPointer.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

class vtkLight;
class vtkRenderer;

namespace kdstream
{

class SceneOcclusion;
class ScenePart;
class SurfaceActors;

// A tile's decoded picture: red, green and blue bytes, rows from the top down, in the size that the
// tile states. Errors: of decoding; the tile is then not drawn.
struct TilePicture
{
  std::uint32_t width = 1, height = 1;
  std::vector<std::uint8_t> texels;
};
using TileDecoder = Result<TilePicture> (*)(const TextureTile& tile);

struct SceneStyle
{
  Coloring coloring{};
  bool flat = false;      // a normal a triangle instead of one a vertex
  bool occlusion = false; // ambient occlusion (viewer/session/appearance/OcclusionShaders.h)
};

// A renderer with one surface, which may be replaced while the camera stays. Threads: only the
// window's thread.
class SurfaceScene
{
public:
  SurfaceScene();
  ~SurfaceScene();
  SurfaceScene(const SurfaceScene&) = delete;
  SurfaceScene& operator=(const SurfaceScene&) = delete;

  // For vtkRenderWindow::AddRenderer. It stays the same for the scene's life.
  vtkRenderer& Renderer() { return *this->SceneRenderer; }

  // Replaces what is drawn: triangles with normals weighted by area; or, for a surface without
  // triangles, its points as round splats. center: a point near the surface; coordinates relative
  // to it become floats, so that far-away origins cost no precision. depths: those of the surface's
  // cut, for the colouring by partition. O(points + triangles). The surface is not kept. Errors:
  // those of CheckSurface; then the scene does not change.
  Status Update(const Surface& surface, const TreeDepths& depths, const Vec3& center);
  // The same, but only parts that differ from the last surface, or have another tile, cost time:
  // each part is an actor. tiles: null, or the textures of parts with texture corners.
  Status Update(const DrawnSurface& surface, const TreeDepths& depths, const Vec3& center,
    const std::shared_ptr<const TileList>& tiles = nullptr);
  // Null, as at first: tiles paint nothing.
  void SetTileDecoder(TileDecoder decoder);

  // O(points + triangles) where the coloring changes.
  void SetStyle(const SceneStyle& style);

  // Hides what is above the plane, and draws the cap, in capColor. cap: null, or with triangles
  // whose indices are in range, in the same coordinates as the surface; capVersion identifies it.
  void SetSection(const std::optional<SectionPlane>& plane,
    const std::shared_ptr<const Surface>& cap, std::uint64_t capVersion);
  void SetLighting(const SceneLighting& lighting);

  // Near and far planes are found from the surface, now and at each Update. Errors: those of
  // CheckCamera.
  Status SetCamera(const SceneCamera& camera);

private:
  void ApplyCamera();
  void PlaceCap();
  void BeforePicture();
  void ApplyOcclusion();

  vtkNew<vtkRenderer> SceneRenderer;
  std::unique_ptr<SurfaceActors> Actors;
  SceneCamera Camera;
  bool HasOcclusion = false;
  std::unique_ptr<SceneOcclusion> Occlusion;
  unsigned long PictureObserver = 0, OcclusionObserver = 0;

  std::array<vtkSmartPointer<vtkLight>, 2> Lights;
  SceneLighting Lighting;
  std::optional<SectionPlane> Section;
  std::shared_ptr<const Surface> Cap;  // null without
  std::unique_ptr<ScenePart> CapDrawn; // made for the first section
  std::uint64_t CapVersion = 0;
};

}
