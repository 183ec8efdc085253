// SPDX-License-Identifier: BSD-3-Clause
// Draws one surface in a VTK renderer: see SurfaceScene.h.
#include "viewer/rendering/SurfaceScene.h"

#include "viewer/rendering/SceneOcclusion.h"
#include "viewer/rendering/ScenePart.h"
#include "viewer/rendering/SurfaceActors.h"
#include "viewer/session/Geometry.h"
#include "viewer/session/appearance/SceneAppearance.h"

#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCommand.h>
#include <vtkLight.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>

#include <cmath>
#include <numbers>
#include <utility>

namespace kdstream
{
namespace
{

void Shine(vtkLight& light, const SceneLight& as)
{
  light.SetPosition(as.position.data());
  light.SetColor(as.color.data());
  light.SetIntensity(as.intensity);
  light.SetSwitch(as.intensity > 0);
}

vtkSmartPointer<vtkLight> AddLightSource(vtkRenderer& renderer, const SceneLight& as)
{
  auto light = vtkSmartPointer<vtkLight>::New();
  light->SetLightTypeToCameraLight();
  light->SetPositional(0);
  light->SetFocalPoint(0.0, 0.0, 0.0);
  Shine(*light, as);
  renderer.AddLight(light);
  return light;
}

// Gives the cap a colour that does not depend on light.
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
  : Actors(std::make_unique<SurfaceActors>([this](vtkActor& actor)
      { this->SceneRenderer->AddActor(&actor); }, // does not add an actor twice
      [this](vtkActor& actor) { this->SceneRenderer->RemoveActor(&actor); }))
  , Occlusion(std::make_unique<SceneOcclusion>())
{
  this->SceneRenderer->AutomaticLightCreationOff();
  for (std::size_t i = 0; i < this->Lights.size(); ++i)
  {
    this->Lights[i] = AddLightSource(*this->SceneRenderer, this->Lighting.lights[i]);
  }
  SetUpBackground(*this->SceneRenderer);
  const vtkNew<vtkCamera> camera;
  this->SceneRenderer->SetActiveCamera(camera);
  this->ApplyCamera();
  // Called just before drawing, when the size of the window is known.
  this->PictureObserver =
    this->SceneRenderer->AddObserver(vtkCommand::StartEvent, this, &SurfaceScene::BeforePicture);
  this->OcclusionObserver =
    this->SceneRenderer->AddObserver(vtkCommand::EndEvent, this, &SurfaceScene::ApplyOcclusion);
}

// The renderer may outlive the scene, in a window.
SurfaceScene::~SurfaceScene()
{
  this->SceneRenderer->RemoveObserver(this->PictureObserver);
  this->SceneRenderer->RemoveObserver(this->OcclusionObserver);
}

Status SurfaceScene::Update(const Surface& surface, const TreeDepths& depths, const Vec3& center)
{
  KDSTREAM_TRY(this->Actors->Update(surface, depths, center));
  this->ApplyCamera();
  return {};
}

Status SurfaceScene::Update(const DrawnSurface& surface, const TreeDepths& depths,
  const Vec3& center, const std::shared_ptr<const TileList>& tiles)
{
  KDSTREAM_TRY(this->Actors->Update(surface, depths, center, tiles));
  this->ApplyCamera();
  return {};
}

void SurfaceScene::SetTileDecoder(TileDecoder decoder)
{
  this->Actors->SetTileDecoder(decoder);
}

void SurfaceScene::SetStyle(const SceneStyle& style)
{
  this->HasOcclusion = style.occlusion;
  this->Actors->SetStyle(style);
}

void SurfaceScene::SetLighting(const SceneLighting& lighting)
{
  if (lighting == this->Lighting)
  {
    return;
  }
  this->Lighting = lighting;
  for (std::size_t i = 0; i < this->Lights.size(); ++i)
  {
    Shine(*this->Lights[i], lighting.lights[i]);
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

// Draws the current cap.
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
    this->CapDrawn->Show(*this->Cap, {}, this->Actors->Depths(), this->Actors->Center(),
      { SurfaceColoring::Stone, true, false });
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
  this->Actors->Aim({ { .planes = { range[0], range[1] },
                        .tangent = std::tan(0.5 * this->Camera.verticalFieldOfView),
                        .height = this->SceneRenderer->GetSize()[1] },
    this->Section, this->Lighting.relief });
}

void SurfaceScene::ApplyOcclusion()
{
  if (this->HasOcclusion && !this->Actors->Empty())
  {
    this->Occlusion->Darken(*this->SceneRenderer, this->Actors->Facet());
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
  const Vec3 eye = this->Camera.eye - this->Actors->Center();
  const Vec3 focal = this->Camera.focal - this->Actors->Center();
  vtkCamera* camera = this->SceneRenderer->GetActiveCamera();
  camera->SetPosition(eye.data());
  camera->SetFocalPoint(focal.data());
  camera->SetViewUp(this->Camera.up.data());
  camera->SetViewAngle(this->Camera.verticalFieldOfView * 180.0 / std::numbers::pi);
  const ClippingPlanes planes = PlanesAround(this->Actors->Bounds(), eye, focal);
  camera->SetClippingRange(planes.nearest, planes.farthest);
}

}
