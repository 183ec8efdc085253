// SPDX-License-Identifier: BSD-3-Clause
// Draws one surface in a VTK renderer: see SurfaceScene.h.
#include "viewer/rendering/SurfaceScene.h"

#include "viewer/rendering/CloudSplats.h"
#include "viewer/session/Geometry.h"
#include "viewer/session/SceneLook.h"
#include "viewer/session/SplatRadii.h"

#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCommand.h>
#include <vtkFloatArray.h>
#include <vtkLight.h>
#include <vtkOpenGLPolyDataMapper.h>
#include <vtkOpenGLVertexBufferObject.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkShaderProperty.h>
#include <vtkSmartPointer.h>
#include <vtkTypeInt32Array.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

namespace kdstream
{
namespace
{

vtkSmartPointer<vtkPoints> RelativePoints(std::span<const Vec3> points, const Vec3& center)
{
  const vtkNew<vtkFloatArray> coordinates;
  coordinates->SetNumberOfComponents(3);
  coordinates->SetNumberOfTuples(static_cast<vtkIdType>(points.size()));
  float* out = coordinates->GetPointer(0);
  for (const Vec3& point : points)
  {
    out = std::transform(point.begin(), point.end(), center.begin(), out,
      [](double p, double c) { return static_cast<float>(p - c); });
  }
  auto result = vtkSmartPointer<vtkPoints>::New();
  result->SetData(coordinates);
  return result;
}

// Cells of `size` corners each, whose corners are given by corner(0 … count × size - 1).
template <class Corner>
vtkSmartPointer<vtkCellArray> Cells(std::size_t count, std::size_t size, const Corner& corner)
{
  const vtkNew<vtkTypeInt32Array> offsets;
  const vtkNew<vtkTypeInt32Array> corners;
  const std::size_t all = count * size;
  offsets->SetNumberOfValues(static_cast<vtkIdType>(count) + 1);
  corners->SetNumberOfValues(static_cast<vtkIdType>(all));
  for (std::size_t i = 0; i <= count; ++i)
  {
    offsets->SetValue(static_cast<vtkIdType>(i), static_cast<vtkTypeInt32>(i * size));
  }
  for (std::size_t i = 0; i < all; ++i)
  {
    corners->SetValue(static_cast<vtkIdType>(i), static_cast<vtkTypeInt32>(corner(i)));
  }
  auto cells = vtkSmartPointer<vtkCellArray>::New();
  cells->SetData(offsets, corners);
  return cells;
}

// Lights every fragment of a surface on the side that is seen. VTK turns the normal by the
// triangle's own facing, which is undone: a triangle that a simplified level has folded over would
// be black among neighbours whose normals face the eye. At an outline, normals between those of
// corners turn away a little where the triangle itself still faces the eye: these stop at the
// outline; turned to the eye they would shine like the other side.
void FaceNormalsToTheEye(vtkActor& actor)
{
  actor.GetShaderProperty()->AddFragmentShaderReplacement("//VTK::Light::Impl", true,
    "if (!gl_FrontFacing) { normalVCVSOutput = -normalVCVSOutput; }\n"
    "if (normalVCVSOutput.z < 0.0)\n"
    "{\n"
    "  normalVCVSOutput = gl_FrontFacing && normalVCVSOutput.z > -0.4\n"
    "    ? normalize(vec3(normalVCVSOutput.xy, 0.0)) : -normalVCVSOutput;\n"
    "}\n"
    "//VTK::Light::Impl",
    false);
}

vtkSmartPointer<vtkFloatArray> Normals(const Surface& surface)
{
  auto result = vtkSmartPointer<vtkFloatArray>::New();
  result->SetName("Normals");
  result->SetNumberOfComponents(3);
  result->SetNumberOfTuples(static_cast<vtkIdType>(surface.points.size()));
  result->FillValue(0.0f); // none: VTK lights no points without
  float* out = result->GetPointer(0);
  for (const auto& normal : NormalsOf(surface))
  {
    out = std::copy(normal.begin(), normal.end(), out);
  }
  return result;
}

vtkSmartPointer<vtkFloatArray> Radii(const Surface& cloud)
{
  const std::vector<float> radii = SplatRadii(cloud);
  auto result = vtkSmartPointer<vtkFloatArray>::New();
  result->SetName(splatRadiusArray);
  result->SetNumberOfTuples(static_cast<vtkIdType>(radii.size()));
  std::copy(radii.begin(), radii.end(), result->GetPointer(0));
  return result;
}

// A colour for each of so many entries, given by color(0 … count - 1).
template <class ColorAt>
vtkSmartPointer<vtkUnsignedCharArray> Colors(std::size_t count, const ColorAt& colorAt)
{
  auto colors = vtkSmartPointer<vtkUnsignedCharArray>::New();
  colors->SetName("Colors");
  colors->SetNumberOfComponents(3);
  colors->SetNumberOfTuples(static_cast<vtkIdType>(count));
  unsigned char* out = colors->GetPointer(0);
  for (std::size_t i = 0; i < count; ++i)
  {
    const Color color = colorAt(i);
    out = std::copy(color.begin(), color.end(), out);
  }
  return colors;
}

void SetUpLights(vtkRenderer& renderer)
{
  renderer.AutomaticLightCreationOff();
  for (const SceneLight& each : sceneLights)
  {
    const vtkNew<vtkLight> light;
    light->SetLightTypeToCameraLight();
    light->SetPositional(0);
    light->SetPosition(each.position.data());
    light->SetFocalPoint(0.0, 0.0, 0.0);
    light->SetColor(each.color.data());
    light->SetIntensity(each.intensity);
    renderer.AddLight(light);
  }
}

void SetUpBackground(vtkRenderer& renderer)
{
  renderer.GradientBackgroundOn();
  renderer.SetBackground(backgroundBottom.data());
  renderer.SetBackground2(backgroundTop.data());
}

void SetUpMaterial(vtkActor& actor)
{
  vtkProperty* front = actor.GetProperty();
  front->SetColor(stoneColor[0] / 255.0, stoneColor[1] / 255.0, stoneColor[2] / 255.0);
  front->SetAmbient(sceneMaterial.ambient);
  front->SetDiffuse(sceneMaterial.diffuse);
  front->SetSpecular(sceneMaterial.specular);
  front->SetSpecularPower(sceneMaterial.specularPower);
}

}

SurfaceScene::SurfaceScene()
{
  SetUpLights(*this->SceneRenderer);
  SetUpBackground(*this->SceneRenderer);
  SetUpMaterial(*this->Actor);
  const vtkNew<vtkCamera> camera;
  this->SceneRenderer->SetActiveCamera(camera);
  this->Mapper->SetInputData(this->Drawn);
  // The coordinates are relative already: VTK's own shifting would only move them a second time.
  if (auto* openGl = vtkOpenGLPolyDataMapper::SafeDownCast(this->Mapper))
  {
    openGl->SetVBOShiftScaleMethod(vtkOpenGLVertexBufferObject::DISABLE_SHIFT_SCALE);
  }
  this->Actor->SetMapper(this->Mapper);
  this->SceneRenderer->AddActor(this->Actor);
  this->SetStyle(SceneStyle{});
  this->ApplyCamera();
  // Just before drawing, when the size of the window is known.
  this->SplatObserver =
    this->SceneRenderer->AddObserver(vtkCommand::StartEvent, this, &SurfaceScene::ApplySplats);
}

// The renderer lives on in a window that lives on.
SurfaceScene::~SurfaceScene()
{
  this->SceneRenderer->RemoveObserver(this->SplatObserver);
}

Status SurfaceScene::Update(const Surface& surface, const TreeDepths& depths, const Vec3& center)
{
  KDSTREAM_TRY(CheckSurface(surface, center));
  this->Center = center;
  this->Bounds = BoundsAround(surface, center);

  const bool isCloud = surface.triangles.empty();
  const std::size_t cells = isCloud ? surface.points.size() : surface.triangles.size();
  this->Drawn->Initialize();
  this->Drawn->SetPoints(RelativePoints(surface.points, center));
  if (isCloud)
  {
    this->Drawn->SetVerts(Cells(cells, 1, [](std::size_t i) { return i; }));
    const auto radii = Radii(surface);
    this->Drawn->GetPointData()->AddArray(radii);
    this->LargestRadius = cells > 0 ? radii->GetRange()[1] : 0.0;
    this->Bounds = Enlarged(this->Bounds, this->LargestRadius);
  }
  else
  {
    this->Drawn->SetPolys(
      Cells(cells, 3, [&](std::size_t i) { return surface.triangles[i / 3][i % 3]; }));
    this->LargestRadius = 0.0;
  }
  this->Drawn->GetPointData()->SetNormals(Normals(surface));
  if (const Attribute* own = OwnColors(surface))
  {
    this->PointColors =
      Colors(surface.points.size(), [own](std::size_t i) { return OwnColor(*own, i); });
  }
  else
  {
    this->PointColors = nullptr;
  }

  this->CellColors.clear();
  this->CellColors.reserve(cells);
  for (std::size_t i = 0; i < cells; ++i)
  {
    const auto of = [&](VertexId v) { return ColorSourceOf(surface.sources[v], depths); };
    if (isCloud)
    {
      this->CellColors.push_back(of(static_cast<VertexId>(i)));
      continue;
    }
    const Triangle& t = surface.triangles[i];
    this->CellColors.push_back(Together(Together(of(t[0]), of(t[1])), of(t[2])));
  }
  DrawNoSplats(*this->Actor, *this->Mapper);
  if (isCloud)
  {
    DrawSplats(*this->Actor, *this->Mapper);
  }
  else
  {
    FaceNormalsToTheEye(*this->Actor);
  }
  this->IsCloud = isCloud;
  this->ApplyStyle();
  this->ApplyCamera();
  return {};
}

void SurfaceScene::SetStyle(const SceneStyle& style)
{
  this->Style = style;
  this->ApplyStyle();
}

void SurfaceScene::ApplyStyle()
{
  if (this->Style.flat && !this->IsCloud)
  {
    this->Actor->GetProperty()->SetInterpolationToFlat();
  }
  else
  {
    this->Actor->GetProperty()->SetInterpolationToPhong();
  }
  this->ApplyColors();
}

void SurfaceScene::ApplySplats()
{
  if (this->IsCloud)
  {
    const double* range = this->SceneRenderer->GetActiveCamera()->GetClippingRange();
    AimSplats(*this->Actor, { range[0], range[1] }, this->LargestRadius,
      std::tan(0.5 * this->Camera.verticalFieldOfView), this->SceneRenderer->GetSize()[1]);
  }
}

void SurfaceScene::ApplyColors()
{
  const SurfaceColoring coloring = this->Style.coloring;
  const bool own = coloring == SurfaceColoring::Own && this->PointColors;
  const bool bySource =
    coloring == SurfaceColoring::Partition || coloring == SurfaceColoring::Resolution;
  this->Mapper->SetScalarVisibility(own || bySource);
  this->Drawn->GetPointData()->SetScalars(own ? this->PointColors.Get() : nullptr);
  this->Drawn->GetCellData()->SetScalars(bySource
                                           ? Colors(this->CellColors.size(), [&](std::size_t i)
                                               { return ColorOf(this->CellColors[i], coloring); })
                                               .Get()
                                           : nullptr);
  if (own)
  {
    this->Mapper->SetScalarModeToUsePointData();
  }
  else
  {
    this->Mapper->SetScalarModeToUseCellData();
  }
  this->Mapper->SetColorModeToDirectScalars();
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
