// SPDX-License-Identifier: BSD-3-Clause
// A model in any renderer of VTK's. Step "render" of the README's picture. How a picture is taken:
// 1. what the renderer's camera needs is asked for  2. what has come is taken in
// 3. the parts that have changed are drawn anew  4. where more is to come, a timer is set.
#include "vtkKdStreamActor.h"

#include "filters/adapter/ErrorCodes.h"
#include "filters/adapter/RangedSetters.h"
#include "viewer/actor/ActorStream.h"
#include "viewer/client/ConnectServer.h"
#include "viewer/client/LocalClient.h"
#include "viewer/session/look/SceneLook.h"

#include <vtkActor.h>
#include <vtkBoundingBox.h>
#include <vtkCamera.h>
#include <vtkCommand.h>
#include <vtkMath.h>
#include <vtkMatrix4x4.h>
#include <vtkObjectFactory.h>
#include <vtkProp3DCollection.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <utility>

vtkStandardNewMacro(vtkKdStreamActor);

KDSTREAM_SET_IN_RANGE(vtkKdStreamActor, Timeout, int, 1, 3600)
KDSTREAM_SET_IN_RANGE(vtkKdStreamActor, NumberOfTriangles, vtkIdType, 1000, VTK_INT_MAX)
KDSTREAM_SET_IN_RANGE(
  vtkKdStreamActor, MemoryLimit, vtkTypeUInt64, vtkTypeUInt64{ 16 } << 20, VTK_TYPE_UINT64_MAX)
KDSTREAM_SET_IN_RANGE(vtkKdStreamActor, Tolerance, double, 0.01, 100)
KDSTREAM_SET_IN_RANGE(vtkKdStreamActor, SecondsPerFrame, double, 0, 10)

namespace
{

using namespace kdstream;

constexpr unsigned long idleMilliseconds = 20;

Result<std::unique_ptr<ModelSource>> OpenSource(const ServerAddress& address)
{
  if (address.url.empty())
  {
    return Error{ ErrorCode::NotFound, "no Source is set" };
  }
  if (address.url.find("://") != std::string::npos)
  {
    return ConnectServer(address);
  }
  auto local = LocalClient::Open(address.url);
  KDSTREAM_TRY(local);
  return std::unique_ptr<ModelSource>(std::move(*local));
}

Vec3 Transformed(vtkMatrix4x4& matrix, const double* point, double w)
{
  const double in[4] = { point[0], point[1], point[2], w };
  double out[4];
  matrix.MultiplyPoint(in, out);
  return { out[0], out[1], out[2] };
}

// A parallel projection is that of an eye that is far away: of so many heights of the picture.
constexpr double farAway = 1e4;

// Of the renderer's camera, in the coordinates of what `placed` (world from model) places.
SceneCamera CameraOf(vtkRenderer& renderer, vtkMatrix4x4* placed)
{
  vtkCamera& camera = *renderer.GetActiveCamera();
  const int* const size = renderer.GetSize();
  double eye[3], focal[3], away[3];
  camera.GetPosition(eye);
  camera.GetFocalPoint(focal);
  camera.GetDirectionOfProjection(away);
  double tangent = std::tan(0.5 * vtkMath::RadiansFromDegrees(camera.GetViewAngle()));
  if (camera.GetUseHorizontalViewAngle() && size[0] > 0)
  {
    tangent *= static_cast<double>(size[1]) / size[0];
  }
  if (camera.GetParallelProjection())
  {
    const double distance = farAway * camera.GetParallelScale();
    tangent = 1 / farAway;
    for (int k = 0; k < 3; ++k)
    {
      eye[k] = focal[k] - distance * away[k];
    }
  }
  vtkNew<vtkMatrix4x4> inverse;
  vtkMatrix4x4::Invert(placed, inverse);
  return { Transformed(*inverse, eye, 1), Transformed(*inverse, focal, 1),
    Transformed(*inverse, camera.GetViewUp(), 0), 2 * std::atan(tangent) };
}

void SetUpStone(vtkProperty& stone)
{
  stone.SetColor(stoneColor[0] / 255.0, stoneColor[1] / 255.0, stoneColor[2] / 255.0);
  stone.SetAmbient(sceneMaterial.ambient);
  stone.SetDiffuse(sceneMaterial.diffuse);
  stone.SetSpecular(sceneMaterial.specular);
  stone.SetSpecularPower(sceneMaterial.specularPower);
}

ColorChoice ChoiceOf(const std::string& text)
{
  if (const auto told = ParseColors(text))
  {
    return *told;
  }
  ColorChoice choice;
  choice.coloring = SurfaceColoring::Attribute;
  choice.attribute = text;
  return choice;
}

}

vtkKdStreamActor::vtkKdStreamActor()
{
  SetUpStone(*this->Property);
}

vtkKdStreamActor::~vtkKdStreamActor()
{
  this->StopWaiting();
}

ServerAddress vtkKdStreamActor::Address() const
{
  return { this->Source, this->ModelId, this->Token, this->CertificateAuthorities,
    this->CacheFolder, this->CacheSize, std::chrono::seconds(this->Timeout) };
}

void vtkKdStreamActor::Close()
{
  this->StopWaiting();
  while (vtkProp* const part = this->Parts->GetLastProp())
  {
    this->RemovePart(static_cast<vtkProp3D*>(part));
  }
  this->Stream = nullptr;
}

bool vtkKdStreamActor::Open()
{
  this->Close();
  this->Tried = std::make_unique<ServerAddress>(this->Address());
  this->TriedTolerance = this->Tolerance;
  this->ErrorMessage = this->LastWarning = "";
  this->ErrorCode = vtkErrorCode::NoError;
  Status opened;
  auto source = OpenSource(*this->Tried);
  if (source)
  {
    this->Stream = std::make_unique<ActorStream>(
      std::move(*source), this->Tolerance, static_cast<std::uint64_t>(this->NumberOfTriangles),
      [this](vtkActor& actor)
      {
        const Vec3& center = this->Stream->Actors().Center();
        actor.SetPosition(center[0], center[1], center[2]);
        this->AddPart(&actor);
      },
      [this](vtkActor& actor) { this->RemovePart(&actor); });
    opened = this->Stream->Open(this->ModelId, std::chrono::seconds(this->Timeout));
  }
  else
  {
    opened = source.GetError();
  }
  if (!opened)
  {
    this->Close();
    this->ErrorMessage =
      (this->Source.empty() ? "" : this->Source + ": ") + opened.GetError().message;
    this->ErrorCode = this->Source.empty()
                        ? static_cast<unsigned long>(vtkErrorCode::NoFileNameError)
                        : VtkErrorCodeOf(opened.GetError());
    vtkErrorMacro(<< this->ErrorMessage);
  }
  this->Modified();
  return this->Stream != nullptr;
}

// What could not be opened is not tried anew before something else is set.
bool vtkKdStreamActor::IsOpen()
{
  const bool isTried = this->Tried && *this->Tried == this->Address();
  if (!isTried || this->TriedTolerance != this->Tolerance)
  {
    this->Open();
  }
  return this->Stream != nullptr;
}

std::string vtkKdStreamActor::GetErrorMessage() const
{
  return this->ErrorMessage;
}

void vtkKdStreamActor::Look(vtkRenderer& renderer)
{
  this->Renderer = &renderer;
  if (!renderer.IsActiveCameraCreated())
  {
    renderer.ResetCamera(); // as the first picture would
  }
  this->Stream->SetBudgets(static_cast<std::uint64_t>(this->NumberOfTriangles),
    static_cast<std::size_t>(this->MemoryLimit));
  this->Stream->SetColors(ChoiceOf(this->ColorBy));
  this->Stream->Actors().SetMaterial(*this->Property);
  const int* const size = renderer.GetSize();
  // A camera that sees nothing needs nothing.
  (void)this->Stream->Look(
    CameraOf(renderer, this->GetMatrix()), std::max(size[0], 1), std::max(size[1], 1));
}

void vtkKdStreamActor::TakeIn(double seconds)
{
  const Status drawn = this->Stream->TakeIn(seconds);
  const std::string warning =
    drawn ? this->Stream->Viewer().GetStatus().error : drawn.GetError().message;
  if (!warning.empty() && warning != this->LastWarning)
  {
    vtkWarningMacro(<< this->Source << ": " << warning);
    this->ErrorMessage = this->Source + ": " + warning;
    this->ErrorCode = drawn ? static_cast<unsigned long>(vtkErrorCode::UnknownError)
                            : VtkErrorCodeOf(drawn.GetError());
  }
  this->LastWarning = warning;
}

// An interactor's update rate is that of its style while one moves the camera.
double vtkKdStreamActor::SecondsFor(vtkRenderer& renderer)
{
  constexpr double part = 0.1;
  const double rate = renderer.GetRenderWindow()->GetDesiredUpdateRate();
  return std::min(this->SecondsPerFrame, rate > 0 ? part / rate : this->SecondsPerFrame);
}

bool vtkKdStreamActor::IsComplete()
{
  return this->IsOpen() && this->Stream->IsComplete();
}

bool vtkKdStreamActor::Refine(vtkRenderer* renderer, double seconds)
{
  using Clock = std::chrono::steady_clock;
  if (!renderer || !this->IsOpen())
  {
    return false;
  }
  const auto end = Clock::now() + std::chrono::duration<double>(std::clamp(seconds, 0.0, 1e6));
  do
  {
    this->Look(*renderer);
    this->TakeIn(std::chrono::duration<double>(end - Clock::now()).count());
    if (this->Stream->IsComplete())
    {
      return true;
    }
    this->Stream->Wait(std::chrono::milliseconds(20));
  } while (Clock::now() < end);
  return false;
}

vtkIdType vtkKdStreamActor::GetNumberOfDrawnTriangles() const
{
  return this->Stream ? static_cast<vtkIdType>(this->Stream->Viewer().GetStatus().triangles) : 0;
}

vtkIdType vtkKdStreamActor::GetNumberOfDrawnPoints() const
{
  return this->Stream ? static_cast<vtkIdType>(this->Stream->Viewer().GetStatus().vertices) : 0;
}

vtkTypeUInt64 vtkKdStreamActor::GetNumberOfReceivedBytes() const
{
  return this->Stream ? this->Stream->Viewer().GetTraffic().bytes : 0;
}

double* vtkKdStreamActor::GetBounds()
{
  vtkMath::UninitializeBounds(this->Bounds);
  if (!this->IsOpen())
  {
    return nullptr;
  }
  const kdstream::Box& box = this->Stream->ModelBox();
  vtkBoundingBox bounds;
  for (int corner = 0; corner < 8; ++corner)
  {
    std::array<double, 3> at;
    for (std::size_t k = 0; k < 3; ++k)
    {
      at[k] = (corner >> k) % 2 == 0 ? box.lo[k] : box.hi[k];
    }
    Vec3 placed = Transformed(*this->GetMatrix(), at.data(), 1);
    bounds.AddPoint(placed.data());
  }
  bounds.GetBounds(this->Bounds);
  return this->Bounds;
}

int vtkKdStreamActor::RenderOpaqueGeometry(vtkViewport* viewport)
{
  vtkRenderer* const renderer = vtkRenderer::SafeDownCast(viewport);
  if (!renderer || !this->IsOpen())
  {
    return 0;
  }
  if (!renderer->GetSelector()) // what is picked is what was seen
  {
    this->Look(*renderer);
    this->TakeIn(this->SecondsFor(*renderer));
    this->WaitForIdle(*renderer);
  }
  const double* const range = renderer->GetActiveCamera()->GetClippingRange();
  const double angle = vtkMath::RadiansFromDegrees(renderer->GetActiveCamera()->GetViewAngle());
  this->Stream->Actors().Aim(
    { { range[0], range[1] }, std::tan(0.5 * angle), renderer->GetSize()[1], {}, 0.0 });
  return this->Superclass::RenderOpaqueGeometry(viewport);
}

// A timer that fires once, and is made anew: VTK 9.1's X11 interactor must not lose one that is
// firing. So the last one goes when the next one fires.
void vtkKdStreamActor::WaitForIdle(vtkRenderer& renderer)
{
  vtkRenderWindowInteractor* const interactor = renderer.GetRenderWindow()->GetInteractor();
  if (!this->RefineWhenIdle || !interactor || this->Stream->IsComplete())
  {
    return;
  }
  if (this->Interactor != interactor)
  {
    this->StopWaiting();
    this->Interactor = interactor;
    this->TimerObserver =
      interactor->AddObserver(vtkCommand::TimerEvent, this, &vtkKdStreamActor::OnTimer);
  }
  if (this->Timer == 0)
  {
    this->Timer = interactor->CreateOneShotTimer(idleMilliseconds);
  }
}

void vtkKdStreamActor::StopWaiting()
{
  if (this->Interactor)
  {
    this->Interactor->RemoveObserver(this->TimerObserver);
    this->Interactor->DestroyTimer(this->Timer);
    this->Interactor->DestroyTimer(this->LastTimer);
  }
  this->Interactor = nullptr;
  this->Timer = this->LastTimer = 0;
}

void vtkKdStreamActor::OnTimer(vtkObject*, unsigned long, void* timer)
{
  if (!timer || *static_cast<int*>(timer) != this->Timer || this->Timer == 0)
  {
    return;
  }
  this->Interactor->DestroyTimer(this->LastTimer);
  this->LastTimer = std::exchange(this->Timer, 0);
  if (!this->Renderer || !this->Renderer->GetRenderWindow() || !this->IsOpen())
  {
    return;
  }
  if (this->Stream->HasNews())
  {
    this->Renderer->GetRenderWindow()->Render();
  }
  else
  {
    this->WaitForIdle(*this->Renderer);
  }
}

void vtkKdStreamActor::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Source: " << this->Source << "\n";
  for (const std::string& line : LinesOf(this->Address()))
  {
    os << indent << line << "\n";
  }
  os << indent << "NumberOfTriangles: " << this->NumberOfTriangles << "\n";
  os << indent << "MemoryLimit: " << this->MemoryLimit << "\n";
  os << indent << "Tolerance: " << this->Tolerance << "\n";
  os << indent << "SecondsPerFrame: " << this->SecondsPerFrame << "\n";
  os << indent << "RefineWhenIdle: " << (this->RefineWhenIdle ? "on" : "off") << "\n";
  os << indent << "ColorBy: " << this->ColorBy << "\n";
  os << indent << "ErrorMessage: " << this->ErrorMessage << "\n";
  os << indent << "ErrorCode: " << vtkErrorCode::GetStringFromErrorCode(this->ErrorCode) << "\n";
  os << indent << "Open: " << (this->Stream ? "yes" : "no") << "\n";
  os << indent << "Property:\n";
  this->Property->PrintSelf(os, indent.GetNextIndent());
}
