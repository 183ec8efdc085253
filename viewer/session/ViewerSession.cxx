// SPDX-License-Identifier: BSD-3-Clause
// The logic of all viewers: see ViewerSession.h.
#include "viewer/session/ViewerSession.h"

#include "viewer/session/SessionParts.h"

#include <algorithm>
#include <utility>

namespace kdstream
{

ViewerSession::ViewerSession(SessionOptions options)
  : Own(std::make_unique<SessionParts>(std::move(options)))
{
}

ViewerSession::ViewerSession(ViewerSession&& other) noexcept = default;
ViewerSession& ViewerSession::operator=(ViewerSession&& other) noexcept = default;
ViewerSession::~ViewerSession() = default;

void ViewerSession::Done(std::string_view input, std::string_view detail)
{
  this->Own->Update();
  this->Trace(input, detail);
}

void ViewerSession::Zoomed(std::string_view input, std::string_view detail)
{
  this->Own->FollowZoom();
  this->Done(input, detail);
}

void ViewerSession::Answered(std::string_view input, std::string_view detail)
{
  this->Own->Update();
  if (this->IsIdle())
  {
    this->Own->model.failed.SettleAll();
  }
  this->Trace(input, detail);
}

// ---- what the user does

void ViewerSession::Resize(const Viewport& viewport)
{
  this->Own->camera.Resize(viewport);
  this->Zoomed("resize");
}

Status ViewerSession::SelectModel(const std::string& model)
{
  const auto listed = std::any_of(this->Own->models.begin(), this->Own->models.end(),
    [&model](const ModelSummary& summary) { return summary.id == model; });
  if (this->Own->hasModels && !listed)
  {
    return Error{ ErrorCode::NotFound, "the server has no model '" + model + "'" };
  }
  this->Own->model.Retry();
  const bool isGone = !this->Own->model.open && this->Own->fetcher.Wishes().Book().Empty();
  if (this->Own->mode != ViewerMode::NoModel && this->Own->model.id == model && !isGone)
  {
    this->EnterFullScreen();
    return {};
  }
  this->Own->Select(model);
  this->Trace("select", model);
  return {};
}

void ViewerSession::EnterFullScreen()
{
  if (this->Own->mode == ViewerMode::Browsing)
  {
    this->Own->mode = ViewerMode::FullScreen;
    this->Own->FollowZoom();
  }
  this->Done("full screen");
}

void ViewerSession::LeaveFullScreen()
{
  if (this->Own->mode == ViewerMode::FullScreen)
  {
    this->Own->mode = ViewerMode::Browsing;
    this->Own->region.LetGo();
    this->Own->camera.JumpHome();
    this->Own->lod.AimAtPreview();
  }
  this->Done("browse");
}

void ViewerSession::SetTool(Tool tool)
{
  this->Own->tools.TakeInHand(tool);
  this->Done("tool");
}

Tool ViewerSession::GetTool() const
{
  return this->Own->tools.InHand();
}

const std::vector<Measurement>& ViewerSession::Measurements() const
{
  return this->Own->tools.Measuring().All();
}

void ViewerSession::NameMeasurement(std::size_t index, const std::string& name)
{
  this->Own->tools.Measuring().Name(index, name);
}

void ViewerSession::RemoveMeasurement(std::size_t index)
{
  this->Own->tools.Measuring().Remove(index);
  this->Own->Update();
}

void ViewerSession::SetSection(const std::optional<SectionPlane>& plane)
{
  if (this->Own->model.open)
  {
    this->Own->model.section.Set(plane);
    this->Done("section"); // what is cut away is not wanted any more
  }
}

bool ViewerSession::SetSectionAlong(std::string_view word)
{
  const Vec3 toEye = this->Own->camera.Get().Forward() * -1;
  const std::string_view side = word == "side" ? "right" : word == "above" ? "top" : word;
  const bool isSide = word == "front" || side != word;
  const bool known = isSide || this->Own->model.section.SetAlong(word, toEye);
  if (const auto direction = isSide ? this->Own->camera.TowardsSide(side) : std::nullopt)
  {
    this->Own->model.section.SetAcross(*direction, toEye);
  }
  if (known && !this->Own->model.open)
  {
    this->Own->model.section.Set({});
  }
  this->Done("section");
  return known;
}

void ViewerSession::SetSectionDepth(double depth)
{
  this->Own->model.section.SetDepth(depth);
  this->Done("section");
}

const ShownSection& ViewerSession::GetSection() const
{
  return this->Own->model.section;
}

std::string ViewerSession::SectionOutline() const
{
  return kdstream::SectionOutline(this->Own->model);
}

void ViewerSession::SetLight(const std::optional<RakingLight>& light)
{
  this->Own->tools.SetLight(light);
  this->Trace("light");
}

const std::optional<RakingLight>& ViewerSession::GetLight() const
{
  return this->Own->tools.Light();
}

void ViewerSession::HandleTouches(const TouchFrame& frame)
{
  for (const Gesture& gesture : this->Own->camera.BeginTouches(frame))
  {
    if (this->Own->model.open)
    {
      this->Own->Handle(gesture, frame.time);
    }
  }
  this->Own->camera.EndTouches(frame);
  this->Done("touches");
}

void ViewerSession::CancelTouches()
{
  this->Own->camera.CancelTouches();
  this->Trace("cancel touches");
}

void ViewerSession::Zoom(double factor, double x, double y)
{
  if (this->Own->camera.ZoomAbout(factor, x, y))
  {
    this->Own->model.Retry();
    this->Own->mode = ViewerMode::FullScreen;
    this->Own->FollowZoom();
  }
  this->Done("zoom");
}

void ViewerSession::GoHome()
{
  this->Own->camera.JumpHome();
  this->Zoomed("home");
}

bool ViewerSession::LookFromSide(std::string_view side)
{
  const bool known = this->Own->camera.JumpToSide(side);
  if (known)
  {
    this->Own->FollowZoom();
  }
  this->Done("side", side);
  return known;
}

void ViewerSession::UndoView()
{
  if (this->Own->camera.Undo())
  {
    this->Own->mode = this->Own->camera.HasMoved() ? ViewerMode::FullScreen : this->Own->mode;
    this->Own->FollowZoom();
  }
  this->Done("undo");
}

void ViewerSession::LookFrom(const Vec3& eye, const Vec3& focal, const Vec3& up, double tangent)
{
  const bool begins = this->Own->mode != ViewerMode::FullScreen;
  if (!this->Own->model.open)
  {
    this->Done("camera");
  }
  else if (this->Own->camera.LookFrom(eye, focal, up, tangent, begins))
  {
    this->Own->mode = ViewerMode::FullScreen;
    this->Zoomed("camera");
  }
}

void ViewerSession::SetTurning(Turning turning)
{
  this->Own->camera.SetTurning(turning);
  this->Done("turning");
}

void ViewerSession::SetCoasting(bool coasts)
{
  this->Own->camera.SetCoasting(coasts);
}

void ViewerSession::SetSpinning(bool spins)
{
  this->Own->camera.SetSpinning(spins);
}

void ViewerSession::Advance(double time)
{
  const CameraControl::Advanced moved = this->Own->camera.Advance(time);
  if (moved.coasted)
  {
    this->Done("advance");
  }
  else if (moved.spun)
  {
    this->Own->Update();
  }
}

void ViewerSession::SetRings(unsigned rings)
{
  this->Own->region.SetRings(rings);
  this->Done("rings");
}

void ViewerSession::SetDetail(DetailMode detail)
{
  if (this->Own->lod.GetOptions().detail != detail)
  {
    this->Own->lod.SetDetail(detail);
    this->Own->fetcher.Wishes().Clear();
    this->Own->region.ForgetEarlier();
    this->Own->FollowZoom();
  }
  this->Done("detail");
}

void ViewerSession::SetBudgets(std::uint64_t triangles, std::size_t bytes)
{
  this->SetMemory(SharesOfBudgets(triangles, bytes));
}

void ViewerSession::SetMemory(const MemoryShares& shares)
{
  this->Own->options.TakeShares(shares);
  this->Own->model.pieces.SetLimit(shares.cacheBytes);
  this->Own->model.tiles.SetLimit(shares.pictureBytes);
  this->Own->region.SetTriangles(shares.regionTriangles, shares.triangles);
  this->Own->lod.SetBudgets(this->Own->options.refinement, this->Own->options.policy);
  this->Zoomed("budgets");
}

void ViewerSession::SetPrefetch(std::size_t bytes)
{
  this->Own->fetcher.Wishes().SetPrefetch(bytes);
}

void ViewerSession::SetGeomorphs(bool geomorphs)
{
  this->Own->model.surface.SetGeomorphs(geomorphs);
}

void ViewerSession::AskAgain()
{
  this->Own->model.Retry();
  this->Done("ask again");
}

void ViewerSession::SetPreviewsOnly(bool only)
{
  this->Own->previewsOnly = only;
  this->Own->Update();
}

// ---- links

ViewLink ViewerSession::Link() const
{
  const Camera& camera = this->Own->camera.Get();
  ViewLink link;
  link.model = this->Own->model.id;
  link.turning = camera.GetTurning();
  link.detail = this->Own->lod.GetOptions().detail;
  if (this->Own->model.open)
  {
    link.digest = this->Own->model.open->description.digest.substr(0, ViewLink::digestDigits);
    link.place = camera.GetPlace();
  }
  this->Own->tools.PutInto(link, camera);
  if (const auto [cell, rings] = this->Own->region.Key(); cell != 0)
  {
    link.region = ViewLink::Region{ cell, rings };
  }
  return link;
}

Status ViewerSession::Follow(const ViewLink& link)
{
  if (this->Own->model.id != link.model || this->Own->mode == ViewerMode::NoModel)
  {
    KDSTREAM_TRY(this->SelectModel(link.model));
  }
  this->EnterFullScreen();
  this->SetTurning(link.turning);
  this->SetDetail(link.detail);
  this->Own->followed = link;
  if (this->Own->model.open)
  {
    this->Own->TakeLink(true);
  }
  this->Zoomed("link");
  return {};
}

// ---- what the server sends

void ViewerSession::SetModels(std::vector<ModelSummary> models)
{
  this->Own->models = std::move(models);
  this->Own->hasModels = true;
  this->Trace("models");
}

void ViewerSession::Opened(std::uint32_t request, const ModelDescription& model)
{
  if (!this->Own->fetcher.Wishes().Opened(request))
  {
    return;
  }
  if (this->Own->model.Open(model, this->Own->options.treeBytes))
  {
    this->Own->lod.Open();
    this->Own->camera.Fit();
  }
  if (this->Own->model.open && this->Own->followed)
  {
    this->Own->TakeLink(false);
  }
  this->Zoomed("opened", this->Own->model.id); // full screen may have been requested already
}

BlobArrival ViewerSession::BlobArrived(std::uint32_t request, const protocol::BlobId& blob,
  std::span<const std::uint8_t> bytes, double transmissionSeconds, bool fromCache)
{
  const Fetcher::Answer answer =
    this->Own->fetcher.BlobArrived(request, blob, bytes, transmissionSeconds, fromCache);
  if (answer.isNews)
  {
    this->Answered(answer.input, protocol::BlobName(blob));
  }
  else if (*answer.input)
  {
    this->Trace(answer.input, protocol::BlobName(blob));
  }
  return answer.arrival;
}

void ViewerSession::BlobFailed(
  std::uint32_t request, const protocol::BlobId& blob, const std::string& message)
{
  if (this->Own->fetcher.BlobFailed(request, blob, message))
  {
    this->Answered("failed", protocol::BlobName(blob));
  }
}

void ViewerSession::RequestFailed(std::uint32_t request, const std::string& message)
{
  if (this->Own->fetcher.RequestFailed(request, message))
  {
    this->Answered("request failed");
  }
}

void ViewerSession::RequestEnded(std::uint32_t request)
{
  this->RequestFailed(request, "the server stopped before sending it");
}

// ---- frames and outputs

void ViewerSession::FollowView()
{
  if (this->Own->model.open && this->Own->fetcher.FollowView(this->Own->View()))
  {
    this->Own->Update();
  }
  this->Own->model.FollowSection();
}

void ViewerSession::BeginFrame()
{
  this->FollowView();
  const auto drawn = this->Own->model.surface.Draw(this->Own->model.pieces);
  if (!drawn)
  {
    this->Own->model.failed.Report("The surface cannot be drawn: " + drawn.GetError().message);
  }
  else if (*drawn)
  {
    this->Own->fetcher.History().BeginFrame(this->Own->model.surface.Pieces());
    this->Own->model.FollowSection();
    this->Own->camera.FollowSurface();
    if (this->Own->tools.Measuring().Waits())
    {
      this->Own->tools.FollowSurface(this->Own->camera.Get());
    }
    if (this->Own->tools.Measuring().Waits() || this->Own->model.tiles.AreThere())
    {
      this->Own->Update();
    }
    this->Trace("frame");
  }
  if (this->IsIdle())
  {
    this->Own->camera.Arrive();
  }
}

void ViewerSession::EndFrame(double seconds)
{
  this->Own->fetcher.History().EndFrame(seconds);
}

std::vector<SessionRequest> ViewerSession::TakeRequests()
{
  return this->Own->fetcher.Wishes().TakeOutgoing();
}

ViewerScene ViewerSession::Scene() const
{
  return this->Own->Scene();
}

ViewerStatus ViewerSession::GetStatus() const
{
  return this->Own->GetStatus();
}

bool ViewerSession::IsIdle() const
{
  return this->Own->IsIdle();
}

const Camera& ViewerSession::GetCamera() const
{
  return this->Own->camera.Get();
}

DetailMode ViewerSession::GetDetail() const
{
  return this->Own->lod.GetOptions().detail;
}

const std::vector<ModelSummary>& ViewerSession::Models() const
{
  return this->Own->models;
}

const std::deque<BlobStatistics>& ViewerSession::Statistics() const
{
  return this->Own->fetcher.History().Entries();
}

std::vector<Box> ViewerSession::RegionBoxes() const
{
  return this->Own->region.Boxes();
}

const SessionTraffic& ViewerSession::GetTraffic() const
{
  return this->Own->fetcher.History().Traffic();
}

void ViewerSession::Trace(std::string_view input, std::string_view detail) const
{
  if (this->Own->options.FormatTrace)
  {
    this->Own->options.Sink((this->*this->Own->options.FormatTrace)(input, detail));
  }
}

}
