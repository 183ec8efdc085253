// SPDX-License-Identifier: BSD-3-Clause
// One part of a surface in a VTK renderer, drawn by an actor of its own. Used by SurfaceActors.cxx,
// and for the cap in SurfaceScene.cxx.
#pragma once

#include "filters/core/drawing/SurfaceParts.h"
#include "filters/core/tree/KdTree.h"
#include "viewer/rendering/SurfaceScene.h"
#include "viewer/session/appearance/SceneRules.h"
#include "viewer/session/appearance/VertexNormals.h"

#include <vtkNew.h>
#include <vtkSmartPointer.h>

#include <array>
#include <memory>
#include <optional>
#include <vector>

class vtkActor;
class vtkPolyData;
class vtkPolyDataMapper;
class vtkProperty;
class vtkTexture;
class vtkUnsignedCharArray;

namespace kdstream
{

struct SplatSight;

class ScenePart
{
public:
  ScenePart();
  ~ScenePart();
  ScenePart(const ScenePart&) = delete;
  ScenePart& operator=(const ScenePart&) = delete;

  vtkActor& Actor() { return *this->Drawing; }
  // The box of what is drawn, relative to `center`.
  const Box& Bounds() const { return this->Extent; }

  // Draws this surface from now on, as SurfaceScene::Update does. normals: one for each point, or
  // none. REQUIRES: CheckSurface has found no error. O(points + triangles).
  void Show(const Surface& surface, const UnitNormals& normals, const TreeDepths& depths,
    const Vec3& center, const SceneStyle& style);
  // The same with a texture, if the style uses the model's own colours. Returns false and changes
  // nothing if the tile does not fit the part or its picture cannot be decoded.
  struct TextureSource
  {
    std::shared_ptr<const TextureTile> tile;
    TileDecoder decoder = nullptr;
  };
  bool ShowTextured(const SurfacePart& part, const UnitNormals& normals, const TreeDepths& depths,
    const Vec3& center, const SceneStyle& style, const TextureSource& textureSource);
  void SetStyle(const SceneStyle& style);
  // Uses a copy of the material from now on. Call SetStyle afterwards.
  void SetMaterial(vtkProperty& material);
  // Hides what is above the plane until the next call, or until another surface is shown. center:
  // as in Show.
  void CutBy(const std::optional<SectionPlane>& plane, const Vec3& center);
  // Call this before each picture. relief: SceneLighting::relief, for a surface that bends by a
  // radian within this number of pixels.
  void RaiseRelief(double relief, double pixels);
  // Call this before each picture. Does the same as AimSplats of CloudSplats.h; for triangles it
  // only sets whether they are lit.
  void Aim(const SplatSight& sight);

private:
  void AddShaders();
  void LetGoOfTexture();
  void Tint(bool textured);
  void TakeColors(const Surface& surface, const TreeDepths& depths);
  vtkSmartPointer<vtkUnsignedCharArray> PointColors(const Coloring& coloring) const;
  vtkSmartPointer<vtkUnsignedCharArray> CellColors(SurfaceColoring coloring) const;

  vtkNew<vtkActor> Drawing;
  vtkNew<vtkPolyDataMapper> Mapper;
  vtkNew<vtkPolyData> Drawn;
  Box Extent;
  bool IsCut = false;
  bool IsCloud = false;
  bool IsLit = true;                       // in the last picture
  double LargestRadius = 0.0;              // of the points of a cloud; 0 for a surface
  std::vector<ColorSource> Sources;        // one for each point
  Surface Arrays;                          // arrays for colours, without the points
  std::shared_ptr<const TextureTile> Tile; // the tile whose picture is in Texture; or null
  vtkSmartPointer<vtkTexture> Texture;     // or null
  bool IsTextured = false;                 // whether the texture is shown
  std::array<double, 3> Plain;             // colour of points without their own colour
};

}
