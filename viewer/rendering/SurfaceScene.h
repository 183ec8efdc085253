// SPDX-License-Identifier: BSD-3-Clause
// Draws one surface, which DrawSurface made, in a VTK renderer. Step "render" of the pipeline
// picture.
//
// The model looks like a piece in a museum: stone in front of a soft gradient. It is lit by the
// lights of viewer/session/appearance/SceneAppearance.h, which follow the camera.
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

// A tile's decoded picture: red, green and blue bytes, with the top row first, in the size that the
// tile states. Errors of the decoder: those of decoding; then the tile is not drawn.
struct TilePicture
{
  std::uint32_t width = 1, height = 1;
  std::vector<std::uint8_t> texels;
};
using TileDecoder = Result<TilePicture> (*)(const TextureTile& tile);

struct SceneStyle
{
  Coloring coloring{};
  bool flat = false;      // a normal per triangle instead of one per vertex
  bool occlusion = false; // ambient occlusion (viewer/session/appearance/OcclusionShaders.h)
};

// A renderer with one surface, which can be replaced while the camera stays. Threads: only the
// window's thread.
class SurfaceScene
{
public:
  SurfaceScene();
  ~SurfaceScene();
  SurfaceScene(const SurfaceScene&) = delete;
  SurfaceScene& operator=(const SurfaceScene&) = delete;

  // For vtkRenderWindow::AddRenderer. It is the same renderer throughout the scene's life.
  vtkRenderer& Renderer() { return *this->SceneRenderer; }

  // Replaces what is drawn. Triangles are drawn with normals weighted by area; a surface without
  // triangles is drawn as points, each a round splat. center: a point near the surface. Coordinates
  // relative to it become floats, so precision is not lost if the surface is far from the origin.
  // depths: of the tree that the surface is cut from, for the colouring by partition. O(points +
  // triangles). The surface is not kept. Errors: those of CheckSurface; then the scene does not
  // change.
  Status Update(const Surface& surface, const TreeDepths& depths, const Vec3& center);
  // The same, but time is spent only on parts that differ from the last surface or have another
  // tile: each part has an actor. tiles: the textures of parts with texture corners; may be null.
  Status Update(const DrawnSurface& surface, const TreeDepths& depths, const Vec3& center,
    const std::shared_ptr<const TileList>& tiles = nullptr);
  // Null is the default: then tiles are not drawn.
  void SetTileDecoder(TileDecoder decoder);

  // Takes O(points + triangles) if the colouring changes.
  void SetStyle(const SceneStyle& style);

  // Hides what is above the plane, and draws the cap in capColor. cap: null, or a surface in the
  // same coordinates as the model, with triangles whose indices are in range. capVersion:
  // identifies the cap.
  void SetSection(const std::optional<SectionPlane>& plane,
    const std::shared_ptr<const Surface>& cap, std::uint64_t capVersion);
  void SetLighting(const SceneLighting& lighting);

  // The near and far planes are computed from the surface, now and at each Update. Errors: those of
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
  std::shared_ptr<const Surface> Cap;  // null if there is none
  std::unique_ptr<ScenePart> CapDrawn; // made for the first section
  std::uint64_t CapVersion = 0;
};

}
