// SPDX-License-Identifier: BSD-3-Clause
// A model in any VTK renderer. Step "render" of the pipeline picture. How a picture is drawn:
//
// 1. request what the renderer's camera needs
// 2. take in what has arrived
// 3. draw again the parts that have changed
// 4. set a timer if more is to arrive.
#include "vtkKdStreamActor.h"

#include "filters/adapter/ErrorCodes.h"
#include "filters/adapter/RangedSetters.h"
#include "viewer/actor/ActorStream.h"
#include "viewer/actor/RendererView.h"
#include "viewer/client/ConnectServer.h"
#include "viewer/client/LocalClient.h"
#include "viewer/session/appearance/SceneAppearance.h"

#include <vtkActor.h>
#include <vtkBoundingBox.h>
#include <vtkCommand.h>
#include <vtkMath.h>
#include <vtkMatrix4x4.h>
#include <vtkObjectFactory.h>
#include <vtkOpenGLRenderer.h>
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
  if (const auto parsed = ParseColors(text))
  {
    return *parsed;
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

// If a source could not be opened, it is tried again only after a property was changed.
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

void vtkKdStreamActor::FollowCamera(vtkRenderer& renderer)
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
  // A camera that sees nothing needs no pieces.
  if (const auto view = ViewOf(renderer, *this->GetMatrix()))
  {
    (void)this->Stream->FollowCamera(view->camera, view->width, view->height);
  }
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

// While the user moves the camera, the interactor sets the desired update rate of its style.
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
  if (!(seconds >= 0))
  {
    vtkErrorMacro(<< "Refine needs 0 seconds or more, not " << seconds);
    return false;
  }
  if (!renderer || !renderer->GetRenderWindow())
  {
    vtkErrorMacro(
      << "Refine needs a renderer that is in a window: the window's size determines the detail");
    return false;
  }
  if (!this->IsOpen())
  {
    return false;
  }
  const auto end = Clock::now() + std::chrono::duration<double>(std::min(seconds, 1e6));
  do
  {
    this->FollowCamera(*renderer);
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
    double at[4] = { 0, 0, 0, 1 };
    for (std::size_t k = 0; k < 3; ++k)
    {
      at[k] = (corner >> k) % 2 == 0 ? box.lo[k] : box.hi[k];
    }
    bounds.AddPoint(this->GetMatrix()->MultiplyDoublePoint(at));
  }
  bounds.GetBounds(this->Bounds);
  return this->Bounds;
}

// Follows the camera once in each picture of a renderer, at a moment when the active camera is the
// user's. Passes may draw the actor several times in a picture, for cameras of their own, too, such
// as those of lights.
void vtkKdStreamActor::SetAllocatedRenderTime(double seconds, vtkViewport* viewport)
{
  this->Superclass::SetAllocatedRenderTime(seconds, viewport);
  vtkRenderer* const renderer = vtkRenderer::SafeDownCast(viewport);
  // A pick must use the surface that is on the screen.
  if (renderer && !renderer->GetSelector() && this->IsOpen() &&
      this->BeginsPicture(*renderer->GetRenderWindow()))
  {
    this->FollowCamera(*renderer);
    this->TakeIn(this->SecondsFor(*renderer));
    this->WaitForIdle(*renderer);
  }
}

// Returns false if the window draws another tile of a picture in which an earlier tile was drawn.
// Tiles come row by row; tiles that do not show the model are left out.
bool vtkKdStreamActor::BeginsPicture(vtkRenderWindow& window)
{
  const double* const tile = window.GetTileViewport();
  const int* const scale = window.GetTileScale();
  const std::array<double, 4> now{ double(scale[0]), double(scale[1]), tile[1], tile[0] };
  const std::array<double, 4> before = std::exchange(this->Tile, now);
  return now[0] != before[0] || now[1] != before[1] || now <= before;
}

int vtkKdStreamActor::RenderOpaqueGeometry(vtkViewport* viewport)
{
  vtkRenderer* const renderer = vtkRenderer::SafeDownCast(viewport);
  if (!renderer || !this->IsOpen())
  {
    return 0;
  }
  auto view = ViewOf(*renderer, *this->GetMatrix());
  if (!view) // splats need the view before they can be drawn
  {
    return 0;
  }
  auto* const openGl = vtkOpenGLRenderer::SafeDownCast(renderer);
  view->sight.isLit =
    this->Property->GetLighting() && (!openGl || openGl->GetLightingComplexity() > 0);
  this->Stream->Actors().Aim(view->sight);
  return this->Superclass::RenderOpaqueGeometry(viewport);
}

// Parts are never shared: the copy will open the model itself.
void vtkKdStreamActor::ShallowCopy(vtkProp* prop)
{
  if (auto* const other = vtkKdStreamActor::SafeDownCast(prop); other && other != this)
  {
    this->SetSource(other->Source);
    this->SetModelId(other->ModelId);
    this->SetToken(other->Token);
    this->SetCertificateAuthorities(other->CertificateAuthorities);
    this->SetCacheFolder(other->CacheFolder);
    this->SetCacheSize(other->CacheSize);
    this->SetTimeout(other->Timeout);
    this->SetNumberOfTriangles(other->NumberOfTriangles);
    this->SetMemoryLimit(other->MemoryLimit);
    this->SetTolerance(other->Tolerance);
    this->SetSecondsPerFrame(other->SecondsPerFrame);
    this->SetRefineWhenIdle(other->RefineWhenIdle);
    this->SetColorBy(other->ColorBy);
    this->Property->DeepCopy(other->Property);
  }
  this->vtkProp3D::ShallowCopy(prop);
}

// VTK calls this only if the actor is a part of another assembly.
void vtkKdStreamActor::BuildPaths(vtkAssemblyPaths* paths, vtkAssemblyPath* path)
{
  if (!std::exchange(this->HasReportedAssembly, true))
  {
    vtkWarningMacro(
      << "a part of another assembly is drawn but not refined: add it to the renderer itself");
  }
  this->Superclass::BuildPaths(paths, path);
}

// Makes a new timer that fires once. The old timer is removed only when the new one fires, because
// VTK 9.1's X11 interactor fails if a timer is removed while it fires.
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
