// Draws one surface in a VTK renderer: see SurfaceScene.h.
#include "viewer/rendering/SurfaceScene.h"

#include "viewer/rendering/CloudShading.h"
#include "viewer/session/Palette.h"
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
#include <limits>
#include <numbers>
#include <span>
#include <string>

namespace kdstream
{
namespace
{

Vec3 Minus(const Vec3& a, const Vec3& b)
{
  return { a[0] - b[0], a[1] - b[1], a[2] - b[2] };
}

double Dot(const Vec3& a, const Vec3& b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

bool IsFinite(const Vec3& v)
{
  return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}

// What can be wrong with a surface, found before anything is replaced.
Status CheckSurface(const Surface& surface, const Vec3& center)
{
  constexpr std::size_t limit = std::numeric_limits<std::int32_t>::max();
  if (surface.points.size() > limit || surface.triangles.size() > limit / 3)
  {
    return Error{ ErrorCode::LimitExceeded,
      "a surface of " + std::to_string(surface.points.size()) + " points and " +
        std::to_string(surface.triangles.size()) + " triangles is too large to draw" };
  }
  if (surface.sources.size() != surface.points.size())
  {
    return Error{ ErrorCode::InvalidInput, std::to_string(surface.sources.size()) +
                                             " sources for " +
                                             std::to_string(surface.points.size()) + " points" };
  }
  for (std::size_t i = 0; i < surface.points.size(); ++i)
  {
    for (const double difference : Minus(surface.points[i], center))
    {
      if (!(std::abs(difference) <= static_cast<double>(std::numeric_limits<float>::max())))
      {
        return Error{ ErrorCode::InvalidInput,
          "point " + std::to_string(i) + " cannot be drawn: a coordinate is not finite" };
      }
    }
  }
  for (std::size_t i = 0; i < surface.triangles.size(); ++i)
  {
    const Triangle& t = surface.triangles[i];
    if (std::max({ t[0], t[1], t[2] }) >= surface.points.size())
    {
      return Error{ ErrorCode::InvalidInput,
        "triangle " + std::to_string(i) + " has a vertex that does not exist" };
    }
  }
  return {};
}

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
// triangle's own facing: a triangle that a simplified level has folded over would be black among
// neighbours whose normals face the eye. Points have no normals.
void FaceNormalsToTheEye(vtkActor& actor, bool isSurface)
{
  vtkShaderProperty* shader = actor.GetShaderProperty();
  shader->ClearFragmentShaderReplacement("//VTK::Light::Impl", true);
  if (isSurface)
  {
    shader->AddFragmentShaderReplacement("//VTK::Light::Impl", true,
      "if (normalVCVSOutput.z < 0.0) { normalVCVSOutput = -normalVCVSOutput; }\n"
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

// The partition of a vertex; none below the stitch depth, where clusters span several.
std::optional<std::uint32_t> PartitionOf(const Surface::Source& source, const TreeDepths& depths)
{
  const bool inOne = source.resolution.IsOriginal() || source.resolution.Depth() >= depths.stitch;
  return inOne ? std::optional(PartitionOfKey(source.key)) : std::nullopt;
}

void AddLight(vtkRenderer& renderer, const Vec3& position, const Vec3& color, double intensity)
{
  const vtkNew<vtkLight> light;
  light->SetLightTypeToCameraLight();
  light->SetPositional(0);
  light->SetPosition(position[0], position[1], position[2]);
  light->SetFocalPoint(0.0, 0.0, 0.0);
  light->SetColor(color[0], color[1], color[2]);
  light->SetIntensity(intensity);
  renderer.AddLight(light);
}

// In the camera's coordinates: x to the right, y up, z to the viewer.
void SetUpLights(vtkRenderer& renderer)
{
  renderer.AutomaticLightCreationOff();
  AddLight(renderer, { -0.7, 0.9, 0.8 }, { 1.0, 0.98, 0.94 }, 0.95);
  AddLight(renderer, { 1.0, 0.1, 0.6 }, { 0.84, 0.91, 1.0 }, 0.3);
  AddLight(renderer, { 0.0, 0.0, 1.0 }, { 1.0, 1.0, 1.0 }, 0.12);
}

void SetUpBackground(vtkRenderer& renderer)
{
  renderer.GradientBackgroundOn();
  renderer.SetBackground(0.36, 0.37, 0.39);  // bottom
  renderer.SetBackground2(0.13, 0.14, 0.16); // top
}

void SetUpMaterial(vtkActor& actor)
{
  vtkProperty* front = actor.GetProperty();
  front->SetColor(stoneColor[0] / 255.0, stoneColor[1] / 255.0, stoneColor[2] / 255.0);
  front->SetAmbient(0.06);
  front->SetDiffuse(0.88);
  front->SetSpecular(0.14);
  front->SetSpecularPower(30.0);
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
  this->Bounds = Box{};
  for (const Vec3& point : surface.points)
  {
    this->Bounds.Add(Minus(point, center));
  }

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

  // A triangle across a border is of the lowest partition, its owner, and of the finest resolution
  // that it touches.
  this->CellPartitions.assign(cells, std::nullopt);
  this->CellResolutions.assign(cells, Resolution{});
  for (std::size_t i = 0; i < cells; ++i)
  {
    const auto vertex = static_cast<VertexId>(i);
    for (const VertexId v : isCloud ? Triangle{ vertex, vertex, vertex } : surface.triangles[i])
    {
      const Surface::Source& source = surface.sources[v];
      const std::optional<std::uint32_t> partition = PartitionOf(source, depths);
      std::optional<std::uint32_t>& lowest = this->CellPartitions[i];
      lowest = lowest && partition ? std::min(*lowest, *partition) : (lowest ? lowest : partition);
      this->CellResolutions[i] = std::max(this->CellResolutions[i], source.resolution);
    }
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

// The distance of points spread evenly over half the surface of their box (a terrain fills that of
// its box, a ball that of its own nearly), as it is seen in the middle of the box.
void SurfaceScene::ApplyPointSize()
{
  float pixels = this->Style.pointSize;
  if (pixels <= 0.0f && !this->Bounds.Empty())
  {
    const Vec3 s = Minus(this->Bounds.hi, this->Bounds.lo);
    const double area = s[0] * s[1] + s[1] * s[2] + s[2] * s[0];
    const double spacing = std::sqrt(area / static_cast<double>(this->CellResolutions.size()));
    const double* range = this->SceneRenderer->GetActiveCamera()->GetClippingRange();
    const double distance = 0.5 * (range[0] + range[1]);
    const double visible = 2.0 * distance * std::tan(0.5 * this->Camera.verticalFieldOfView);
    const double height = this->SceneRenderer->GetSize()[1];
    // Half as much again, since they are not spread evenly.
    pixels = static_cast<float>(std::clamp(1.5 * spacing * height / visible, 4.0, 32.0));
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
  colors->SetNumberOfTuples(static_cast<vtkIdType>(this->CellPartitions.size()));
  unsigned char* out = colors->GetPointer(0);
  for (std::size_t i = 0; i < this->CellPartitions.size(); ++i)
  {
    Color color = stoneColor;
    if (this->Style.coloring == SurfaceColoring::Resolution)
    {
      color = ResolutionColor(this->CellResolutions[i]);
    }
    else if (this->CellPartitions[i])
    {
      color = PartitionColor(*this->CellPartitions[i]);
    }
    out = std::copy(color.begin(), color.end(), out);
  }
  this->Drawn->GetCellData()->SetScalars(colors);
  this->Mapper->SetScalarModeToUseCellData();
  this->Mapper->SetColorModeToDirectScalars();
}

Status SurfaceScene::SetCamera(const SceneCamera& camera)
{
  const Vec3 sight = Minus(camera.focal, camera.eye);
  if (!IsFinite(camera.eye) || !IsFinite(camera.focal) || !IsFinite(camera.up) || !IsFinite(sight))
  {
    return Error{ ErrorCode::InvalidArgument, "camera: a coordinate is not finite" };
  }
  if (Dot(sight, sight) == 0.0)
  {
    return Error{ ErrorCode::InvalidArgument, "camera: the eye is at the focal point" };
  }
  const double along = Dot(sight, camera.up);
  constexpr double parallel = 1.0 - 1e-12; // squared cosine of 1 µrad
  if (!(along * along < parallel * Dot(sight, sight) * Dot(camera.up, camera.up)))
  {
    return Error{ ErrorCode::InvalidArgument, "camera: up is zero or along the line of sight" };
  }
  if (!(camera.verticalFieldOfView > 0.0 && camera.verticalFieldOfView < std::numbers::pi))
  {
    return Error{ ErrorCode::InvalidArgument, "camera: a field of view of " +
                                                std::to_string(camera.verticalFieldOfView) +
                                                " radians is not between 0 and pi" };
  }
  this->Camera = camera;
  this->ApplyCamera();
  return {};
}

void SurfaceScene::ApplyCamera()
{
  const Vec3 eye = Minus(this->Camera.eye, this->Center);
  const Vec3 focal = Minus(this->Camera.focal, this->Center);
  vtkCamera* camera = this->SceneRenderer->GetActiveCamera();
  camera->SetPosition(eye.data());
  camera->SetFocalPoint(focal.data());
  camera->SetViewUp(this->Camera.up.data());
  camera->SetViewAngle(this->Camera.verticalFieldOfView * 180.0 / std::numbers::pi);

  // The box's extent along the line of sight: its center's, and half its sides' projected.
  const Vec3 sight = Minus(focal, eye);
  const double distance = std::sqrt(Dot(sight, sight));
  double nearest = distance;
  double farthest = distance;
  if (!this->Bounds.Empty())
  {
    double middle = 0.0;
    double reach = 0.0;
    for (std::size_t k = 0; k < 3; ++k)
    {
      const double half = 0.5 * (this->Bounds.hi[k] - this->Bounds.lo[k]);
      middle += (this->Bounds.lo[k] + half - eye[k]) * sight[k] / distance;
      reach += half * std::abs(sight[k]) / distance;
    }
    nearest = middle - reach;
    farthest = middle + reach;
  }
  // A margin for rounding; and where the eye is inside the box, a near plane that leaves the 24
  // bits of the depth buffer enough to tell surfaces apart.
  const double margin = 0.01 * (farthest - nearest) + 1e-6 * distance;
  const double farPlane = std::max(farthest + margin, distance * 1e-3);
  const double nearPlane = std::max(nearest - margin, farPlane * 1e-4);
  camera->SetClippingRange(nearPlane, farPlane);
}

}
