// Draws one surface in a VTK renderer: see SurfaceScene.h.
#include "viewer/rendering/SurfaceScene.h"

#include "viewer/rendering/CloudShading.h"
#include "viewer/session/Geometry.h"
#include "viewer/session/SceneLook.h"
#include "viewer/session/VertexNormals.h"

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
#include <vtkRenderStepsPass.h>
#include <vtkRenderWindow.h>
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
  offsets->SetNumberOfValues(static_cast<vtkIdType>(count + 1));
  corners->SetNumberOfValues(static_cast<vtkIdType>(count * size));
  for (std::size_t i = 0; i <= count; ++i)
  {
    offsets->SetValue(static_cast<vtkIdType>(i), static_cast<vtkTypeInt32>(i * size));
  }
  for (std::size_t i = 0; i < count * size; ++i)
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
// outline; turned to the eye they would shine like the other side. Points have no normals.
void FaceNormalsToTheEye(vtkActor& actor, bool isSurface)
{
  vtkShaderProperty* shader = actor.GetShaderProperty();
  shader->ClearFragmentShaderReplacement("//VTK::Light::Impl", true);
  if (isSurface)
  {
    shader->AddFragmentShaderReplacement("//VTK::Light::Impl", true,
      "if (!gl_FrontFacing) { normalVCVSOutput = -normalVCVSOutput; }\n"
      "if (normalVCVSOutput.z < 0.0)\n"
      "{\n"
      "  normalVCVSOutput = gl_FrontFacing && normalVCVSOutput.z > -0.4\n"
      "    ? normalize(vec3(normalVCVSOutput.xy, 0.0)) : -normalVCVSOutput;\n"
      "}\n"
      "//VTK::Light::Impl",
      false);
  }
}

vtkSmartPointer<vtkFloatArray> Normals(const Surface& surface)
{
  auto result = vtkSmartPointer<vtkFloatArray>::New();
  result->SetName("Normals");
  result->SetNumberOfComponents(3);
  result->SetNumberOfTuples(static_cast<vtkIdType>(surface.points.size()));
  float* out = result->GetPointer(0);
  for (const auto& normal : ComputeVertexNormals(surface.points, surface.triangles))
  {
    out = std::copy(normal.begin(), normal.end(), out);
  }
  return result;
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
  const vtkNew<vtkRenderStepsPass> usual;
  this->PointShading->SetDelegatePass(usual);
  this->Actor->SetMapper(this->Mapper);
  this->SceneRenderer->AddActor(this->Actor);
  this->SetStyle(SceneStyle{});
  this->ApplyCamera();
  // Just before drawing, when the size of the window is known.
  this->PointSizeObserver =
    this->SceneRenderer->AddObserver(vtkCommand::StartEvent, this, &SurfaceScene::ApplyPointSize);
}

// The renderer lives on in a window that lives on.
SurfaceScene::~SurfaceScene()
{
  this->SceneRenderer->RemoveObserver(this->PointSizeObserver);
}

Status SurfaceScene::Update(const Surface& surface, const TreeDepths& depths, const Vec3& center)
{
  if (Status status = CheckSurface(surface, center); !status)
  {
    return status;
  }
  this->Center = center;
  this->Bounds = BoundsAround(surface, center);

  const bool isCloud = surface.triangles.empty();
  const std::size_t cells = isCloud ? surface.points.size() : surface.triangles.size();
  this->Drawn->Initialize();
  this->Drawn->SetPoints(RelativePoints(surface.points, center));
  if (isCloud)
  {
    this->Drawn->SetVerts(Cells(cells, 1, [](std::size_t i) { return i; }));
  }
  else
  {
    this->Drawn->SetPolys(
      Cells(cells, 3, [&](std::size_t i) { return surface.triangles[i / 3][i % 3]; }));
    this->Drawn->GetPointData()->SetNormals(Normals(surface));
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
  FaceNormalsToTheEye(*this->Actor, !isCloud);
  this->ShadeAsCloud(isCloud && cells > 0);
  this->ApplyColors();
  this->ApplyCamera();
  return {};
}

// Points have no normals to be lit by.
void SurfaceScene::ShadeAsCloud(bool isCloud)
{
  if (isCloud)
  {
    this->SceneRenderer->SetPass(this->PointShading);
    return;
  }
  vtkRenderWindow* window = this->SceneRenderer->GetRenderWindow();
  if (window && this->SceneRenderer->GetPass())
  {
    window->MakeCurrent();
    this->PointShading->ReleaseGraphicsResources(window);
  }
  this->SceneRenderer->SetPass(nullptr);
}

void SurfaceScene::SetStyle(const SceneStyle& style)
{
  this->Style = style;
  if (style.flat)
  {
    this->Actor->GetProperty()->SetInterpolationToFlat();
  }
  else
  {
    this->Actor->GetProperty()->SetInterpolationToPhong();
  }
  this->ApplyColors();
}

void SurfaceScene::ApplyPointSize()
{
  float pixels = this->Style.pointSize;
  if (pixels <= 0.0f && !this->Bounds.Empty())
  {
    const double* range = this->SceneRenderer->GetActiveCamera()->GetClippingRange();
    pixels = static_cast<float>(
      CloudPointSize(this->Bounds, this->CellColors.size(), { range[0], range[1] },
        std::tan(0.5 * this->Camera.verticalFieldOfView), this->SceneRenderer->GetSize()[1]));
  }
  this->Actor->GetProperty()->SetPointSize(pixels);
}

void SurfaceScene::ApplyColors()
{
  const bool colored = this->Style.coloring != SurfaceColoring::Stone;
  this->Mapper->SetScalarVisibility(colored);
  if (!colored)
  {
    this->Drawn->GetCellData()->SetScalars(nullptr);
    return;
  }
  const vtkNew<vtkUnsignedCharArray> colors;
  colors->SetName("Colors");
  colors->SetNumberOfComponents(3);
  colors->SetNumberOfTuples(static_cast<vtkIdType>(this->CellColors.size()));
  unsigned char* out = colors->GetPointer(0);
  for (const ColorSource& source : this->CellColors)
  {
    const Color color = ColorOf(source, this->Style.coloring);
    out = std::copy(color.begin(), color.end(), out);
  }
  this->Drawn->GetCellData()->SetScalars(colors);
  this->Mapper->SetScalarModeToUseCellData();
  this->Mapper->SetColorModeToDirectScalars();
}

Status SurfaceScene::SetCamera(const SceneCamera& camera)
{
  if (Status status = CheckCamera(camera); !status)
  {
    return status;
  }
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
