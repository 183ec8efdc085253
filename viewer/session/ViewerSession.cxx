// SPDX-License-Identifier: BSD-3-Clause
// The one brain of all viewers: see ViewerSession.h. Every input ends in Update()
// (SessionWish.cxx), which compares what one would like to see with what is loaded and with what is
// under way.
#include "viewer/session/ViewerSession.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace kdstream
{
namespace
{

using protocol::BlobId;
using protocol::BlobKind;

// Light and paint suffer before the shape does (LightPartOf). Of a whole level the vertices are
// taken to be spread over half the surface of the box.
std::vector<LevelFacts> FactsOf(const ModelDescription& model)
{
  const double part = LightPartOf(model);
  std::vector<LevelFacts> facts;
  for (const auto& level : model.levels)
  {
    if (model.detail == ModelDetail::Preview && facts.size() > PreviewLevel(model))
    {
      break; // of which nothing can be had
    }
    const double spacing = VertexSpacing(model.box, static_cast<double>(level.vertices));
    facts.push_back({ std::max(level.deviation99, spacing * part), level.triangles });
  }
  return facts;
}

// As statistics name it.
const char* NameOf(const BlobId& blob, bool isPreview)
{
  return isPreview                          ? "preview"
         : blob.kind == BlobKind::Partition ? "partition"
         : blob.kind == BlobKind::Texture   ? "texture"
                                            : "level";
}

// Why this viewer cannot show the model; empty if it can.
std::string Objection(const ModelDescription& model)
{
  if (model.levels.size() != model.depths.finest + std::size_t{ 1 })
  {
    return "it has no levels of detail, only partitions";
  }
  return {};
}

}

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
  , History(this->Options.mostStatistics)
{
  this->Options.rings = std::clamp(this->Options.rings, 1u, 3u);
  this->Eye.SetTurning(this->Options.turning);
}

// ---- what the person does

void ViewerSession::Resize(const Viewport& viewport)
{
  this->TakeView(Camera(this->Eye), viewport);
  this->Gestures.SetPixelRatio(this->Eye.GetViewport().pixelRatio);
  if (!this->EyeMoved && this->Current)
  {
    this->Eye.FitTo(this->Current->box, this->Eye.Orientation());
  }
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
    const bool failed = !this->Current && this->Book.Empty();
    if (!failed)
    {
      this->EnterFullScreen();
      return {};
    }
  }
  this->CloseModel();
  this->ModelId = model;
  this->Mode = ViewerMode::Browsing;
  SessionRequest open;
  open.kind = SessionRequest::Kind::Open;
  open.model = model;
  this->Book.Send(open);
  this->Trace("select", model);
  return {};
}

void ViewerSession::CloseModel()
{
  this->Book.CancelAll();
  this->Pieces.Clear();
  this->Shown.Reset({});
  this->Tiles.Reset({}, 0);
  this->Current.reset();
  this->Region.reset();
  this->EarlierTaps.clear();
  this->NeverShown.clear(); // and never will be
  this->DropPick();
  this->MissingTree.clear();
  this->Queue.clear();
  this->Ahead.clear();
  this->AheadOf.clear();
  this->ChoiceIsDue = false;
  this->LastSituation.reset();
  this->History.CloseModel();
  this->BlobsLoaded = this->BlobsWanted = this->BytesLoaded = 0;
  this->EyeMoved = false;
  this->EarlierViews.clear();
  this->LastSteps.clear();
  this->Coasting.reset();
  this->Followed.reset();
  this->SetSpinning(false);
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
    model.policy = LevelPolicy(FactsOf(model.description), this->Options.policy);
    model.refinement = model.next = ViewRefinement(model.description, this->Options.refinement);
    this->LastSituation.reset();
    this->FollowZoom();
  }
  this->Update();
  this->Trace("budgets");
}

void ViewerSession::SetAhead(std::size_t bytes)
{
  this->Options.aheadBytes = bytes;
  this->AheadSpent = 0;
  if (bytes == 0 && this->IsOnlyAhead())
  {
    this->Book.CancelUnwanted({});
  }
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
    this->Queue.clear();
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
  this->FailedPieces.clear();
  this->FailedTree.clear();
  this->Tiles.Retry();
  this->Doubtful.clear();
  this->LastError.clear();
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

// ---- what the server sends

void ViewerSession::SetModels(std::vector<ModelSummary> models)
{
  this->ModelList = std::move(models);
  this->HasModelList = true;
  this->Trace("models");
}

void ViewerSession::Opened(std::uint32_t request, const ModelDescription& model)
{
  if (!this->Book.SettleOpen(request))
  {
    return;
  }
  const std::string objection = Objection(model);
  if (!objection.empty())
  {
    this->LastError = this->ModelId + " cannot be shown: " + objection + ".";
    this->Trace("opened", this->ModelId);
    return;
  }
  this->Current.emplace(
    Model{ model, model.Codec(), LevelPolicy(FactsOf(model), this->Options.policy), model.box,
      KnownTree(model.depths, model.HasLevels(), model.box, this->Options.treeBytes),
      ViewRefinement(model, this->Options.refinement),
      ViewRefinement(model, this->Options.refinement), SeenPartitions(model.depths) });
  this->Shown.Reset(model.depths);
  this->Tiles.Reset(model, VertexSpacing(model.box, static_cast<double>(model.vertices)));
  this->Shown.KeepCorners(this->Tiles.AreThere());
  this->Section.Reset(model.box);
  this->FitModel();
  this->Target = this->Current->policy.PreviewLevel();
  if (this->Followed)
  {
    this->TakeLink();
  }
  this->FollowZoom(); // full screen may have been asked for already
  this->Update();
  this->Trace("opened", this->ModelId);
}

void ViewerSession::BlobArrived(std::uint32_t request, const BlobId& blob,
  std::span<const std::uint8_t> bytes, double transmissionSeconds, bool fromCache)
{
  const SessionRequest* asked = this->Book.Find(request);
  const bool preview = asked && asked->kind == SessionRequest::Kind::Preview;
  ++this->Traffic.blobs;
  this->Traffic.bytes += bytes.size();
  if (!this->Current || !this->Book.Settle(request, blob))
  {
    this->Traffic.wasted += bytes.size();
    this->TakeLate(request, blob, bytes);
    return;
  }
  if (!fromCache)
  {
    this->Meter.Arrived(bytes.size(), transmissionSeconds, request == this->LoneRequest);
    this->LoneRequest = 0;
  }
  BlobStatistics entry;
  entry.what = NameOf(blob, preview);
  entry.id = protocol::BlobName(blob);
  entry.bytes = bytes.size();
  entry.transmissionSeconds = transmissionSeconds;
  entry.fromCache = fromCache;
  ++this->BlobsLoaded;
  this->BytesLoaded += bytes.size();
  if (const Status status = this->Decode(blob, bytes, entry); !status)
  {
    this->Fail(blob, status.GetError().message);
  }
  else if (IsOfPiece(blob))
  {
    const PieceId piece = PieceOfBlob(blob, this->Current->codec.depths);
    this->NeverShown[piece] += bytes.size();
    this->Traffic.wasted += bytes.size();
    this->History.Add(piece, std::move(entry));
  }
  this->Update();
  this->Trace("blob", protocol::BlobName(blob));
}

// What was on the line when it was called back is kept for the next look, as far as the cache goes.
void ViewerSession::TakeLate(
  std::uint32_t request, const BlobId& blob, std::span<const std::uint8_t> bytes)
{
  if (!this->Current || !this->Book.TakeLate(request, blob) || !IsOfPiece(blob))
  {
    return;
  }
  const PieceId piece = PieceOfBlob(blob, this->Current->codec.depths);
  BlobStatistics unused;
  if (!this->Pieces.Peek(piece) && this->Decode(blob, bytes, unused))
  {
    this->NeverShown[piece] += bytes.size();
    this->Update();
  }
  this->Trace("late", protocol::BlobName(blob));
}

Status ViewerSession::Decode(
  const BlobId& blob, std::span<const std::uint8_t> bytes, BlobStatistics& entry)
{
  Model& model = *this->Current;
  if (IsOfTree(blob))
  {
    return model.tree.Add(blob, bytes);
  }
  if (blob.kind == BlobKind::Texture)
  {
    return this->Tiles.Add(blob, bytes, this->Pieces.Peek(PieceOfBlob(blob, model.codec.depths)));
  }
  const double begin = this->Options.clock ? this->Options.clock() : 0;
  auto piece = DecodePiece(bytes, PieceOfBlob(blob, model.codec.depths), model.codec);
  entry.parsingSeconds = this->Options.clock ? this->Options.clock() - begin : 0;
  KDSTREAM_TRY(piece);
  entry.vertices = piece->ownVertices;
  entry.triangles = piece->triangles.size();
  if (this->ByView())
  {
    model.seen.Add(*piece);
  }
  if (piece->id.resolution == Resolution::Level(model.policy.PreviewLevel()))
  {
    model.isClosed = SeenPartitions::IsNearlyClosed(*piece);
  }
  this->Pieces.Add(std::move(*piece));
  return {};
}

void ViewerSession::Fail(const BlobId& blob, const std::string& message)
{
  if (this->Ahead.erase(blob) > 0)
  {
    // Nobody has missed it: no more is fetched ahead of this view. Once wanted, it is asked for
    // again.
    this->AheadSpent = this->Options.aheadBytes;
    return;
  }
  const std::string sentence =
    protocol::BlobName(blob) + " of " + this->ModelId + " cannot be had: " + message;
  if (blob.kind == BlobKind::Texture)
  {
    this->Tiles.Fail(blob);
    this->LastError = sentence;
    return;
  }
  if (IsOfTree(blob))
  {
    this->FailedTree.insert(blob);
    this->DropPick();
    this->LastError = sentence;
    return;
  }
  const PieceId piece = PieceOfBlob(blob, this->Current->codec.depths);
  this->FailedPieces.insert(piece);
  if (this->ByView() && this->Current->refinement.MayDoWithout(piece))
  {
    this->Doubtful.emplace(piece, sentence);
    return;
  }
  this->LastError = sentence;
}

// Where a view is complete without what failed, nothing is wrong with it.
void ViewerSession::TellWhatIsMissed()
{
  for (auto each = this->Doubtful.begin(); each != this->Doubtful.end();)
  {
    if (this->Current->refinement.IsMissed(each->first))
    {
      this->LastError = std::move(each->second);
      each = this->Doubtful.erase(each);
    }
    else
    {
      ++each;
    }
  }
}

void ViewerSession::BlobFailed(
  std::uint32_t request, const BlobId& blob, const std::string& message)
{
  if (this->Current && this->Book.Settle(request, blob))
  {
    this->Fail(blob, message);
    this->Update();
    this->Trace("failed", protocol::BlobName(blob));
  }
}

void ViewerSession::RequestFailed(std::uint32_t request, const std::string& message)
{
  const SessionRequest* asked = this->Book.Find(request);
  if (!asked)
  {
    return;
  }
  const bool open = asked->kind == SessionRequest::Kind::Open;
  const std::vector<BlobId> owed = this->Book.Close(request);
  for (const BlobId& blob : owed)
  {
    this->Fail(blob, message);
  }
  if (open)
  {
    this->LastError = this->ModelId + " cannot be opened: " + message;
  }
  this->Update();
  this->Trace("request failed");
}

void ViewerSession::RequestEnded(std::uint32_t request)
{
  this->RequestFailed(request, "the server ended without sending it");
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
  return this->Book.TakeOutgoing();
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
  status.blobsLoaded = this->BlobsLoaded;
  status.blobsWanted = this->BlobsWanted;
  status.bytesLoaded = this->BytesLoaded;
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
  status.coasting = this->Coasting.has_value() || this->Spins;
  status.spinning = this->Spins;
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
