// SPDX-License-Identifier: BSD-3-Clause
// The one brain of all viewers: see ViewerSession.h. What a person sets and selects, and the frames
// that show it. Every input ends in Update() (SessionWish.cxx), which compares what one would like
// to see with what is loaded and with what is under way; what comes: SessionArrivals.cxx.
#include "viewer/session/ViewerSession.h"

#include <algorithm>
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
  this->mostRegionTriangles = shares.regionTriangles;
}

ViewerSession::ViewerSession(SessionOptions options)
  : Options(std::move(options))
  , Gestures(this->Options.gestures)
  , Pieces(this->Options.cacheBytes)
  , Tiles(this->Options.pictureBytes)
  , Wanted(this->Options.aheadBytes)
  , History(this->Options.mostStatistics)
{
  this->Options.rings = std::clamp(this->Options.rings, 1u, 3u);
  this->Eye.SetTurning(this->Options.turning);
}

// ---- what the person does

void ViewerSession::Resize(const Viewport& viewport)
{
  this->TakeWindow(viewport);
  this->Gestures.SetPixelRatio(this->Eye.GetViewport().pixelRatio);
  this->FollowZoom();
  this->Update();
  this->Trace("resize");
}

Status ViewerSession::SelectModel(const std::string& model)
{
  const auto listed = std::any_of(this->ModelList.begin(), this->ModelList.end(),
    [&model](const ModelSummary& summary) { return summary.id == model; });
  if (this->HasModelList && !listed)
  {
    return Error{ ErrorCode::NotFound, "the server has no model '" + model + "'" };
  }
  this->Retry();
  if (this->Mode != ViewerMode::NoModel && this->ModelId == model)
  {
    const bool failed = !this->Current && this->Wanted.Book().Empty();
    if (!failed)
    {
      this->EnterFullScreen();
      return {};
    }
  }
  this->CloseModel();
  this->ModelId = model;
  this->Mode = ViewerMode::Browsing;
  this->Wanted.Open(model);
  this->Trace("select", model);
  return {};
}

void ViewerSession::CloseModel()
{
  this->Wanted.CloseModel();
  this->Pieces.Clear();
  this->Shown.Reset({});
  this->Tiles.Reset({}, 0);
  this->Current.reset();
  this->Region.reset();
  this->EarlierTaps.clear();
  this->NeverShown.clear(); // and never will be
  this->DropPick();
  this->MissingTree.clear();
  this->ChoiceIsDue = false;
  this->LastSituation.reset();
  this->History.CloseModel();
  this->EyeMoved = this->IsLed = false;
  this->EarlierViews.clear();
  this->Turned = {};
  this->Followed.reset();
  this->Told.reset();
  this->Left.reset();
  this->Measured.clear();
  this->Ends.clear();
  this->MeasurementsMade = 0;
  this->Section.Reset({});
  this->Lamps.reset();
}

void ViewerSession::EnterFullScreen()
{
  if (this->Mode == ViewerMode::Browsing)
  {
    this->Mode = ViewerMode::FullScreen;
    this->FollowZoom();
  }
  this->Update();
  this->Trace("full screen");
}

void ViewerSession::LeaveFullScreen()
{
  if (this->Mode == ViewerMode::FullScreen)
  {
    this->Mode = ViewerMode::Browsing;
    this->Region.reset();
    this->EarlierTaps.clear();
    this->DropPick();
    if (this->Current)
    {
      this->JumpHome();
      this->Target = this->Current->policy.PreviewLevel();
    }
  }
  this->Update();
  this->Trace("browse");
}

void ViewerSession::SetRings(unsigned rings)
{
  this->Options.rings = std::clamp(rings, 1u, 3u);
  if (this->Region && this->Region->rings != this->Options.rings)
  {
    this->DropPick();
    this->WaitingCell = this->Region->cell;
  }
  this->Update();
  this->Trace("rings");
}

void ViewerSession::SetBudgets(std::uint64_t triangles, std::size_t bytes)
{
  this->SetMemory(SharesOfBudgets(triangles, bytes));
}

void ViewerSession::SetMemory(const MemoryShares& shares)
{
  this->Options.TakeShares(shares);
  this->Pieces.SetLimit(shares.cacheBytes);
  this->Tiles.SetLimit(shares.pictureBytes);
  this->CutRegion();
  if (this->Current)
  {
    Model& model = *this->Current;
    model.policy = LevelPolicy(LevelFactsOf(model.description), this->Options.policy);
    model.refinement = model.next = ViewRefinement(model.description, this->Options.refinement);
    this->LastSituation.reset();
    this->FollowZoom();
  }
  this->Update();
  this->Trace("budgets");
}

void ViewerSession::SetAhead(std::size_t bytes)
{
  this->Wanted.SetAhead(bytes);
}

void ViewerSession::SetPreviewsOnly(bool only)
{
  this->PreviewsOnly = only;
  this->Update();
}

void ViewerSession::SetDetail(DetailMode detail)
{
  if (this->Options.detail != detail)
  {
    this->Options.detail = detail;
    this->Wanted.Clear();
    this->ChoiceIsDue = false;
    this->EarlierTaps.clear();
    this->LastSituation.reset();
    this->FollowZoom();
  }
  this->Update();
  this->Trace("detail");
}

// Forgets what failed, so that it is asked for again.
void ViewerSession::Retry()
{
  this->Lost.clear();
  this->AskedAgain.clear();
  this->FailedPieces.clear();
  this->FailedTree.clear();
  this->Tiles.Retry();
  this->Doubtful.clear();
  this->LastError.clear();
}

void ViewerSession::AskAgain()
{
  this->Retry();
  this->Update();
  this->Trace("ask again");
}

// The level that the zoom asks for, and whether the region can still be seen.
void ViewerSession::FollowZoom()
{
  if (!this->Current)
  {
    return;
  }
  const double scale = this->Eye.PixelsPerUnit() / this->Eye.GetViewport().pixelRatio;
  if (this->Mode == ViewerMode::FullScreen)
  {
    this->Target = this->Current->policy.Choose(scale, this->Target);
  }
  if (this->Region && Length(this->Region->box.hi - this->Region->box.lo) * scale <
                        this->Options.smallestRegionPoints)
  {
    this->Region.reset();
  }
}

// ---- frames and what comes out

void ViewerSession::NoteWhatIsShown()
{
  const std::set<PieceId>& shown = this->Shown.Pieces();
  std::erase_if(this->NeverShown,
    [&](const auto& entry)
    {
      const bool isShown = shown.count(entry.first) != 0;
      this->Traffic.wasted -= isShown ? entry.second : 0;
      return isShown;
    });
}

void ViewerSession::BeginFrame()
{
  this->FollowView();
  const auto drawn = this->Shown.Draw(this->Pieces);
  if (!drawn)
  {
    this->LastError = "The surface cannot be drawn: " + drawn.GetError().message;
  }
  else if (*drawn)
  {
    this->History.BeginFrame(this->Shown.Pieces());
    this->NoteWhatIsShown();
    this->FollowSection();
    this->StepOutside();
    if (!this->Ends.empty())
    {
      this->PickEndsAnew();
    }
    if (!this->Ends.empty() || this->Tiles.AreThere())
    {
      this->Update();
    }
    this->Trace("frame");
  }
  if (this->IsArriving && this->IsIdle())
  {
    this->IsArriving = false;
    this->StepOutside();
  }
}

// The original counts as the finest level.
unsigned ViewerSession::LevelFor(Resolution resolution) const
{
  return resolution.IsOriginal() ? this->Current->codec.depths.finest : resolution.Depth();
}

void ViewerSession::EndFrame(double seconds)
{
  this->History.EndFrame(seconds);
}

std::vector<SessionRequest> ViewerSession::TakeRequests()
{
  return this->Wanted.TakeOutgoing();
}

ViewerScene ViewerSession::Scene() const
{
  ViewerScene scene;
  scene.surface = this->Shown.GetSurface();
  scene.surfaceVersion = this->Shown.Version();
  scene.box = this->Current ? this->Current->box : Box{};
  scene.depths = this->Current ? this->Current->codec.depths : TreeDepths{};
  scene.scalars = this->Current ? this->Current->description.scalars : ScalarDescriptions{};
  scene.eye = this->Eye.Eye();
  scene.focal = this->Eye.Focal();
  scene.up = this->Eye.Up();
  scene.orientation = this->Eye.Orientation();
  scene.section = this->Section.Plane();
  scene.cap = this->Section.Cap();
  scene.capVersion = this->Section.CapVersion();
  scene.lighting = LightingOf(this->Lamps);
  scene.tiles = this->Tiles.Tiles();
  return scene;
}

ViewerStatus ViewerSession::GetStatus() const
{
  ViewerStatus status;
  status.mode = this->Mode;
  status.model = this->ModelId;
  status.error = this->LastError;
  status.vertices = this->Shown.GetSurface()->PointCount();
  status.triangles = this->Shown.GetSurface()->TriangleCount();
  status.errorLeft = this->Current && this->ByView() ? this->Current->refinement.ErrorLeft() : 0;
  status.blobsLoaded = this->Wanted.GetProgress().blobsLoaded;
  status.blobsWanted = this->Wanted.GetProgress().blobsWanted;
  status.bytesLoaded = this->Wanted.GetProgress().bytesLoaded;
  if (this->Current)
  {
    status.title = this->Current->description.title;
    status.targetLevel =
      this->ByView() ? this->LevelFor(this->Current->refinement.Finest()) : this->Target;
  }
  if (this->ByView() && this->Shown.Finest())
  {
    status.original = this->Shown.Finest()->IsOriginal();
    status.shownLevel = this->LevelFor(*this->Shown.Finest());
  }
  else if (!this->ByView() && this->Shown.GetCut())
  {
    status.shownLevel = this->LevelFor(this->Shown.GetCut()->base);
  }
  status.picking = this->IsPicking();
  status.canUndo = !this->EarlierViews.empty();
  status.coasting = this->Turned.TurnsOn() || this->Turned.IsSpinning();
  status.spinning = this->Turned.IsSpinning();
  if (this->Region)
  {
    status.region = { this->Region->cell, this->Region->rings, 0, 0 };
    for (const std::uint32_t partition : this->LeftOfRegion())
    {
      ++status.region->partitions;
      status.region->shown += this->Shown.IsRefined(partition) ? 1 : 0;
    }
  }
  return status;
}

void ViewerSession::Trace(std::string_view input, std::string_view detail) const
{
  if (this->Options.FormatTrace)
  {
    this->Options.Sink((this->*this->Options.FormatTrace)(input, detail));
  }
}

}
