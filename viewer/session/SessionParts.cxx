// SPDX-License-Identifier: BSD-3-Clause
// The parts of a session, and how they are connected: see SessionParts.h.
#include "viewer/session/SessionParts.h"

#include <utility>

namespace kdstream
{

void SessionOptions::TakeShares(const MemoryShares& shares)
{
  this->refinement.triangles = shares.triangles;
  this->refinement.bytes = shares.viewBytes;
  this->policy.triangleBudget = shares.levelTriangles;
  this->cacheBytes = shares.cacheBytes;
  this->treeBytes = shares.treeBytes;
  this->pictureBytes = shares.pictureBytes;
  this->region.triangles = shares.regionTriangles;
}

SessionParts::SessionParts(SessionOptions chosen)
  : options(std::move(chosen))
  , model(this->options.cacheBytes, this->options.pictureBytes)
  , lod(this->model, this->options)
  , region(
      this->model, this->options.rings, this->options.region, this->options.refinement.triangles)
  , camera(this->model, this->options.turning, this->options.coasts)
  , tools(this->model)
  , fetcher(this->model, this->lod, this->region, this->options.prefetchBytes, this->options.clock,
      this->options.mostStatistics)
{
}

LodSelection::View SessionParts::View() const
{
  LodSelection::View view{ this->camera.Get(), this->mode == ViewerMode::FullScreen,
    this->previewsOnly };
  if (this->tools.Measuring().Waits())
  {
    this->tools.Measuring().AddTo(view.tapped);
  }
  if (this->region.IsShown())
  {
    this->region.AddTo(view.tapped);
  }
  view.region = this->region.Key();
  return view;
}

void SessionParts::Update()
{
  for (bool goesOn = this->model.open.has_value(); goesOn;)
  {
    if (this->region.IsPicking() && !this->previewsOnly && this->region.Follow(this->lod.ByView()))
    {
      this->fetcher.GiveWayToTap(); // the tap's requests go first
    }
    if (this->tools.Measuring().Waits())
    {
      this->tools.Measuring().FollowTree();
    }
    if (this->lod.ByView() && this->region.HasEarlier())
    {
      this->region.ForgetEarlier(this->camera.Get());
    }
    goesOn = this->fetcher.Update(this->View());
  }
}

void SessionParts::FollowZoom()
{
  const double scale = this->camera.Get().FocalPointsPerUnit();
  if (this->mode == ViewerMode::FullScreen)
  {
    this->lod.FollowZoom(scale);
  }
  this->region.FollowZoom(scale);
}

void SessionParts::Select(const std::string& id)
{
  this->model.Select(id);
  this->fetcher.Select(id);
  this->lod.Reset();
  this->region.LetGo();
  this->camera.Reset();
  this->tools.Reset();
  this->followed.reset();
  this->mode = ViewerMode::Browsing;
}

void SessionParts::Handle(const Gesture& gesture, double time)
{
  using Kind = Gesture::Kind;
  const bool taps = gesture.kind == Kind::DoubleTap, pinches = gesture.kind == Kind::Pinch;
  const bool browses = this->mode != ViewerMode::FullScreen;
  const bool mayTake = this->tools.InHand() != Tool::None && (!browses || pinches);
  const bool isTaken = mayTake && this->tools.Take(gesture, this->camera.Get());
  if (gesture.kind == Kind::PinchBegin || (taps && !isTaken))
  {
    this->model.Retry();
  }
  if (taps && !isTaken)
  {
    this->DoubleTap(gesture);
  }
  this->camera.Handle(gesture, time, isTaken);
  if (pinches || (browses && gesture.kind == Kind::Tap))
  {
    this->mode = ViewerMode::FullScreen;
    this->FollowZoom();
  }
}

void SessionParts::DoubleTap(const Gesture& gesture)
{
  if (const auto hit = this->camera.PickUnder(gesture.x, gesture.y))
  {
    this->region.PickAt(hit->point);
    this->fetcher.GiveWayToTap();
    return;
  }
  this->region.LetGo();
  this->camera.JumpHome();
  this->FollowZoom();
}

// Applies a link to the open model.
void SessionParts::TakeLink(bool isJump)
{
  const ViewLink link = *std::exchange(this->followed, std::nullopt);
  const ModelDescription& description = this->model.open->description;
  this->camera.TakePlace(link.place, isJump);
  this->tools.TakeFrom(link, this->camera.Get());
  const NodeId firstCell = NodeId{ 1 } << description.depths.partition;
  if (link.region && link.region->cell >= firstCell &&
      link.region->cell - firstCell < description.partitions && description.HasLevels())
  {
    this->region.SetRings(link.region->rings);
    this->region.PickCell(link.region->cell);
  }
  if (description.digest.compare(0, link.digest.size(), link.digest) != 0)
  {
    this->model.failed.Report(
      "This link was made with another version of " + this->model.id + ": its view may not fit.");
  }
}

ViewerScene SessionParts::Scene() const
{
  const Camera& eye = this->camera.Get();
  ViewerScene scene;
  scene.surface = this->model.surface.GetSurface();
  scene.surfaceVersion = this->model.surface.Version();
  if (this->model.open)
  {
    scene.box = this->model.open->description.box;
    scene.depths = this->model.Depths();
    scene.scalars = this->model.open->description.scalars;
  }
  scene.eye = eye.Eye();
  scene.focal = eye.Focal();
  scene.up = eye.Up();
  scene.orientation = eye.Orientation();
  scene.section = this->model.section.Plane();
  scene.cap = this->model.section.Cap();
  scene.capVersion = this->model.section.CapVersion();
  scene.lighting = LightingOf(this->tools.Light());
  scene.tiles = this->model.tiles.Tiles();
  return scene;
}

ViewerStatus SessionParts::GetStatus() const
{
  const WishList::Progress& progress = this->fetcher.Wishes().GetProgress();
  ViewerStatus status;
  status.mode = this->mode;
  status.model = this->model.id;
  status.title = this->model.open ? this->model.open->description.title : "";
  this->lod.PutInto(status);
  if (this->region.IsShown())
  {
    status.region = this->region.GetStatus();
  }
  status.canUndo = this->camera.CanUndo();
  status.spinning = this->camera.Spins();
  status.coasting = this->camera.Coasts() || status.spinning;
  status.picking = this->region.IsPicking();
  status.vertices = this->model.Drawn().PointCount();
  status.triangles = this->model.Drawn().TriangleCount();
  status.blobsLoaded = progress.blobsLoaded;
  status.blobsWanted = progress.blobsWanted;
  status.bytesLoaded = progress.bytesLoaded;
  status.error = this->model.failed.Message();
  return status;
}

}
