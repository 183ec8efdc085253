// SPDX-License-Identifier: BSD-3-Clause
// Draws one surface in a VTK renderer: see SurfaceScene.h.
#include "viewer/rendering/SurfaceScene.h"

#include "viewer/rendering/SceneOcclusion.h"
#include "viewer/rendering/ScenePart.h"
#include "viewer/session/Geometry.h"
#include "viewer/session/look/SceneLook.h"

#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCommand.h>
#include <vtkLight.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

namespace kdstream
{
namespace
{

// Each part is an actor, which costs time in every picture. Of more than so many all are drawn as
// one: more than what is shown within a viewer's budgets.
constexpr std::size_t mostParts = 1024;

void Shine(vtkLight& light, const SceneLight& as)
{
  light.SetPosition(as.position.data());
  light.SetColor(as.color.data());
  light.SetIntensity(as.intensity);
  light.SetSwitch(as.intensity > 0);
}

vtkSmartPointer<vtkLight> AddLamp(vtkRenderer& renderer, const SceneLight& as)
{
  auto light = vtkSmartPointer<vtkLight>::New();
  light->SetLightTypeToCameraLight();
  light->SetPositional(0);
  light->SetFocalPoint(0.0, 0.0, 0.0);
  Shine(*light, as);
  renderer.AddLight(light);
  return light;
}

// A colour that no light changes.
void SetUpCap(vtkActor& actor)
{
  vtkProperty* material = actor.GetProperty();
  material->SetColor(capColor[0] / 255.0, capColor[1] / 255.0, capColor[2] / 255.0);
  material->SetAmbient(1.0);
  material->SetDiffuse(0.0);
  material->SetSpecular(0.0);
}

void SetUpBackground(vtkRenderer& renderer)
{
  renderer.GradientBackgroundOn();
  renderer.SetBackground(backgroundBottom.data());
  renderer.SetBackground2(backgroundTop.data());
}

}

SurfaceScene::SurfaceScene()
  : Occlusion(std::make_unique<SceneOcclusion>())
{
  this->SceneRenderer->AutomaticLightCreationOff();
  for (std::size_t i = 0; i < this->Lamps.size(); ++i)
  {
    this->Lamps[i] = AddLamp(*this->SceneRenderer, this->Lighting.lamps[i]);
  }
  SetUpBackground(*this->SceneRenderer);
  const vtkNew<vtkCamera> camera;
  this->SceneRenderer->SetActiveCamera(camera);
  this->ApplyCamera();
  // Just before drawing, when the size of the window is known.
  this->PictureObserver =
    this->SceneRenderer->AddObserver(vtkCommand::StartEvent, this, &SurfaceScene::BeforePicture);
  this->OcclusionObserver =
    this->SceneRenderer->AddObserver(vtkCommand::EndEvent, this, &SurfaceScene::ApplyOcclusion);
}

// The renderer lives on in a window that lives on.
SurfaceScene::~SurfaceScene()
{
  this->SceneRenderer->RemoveObserver(this->PictureObserver);
  this->SceneRenderer->RemoveObserver(this->OcclusionObserver);
}

Status SurfaceScene::Update(const Surface& surface, const TreeDepths& depths, const Vec3& center)
{
  KDSTREAM_TRY(CheckSurface(surface, center));
  this->Depths = depths;
  this->Center = center;
  std::vector<Entry> whole(1);
  const bool hasOne = this->Entries.size() == 1;
  whole.front().scene =
    hasOne ? std::move(this->Entries.front().scene) : std::make_unique<ScenePart>();
  whole.front().scene->Show(surface, NormalsOf(surface), depths, center, this->Style);
  this->Take(std::move(whole));
  this->Facet = FacetLength(surface);
  return {};
}

Status SurfaceScene::Update(const DrawnSurface& surface, const TreeDepths& depths,
  const Vec3& center, const std::shared_ptr<const TileList>& tiles)
{
  const bool isPainted = this->Decoder && tiles && !tiles->empty();
  if (surface.TriangleCount() == 0 || (surface.Parts().size() > mostParts && !isPainted))
  {
    KDSTREAM_TRY(this->Update(surface.Whole(), depths, center));
    this->Facet = FacetLength(surface);
    return {};
  }
  std::map<const SurfacePart*, Entry*> before;
  for (Entry& entry : this->Entries)
  {
    if (entry.drawn.part && depths == this->Depths && center == this->Center)
    {
      before[entry.drawn.part.get()] = &entry;
    }
  }
  std::vector<DrawnSurface::Part> parts = surface.Parts();
  std::erase_if(
    parts, [](const DrawnSurface::Part& part) { return part.part->surface.triangles.empty(); });
  for (const DrawnSurface::Part& part : parts)
  {
    if (before.count(part.part.get()) == 0)
    {
      KDSTREAM_TRY(CheckSurface(part.part->surface, center));
    }
  }
  this->Depths = depths;
  this->Center = center;
  std::vector<Entry> entries(parts.size());
  for (std::size_t i = 0; i < parts.size(); ++i)
  {
    entries[i].drawn = parts[i];
    entries[i].tile = isPainted ? FindTile(*tiles, parts[i].part->piece) : nullptr;
    const auto known = before.find(parts[i].part.get());
    if (known != before.end())
    {
      entries[i].scene = std::move(known->second->scene);
      entries[i].isShown =
        known->second->drawn.LooksLike(parts[i]) && known->second->tile == entries[i].tile;
    }
  }
  // What is not needed any more makes room for what is new.
  auto spare = this->Entries.begin();
  for (Entry& entry : entries)
  {
    if (!entry.scene)
    {
      spare = std::find_if(
        spare, this->Entries.end(), [](const Entry& each) { return each.scene != nullptr; });
      entry.scene =
        spare == this->Entries.end() ? std::make_unique<ScenePart>() : std::move(spare->scene);
    }
    if (!std::exchange(entry.isShown, true))
    {
      const SurfacePart& part = *entry.drawn.part;
      const UnitNormals normals = UnitNormalsOf(*entry.drawn.normals);
      if (!entry.tile || !entry.scene->ShowPainted(part, normals, depths, center, this->Style,
                           { entry.tile, this->Decoder }))
      {
        entry.scene->Show(part.surface, normals, depths, center, this->Style);
      }
    }
  }
  this->Take(std::move(entries));
  this->Facet = FacetLength(surface);
  return {};
}

// Draws these from now on; of those before, what has not been moved into them is let go.
void SurfaceScene::Take(std::vector<Entry> entries)
{
  for (const Entry& entry : this->Entries)
  {
    if (entry.scene)
    {
      this->SceneRenderer->RemoveActor(&entry.scene->Actor());
    }
  }
  this->Entries = std::move(entries);
  this->Bounds = {};
  for (const Entry& entry : this->Entries)
  {
    this->SceneRenderer->AddActor(&entry.scene->Actor()); // no second time where it is there
    this->Bounds.Add(entry.scene->Bounds());
  }
  this->ApplyCamera();
}

void SurfaceScene::SetStyle(const SceneStyle& style)
{
  const SceneStyle before = std::exchange(this->Style, style);
  if (style.coloring == before.coloring && style.flat == before.flat)
  {
    return;
  }
  for (const Entry& entry : this->Entries)
  {
    entry.scene->SetStyle(style);
  }
}

void SurfaceScene::SetLighting(const SceneLighting& lighting)
{
  if (lighting == this->Lighting)
  {
    return;
  }
  this->Lighting = lighting;
  for (std::size_t i = 0; i < this->Lamps.size(); ++i)
  {
    Shine(*this->Lamps[i], lighting.lamps[i]);
  }
}

void SurfaceScene::SetSection(const std::optional<SectionPlane>& plane,
  const std::shared_ptr<const Surface>& cap, std::uint64_t capVersion)
{
  const bool hasNew = capVersion != this->CapVersion || cap != this->Cap;
  this->CapVersion = capVersion;
  this->Cap = cap;
  this->Section = plane;
  if (hasNew)
  {
    this->PlaceCap();
  }
}

// Draws the cap anew.
void SurfaceScene::PlaceCap()
{
  const bool hasOne = this->Cap && !this->Cap->triangles.empty();
  if (hasOne && !this->CapDrawn)
  {
    this->CapDrawn = std::make_unique<ScenePart>();
    SetUpCap(this->CapDrawn->Actor());
  }
  if (hasOne)
  {
    this->CapDrawn->Show(
      *this->Cap, {}, this->Depths, this->Center, { SurfaceColoring::Stone, true, false });
    this->SceneRenderer->AddActor(&this->CapDrawn->Actor());
  }
  else if (this->CapDrawn)
  {
    this->SceneRenderer->RemoveActor(&this->CapDrawn->Actor());
  }
}

void SurfaceScene::BeforePicture()
{
  const double* range = this->SceneRenderer->GetActiveCamera()->GetClippingRange();
  const double tangent = std::tan(0.5 * this->Camera.verticalFieldOfView);
  for (const Entry& entry : this->Entries)
  {
    const int height = this->SceneRenderer->GetSize()[1];
    entry.scene->AimSplats({ range[0], range[1] }, tangent, height);
    entry.scene->CutBy(this->Section, this->Center);
    entry.scene->RaiseRelief(this->Lighting.relief, reliefShare * height);
  }
}

void SurfaceScene::ApplyOcclusion()
{
  if (this->Style.occlusion && !this->Entries.empty())
  {
    this->Occlusion->Darken(*this->SceneRenderer, this->Facet);
  }
}

Status SurfaceScene::SetCamera(const SceneCamera& camera)
{
  KDSTREAM_TRY(CheckCamera(camera));
  this->Camera = camera;
  this->ApplyCamera();
  return {};
}

void SurfaceScene::ApplyCamera()
{
  const Vec3 eye = this->Camera.eye - this->Center;
  const Vec3 focal = this->Camera.focal - this->Center;
  vtkCamera* camera = this->SceneRenderer->GetActiveCamera();
  camera->SetPosition(eye.data());
  camera->SetFocalPoint(focal.data());
  camera->SetViewUp(this->Camera.up.data());
  camera->SetViewAngle(this->Camera.verticalFieldOfView * 180.0 / std::numbers::pi);
  const ClippingPlanes planes = PlanesAround(this->Bounds, eye, focal);
  camera->SetClippingRange(planes.nearest, planes.farthest);
}

}
