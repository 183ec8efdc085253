// SPDX-License-Identifier: BSD-3-Clause
#include "viewer/actor/ActorStream.h"

#include "viewer/client/ConnectServer.h"
#include "viewer/rendering/DecodeTile.h"

#include <cmath>
#include <utility>

namespace kdstream
{
namespace
{

using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point begin)
{
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

SessionOptions OptionsOfActor(double tolerance, std::uint64_t triangles)
{
  SessionOptions options;
  options.refinement.tolerance = tolerance;
  options.refinement.smallModel = triangles / 8; // as in kdstream-view
  options.turning = Turning::Free;
  options.mostStatistics = 0;
  return options;
}

}

ActorStream::ActorStream(std::unique_ptr<ModelSource> source, double tolerance,
  std::uint64_t triangles, SurfaceActors::Callback add, SurfaceActors::Callback remove)
  : Source(std::move(source))
  , Session(OptionsOfActor(tolerance, triangles))
  , Drawn(std::move(add), std::move(remove))
{
  this->Drawn.SetTileDecoder(DecodeTile);
  this->Session.SetModels(this->Source->Models());
}

Status ActorStream::Open(const std::string& model, std::chrono::seconds timeout)
{
  const auto name = FindModel(this->Source->Models(), model);
  KDSTREAM_TRY(name);
  KDSTREAM_TRY(this->Session.SelectModel(*name));
  auto lastNews = Clock::now();
  do
  {
    this->Send();
    if (this->Source->Wait(std::chrono::milliseconds(20)))
    {
      lastNews = Clock::now();
    }
    KDSTREAM_TRY(this->TakeIn(1));
    if (Clock::now() - lastNews > timeout)
    {
      return NothingArrived(timeout);
    }
  } while (!this->IsComplete());
  const std::string trouble = this->Session.GetStatus().error;
  if (!this->IsOpened || this->Session.GetStatus().vertices == 0)
  {
    return Error{ ErrorCode::NotFound,
      *name + " cannot be opened: " + (trouble.empty() ? "it is empty" : trouble) };
  }
  return {};
}

void ActorStream::SetBudgets(std::uint64_t triangles, std::size_t bytes)
{
  if (this->Triangles != triangles || this->Bytes != bytes)
  {
    this->Triangles = triangles;
    this->Bytes = bytes;
    this->Session.SetBudgets(triangles, bytes);
  }
}

void ActorStream::SetColors(const ColorChoice& colors)
{
  this->Colors = colors;
  this->Drawn.SetStyle({ ColoringOf(colors, this->Scalars), false, false });
}

Status ActorStream::FollowCamera(const SceneCamera& camera, int width, int height)
{
  KDSTREAM_TRY(CheckCamera(camera));
  const Viewport window{ width, height, 1 };
  if (!(this->Window == window))
  {
    this->Window = window;
    this->Session.Resize(window);
  }
  this->Session.LookFrom(
    camera.eye, camera.focal, camera.up, std::tan(0.5 * camera.verticalFieldOfView));
  this->Session.FollowView();
  this->Send();
  return {};
}

void ActorStream::TakeEvents()
{
  for (ClientEvent& event : this->Source->Take())
  {
    this->Events.push_back(std::move(event));
  }
}

void ActorStream::Send()
{
  for (const SessionRequest& request : this->Session.TakeRequests())
  {
    this->Source->Send(request);
  }
}

bool ActorStream::HasNews()
{
  this->TakeEvents();
  return !this->Events.empty() || this->ShownVersion != this->Session.Scene().surfaceVersion;
}

bool ActorStream::IsComplete() const
{
  return this->Events.empty() && this->Session.IsIdle() &&
         this->ShownVersion == this->Session.Scene().surfaceVersion;
}

Status ActorStream::TakeIn(double seconds)
{
  const auto begin = Clock::now();
  this->TakeEvents();
  while (!this->Events.empty())
  {
    const ClientEvent event = std::move(this->Events.front());
    this->Events.pop_front();
    this->IsOpened = this->IsOpened || event.kind == ClientEvent::Kind::Opened;
    Deliver(event, this->Session);
    if (SecondsSince(begin) >= seconds)
    {
      break;
    }
  }
  this->Session.BeginFrame();
  this->Send();
  const Status drawn = this->Draw();
  this->Session.EndFrame(SecondsSince(begin));
  return drawn;
}

Status ActorStream::Draw()
{
  const ViewerScene scene = this->Session.Scene();
  if (this->Scalars != scene.scalars)
  {
    this->Scalars = scene.scalars;
    this->SetColors(this->Colors);
  }
  if (this->ShownVersion != scene.surfaceVersion || this->ShownTiles != scene.tiles)
  {
    this->Extent = scene.box;
    const Vec3 middle = scene.box.Empty() ? Vec3{} : scene.box.lo * 0.5 + scene.box.hi * 0.5;
    KDSTREAM_TRY(this->Drawn.Update(*scene.surface, scene.depths, middle, scene.tiles));
    this->ShownVersion = scene.surfaceVersion;
    this->ShownTiles = scene.tiles;
  }
  return {};
}

}
