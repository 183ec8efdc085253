// SPDX-License-Identifier: BSD-3-Clause
// The actors that draw one surface: in SurfaceScene's renderer, or as parts of vtkKdStreamActor.
// Step "render" of the pipeline picture.
#pragma once

#include "viewer/rendering/CloudSplats.h"
#include "viewer/rendering/ScenePart.h"
#include "viewer/rendering/SurfaceScene.h"

#include <vtkSmartPointer.h>
#include <vtkType.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

class vtkActor;
class vtkProperty;

namespace kdstream
{

// Threads: only one at a time, the window's.
class SurfaceActors
{
public:
  // The first callback is called for an actor that is drawn from now on (perhaps a second time),
  // the second for an actor that is no longer drawn.
  using Callback = std::function<void(vtkActor&)>;
  SurfaceActors(Callback add, Callback remove);
  ~SurfaceActors();
  SurfaceActors(const SurfaceActors&) = delete;
  SurfaceActors& operator=(const SurfaceActors&) = delete;

  // The same as SurfaceScene's functions.
  Status Update(const Surface& surface, const TreeDepths& depths, const Vec3& center);
  Status Update(const DrawnSurface& surface, const TreeDepths& depths, const Vec3& center,
    const std::shared_ptr<const TileList>& tiles = nullptr);
  void SetTileDecoder(TileDecoder decoder) { this->Decoder = decoder; }
  void SetStyle(const SceneStyle& style);

  // Sets the material of all actors, except the model's colours, and flat or smooth shading, which
  // the style sets. Costs nothing if the material was not modified since the last call. Before the
  // first call, the material is sceneMaterial.
  void SetMaterial(vtkProperty& material);

  // Call this before each picture. section: what is above it is not drawn. relief:
  // SceneLighting::relief.
  struct Sight : SplatSight
  {
    std::optional<SectionPlane> section;
    double relief = 0;
  };
  void Aim(const Sight& sight);

  bool Empty() const { return this->Entries.empty(); }
  // The box of what is drawn, relative to Center().
  const Box& Bounds() const { return this->Extent; }
  const Vec3& Center() const { return this->Middle; }
  const TreeDepths& Depths() const { return this->Tree; }
  // The FacetLength of what is drawn.
  double Facet() const { return this->FacetSize; }

private:
  struct Entry
  {
    std::unique_ptr<ScenePart> scene;
    DrawnSurface::Part drawn; // empty if the whole surface is drawn at once
    std::shared_ptr<const TextureTile> tile;
    bool isShown = false; // whether `scene` shows it
  };

  std::unique_ptr<ScenePart> NewPart() const;
  void Take(std::vector<Entry> entries);

  Callback Add, Remove;
  std::vector<Entry> Entries;
  TileDecoder Decoder = nullptr;
  SceneStyle Style;
  vtkSmartPointer<vtkProperty> Material; // null: the material of the scene
  vtkMTimeType MaterialTime = 0;
  TreeDepths Tree;
  Vec3 Middle{ 0.0, 0.0, 0.0 };
  Box Extent;
  double FacetSize = 0.0;
};

}
