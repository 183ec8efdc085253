// SPDX-License-Identifier: BSD-3-Clause
// A session and its connection to the server, as a page uses them: see PageSession.h.
#include "viewer/mobile/web/PageSession.h"

#include "filters/codec/Seal.h"
#include "filters/core/tree/PieceDepth.h"
#include "filters/model/ModelJson.h"
#include "filters/protocol/ResourcePath.h"
#include "viewer/session/Geometry.h"
#include "viewer/session/Picker.h"
#include "viewer/session/SessionParts.h"
#include "viewer/session/appearance/SceneRules.h"

#include <algorithm>
#include <map>
#include <utility>

namespace kdstream
{
namespace
{

// The limits for a phone: memory by MemoryBudget; regions of at most 192 partitions; no statistics
// of blobs, because the page does not show them.
SessionOptions PhoneOptions(std::function<double()> clock)
{
  SessionOptions options;
  options.refinement.smallModel = 60'000;
  options.region.partitions = 192;
  options.mostStatistics = 0;
  options.clock = std::move(clock);
  return options;
}

ServerLineOptions PatientLine()
{
  ServerLineOptions options;
  options.authority = "the server"; // the page has only one
  options.patient = true;
  options.firstRetry = 1;
  options.jitter = 3;
  options.streamRetry = 60;
  options.idleTimeout = 20;
  options.stallTimeout = 60;
  return options;
}

const char* NameOf(ServerLine::State state)
{
  switch (state)
  {
    case ServerLine::State::Streaming:
      return "streaming";
    case ServerLine::State::Lost:
      return "lost";
    case ServerLine::State::Getting:
      return "getting";
    case ServerLine::State::Connecting:
      break;
  }
  return "connecting";
}

// Returns only "model=…" of a link whose other parts may be invalid; empty if there is no model.
std::string_view ModelAlone(std::string_view text)
{
  constexpr std::string_view key = "model=";
  while (!text.empty())
  {
    const std::string_view entry = text.substr(0, text.find('&'));
    if (entry.substr(0, key.size()) == key)
    {
      return entry;
    }
    text.remove_prefix(std::min(entry.size() + 1, text.size()));
  }
  return {};
}

}

PageSession::PageSession(std::function<double()> clock)
  : Viewer(PhoneOptions(std::move(clock)))
  , Connection(PatientLine())
{
  this->Viewer.SetMemory(this->Memory.Shares());
  this->Viewer.SetPreviewsOnly(true);
}

void PageSession::BecomeWhole()
{
  this->Whole = true;
  for (const ClientEvent& event : std::exchange(this->Waiting, {}))
  {
    this->Take(event);
  }
  this->Viewer.SetPreviewsOnly(false);
}

// Whether the open model has something that the first part of the viewer cannot show.
bool PageSession::NeedsSecondPart() const
{
  if (this->Open.id.empty())
  {
    return false;
  }
  const std::size_t preview = PreviewLevel(this->Open.depths);
  const auto& levels = this->Open.levels;
  return preview >= levels.size() || levels[preview].triangles == 0 || this->Open.grid.Lossless();
}

void PageSession::SetMemory(std::size_t bytes)
{
  this->Memory = MemoryBudget(bytes);
  this->Viewer.SetMemory(this->Memory.Shares());
}

void PageSession::FollowMemory(std::size_t taken)
{
  if (this->Memory.Follow(taken))
  {
    this->Viewer.SetMemory(this->Memory.Shares());
  }
}

Status PageSession::SetModels(std::string_view json)
{
  auto models = ParseModelList(json);
  KDSTREAM_TRY(models);
  this->Viewer.SetModels(std::move(*models));
  this->Listed = true;
  return {};
}

void PageSession::SelectModel(const std::string& model)
{
  const Status selected = this->Viewer.SelectModel(model);
  this->Refusal = selected ? "" : selected.GetError().message;
}

void PageSession::Follow(const std::string& text)
{
  auto link = ParseViewLink(text);
  const std::string wrong = link ? "" : link.GetError().message;
  if (!link)
  {
    link = ParseViewLink(ModelAlone(text)); // the model opens even if the view is invalid
  }
  if (link && link->detail == DetailMode::Full)
  {
    link->detail = DetailMode::View; // no phone holds every model's original
  }
  const Status followed = link ? this->Viewer.Follow(*link) : Status(link.GetError());
  this->Refusal = !wrong.empty() ? wrong : followed ? "" : followed.GetError().message;
}

void PageSession::Exchange(double now)
{
  this->FollowTrouble();
  this->Send(now);
  for (ClientEvent& event : this->Connection.TakeEvents())
  {
    this->Receive(std::move(event));
  }
  this->Send(now); // sends what the events have caused
}

void PageSession::Receive(ClientEvent event)
{
  if (!this->Whole && this->NeedsSecondPart())
  {
    this->Waiting.push_back(std::move(event));
  }
  else
  {
    this->Take(event);
  }
}

void PageSession::Take(const ClientEvent& event)
{
  if (event.kind == ClientEvent::Kind::Opened)
  {
    this->Open = event.model;
    this->OpenRequest = event.request;
  }
  const bool keeps = this->Keeps && event.kind == ClientEvent::Kind::Blob && !event.fromCache &&
                     event.request > this->OpenRequest;
  const bool isTaken = Deliver(event, this->Viewer) == BlobArrival::Taken;
  // Only blobs that the session took are offered for storing: pages of the tree that come late, and
  // blobs that were loaded already, have not been decoded, and so not checked.
  if (keeps && isTaken && !this->Open.id.empty() && IsSealed(event.bytes))
  {
    this->Arrivals.push_back(
      { protocol::BlobPath(this->Open.id, this->Open.digest, event.blob), event.bytes });
  }
}

std::optional<PageSession::Arrival> PageSession::TakeArrival()
{
  if (this->Arrivals.empty())
  {
    return std::nullopt;
  }
  Arrival arrival = std::move(this->Arrivals.front());
  this->Arrivals.pop_front();
  return arrival;
}

void PageSession::Send(double now)
{
  for (const SessionRequest& request : this->Viewer.TakeRequests())
  {
    this->Send(request, now);
  }
}

void PageSession::Send(const SessionRequest& request, double now)
{
  Searched* const cancelled =
    request.kind == SessionRequest::Kind::Cancel ? this->FindSearch(request.id) : nullptr;
  const bool isOutstanding = !cancelled || cancelled->isOutstanding;
  if (cancelled)
  {
    this->Searches.erase(this->Searches.begin() + (cancelled - this->Searches.data()));
  }
  if (!isOutstanding)
  {
    return;
  }
  if (this->Keeps && !request.blobs.empty())
  {
    this->Searches.push_back({ request, false, {}, this->IsAway, false });
  }
  else
  {
    this->Connection.Send(request, now);
  }
}

// Reacts if the server can no longer be reached, or can be reached again.
void PageSession::FollowTrouble()
{
  const bool isAway = this->Whole && !this->Connection.Trouble().empty();
  if (std::exchange(this->IsAway, isAway) == isAway)
  {
    return;
  }
  if (isAway && this->Keeps)
  {
    this->SearchOutstanding();
  }
  if (!isAway && std::exchange(this->Misses, false))
  {
    this->Viewer.AskAgain();
  }
}

void PageSession::SearchOutstanding()
{
  std::map<std::uint32_t, SessionRequest> outstanding;
  for (const auto& [blob, request] : this->Viewer.Parts().fetcher.Wishes().Book().AllOutstanding())
  {
    outstanding[request].id = request;
    outstanding[request].blobs.push_back(blob);
  }
  for (auto& [id, request] : outstanding)
  {
    if (!this->FindSearch(id))
    {
      this->Searches.push_back({ std::move(request), false, {}, true, true });
    }
  }
}

PageSession::Searched* PageSession::FindSearch(std::uint32_t id)
{
  const auto found = std::find_if(this->Searches.begin(), this->Searches.end(),
    [id](const Searched& each) { return each.request.id == id; });
  return found == this->Searches.end() ? nullptr : &*found;
}

std::string PageSession::TakeSearch()
{
  for (Searched& search : this->Searches)
  {
    if (!std::exchange(search.isReported, true))
    {
      std::string text = std::to_string(search.request.id) + (search.isAgain ? " again" : "");
      for (const protocol::BlobId& blob : search.request.blobs)
      {
        text += "\n" + protocol::BlobPath(this->Open.id, this->Open.digest, blob);
      }
      return text;
    }
  }
  return {};
}

void PageSession::Found(std::uint32_t search, std::size_t index, std::vector<std::uint8_t> bytes)
{
  Searched* const searched = this->FindSearch(search);
  if (!searched || index >= searched->request.blobs.size() || !IsSealed(bytes))
  {
    return;
  }
  ClientEvent event;
  event.kind = ClientEvent::Kind::Blob;
  event.request = search;
  event.blob = searched->request.blobs[index];
  event.bytes = std::move(bytes);
  event.fromCache = true;
  searched->found.push_back(event.blob);
  this->Receive(std::move(event));
}

// Ends a search in the stored blobs, and requests those that were not found.
void PageSession::EndSearch(std::uint32_t search, bool isKept, double now)
{
  Searched* const searched = this->FindSearch(search);
  if (!searched)
  {
    return;
  }
  if (this->IsAway && !std::exchange(searched->isAgain, true))
  {
    searched->isReported = false; // search again, because the server went away during this search
    return;
  }
  const SessionRequest left = LeftOf(std::move(searched->request), searched->found);
  const bool isOutstanding = searched->isOutstanding;
  this->Searches.erase(this->Searches.begin() + (searched - this->Searches.data()));
  const bool fails = isKept && this->IsAway && !left.blobs.empty();
  if (isOutstanding && (fails || left.blobs.empty()))
  {
    SessionRequest cancel;
    cancel.kind = SessionRequest::Kind::Cancel;
    cancel.id = search;
    this->Connection.Send(cancel, now);
  }
  if (fails)
  {
    this->Misses = true;
    ClientEvent event;
    event.request = search;
    event.message = "it is not stored on this device";
    this->Receive(std::move(event));
  }
  else if (!isOutstanding && !left.blobs.empty())
  {
    this->Connection.Send(left, now);
  }
}

// The state of the open model in the list: "" (unchanged), "removed" or "replaced".
std::string PageSession::Staleness() const
{
  const std::string model = this->Viewer.GetStatus().model;
  if (!this->Listed || model.empty())
  {
    return {};
  }
  const auto& models = this->Viewer.Models();
  const auto listed =
    std::find_if(models.begin(), models.end(), [&model](const auto& m) { return m.id == model; });
  if (listed == models.end())
  {
    return "removed";
  }
  return this->Open.id == model && this->Open.digest != listed->digest ? "replaced" : "";
}

std::string PageSession::MeasurementsJson() const
{
  const Vec3 up = this->Open.homeView.value_or(HomeView{}).up;
  JsonWriter json;
  const auto put = [&](const char* key, const MeasuredPoint& end)
  {
    const auto pixel = this->Viewer.GetCamera().PixelOf(end.point);
    json.Key(key);
    pixel ? json.BeginArray().Put((*pixel)[0]).Put((*pixel)[1]).EndArray() : json.PutJson("null");
  };
  json.BeginArray();
  for (const Measurement& each : this->Viewer.Measurements())
  {
    json.BeginObject()
      .Member("name", each.name)
      .Member("distance", each.Distance())
      .Member("height", each.Height(up))
      .Member("horizontal", each.Horizontal(up))
      .Member("error", each.Error())
      .Member("exact", each.IsExact())
      .Member("waits", each.from.waits || (each.to && each.to->waits));
    put("from", each.from);
    each.to ? put("to", *each.to) : void(json.Key("to").PutJson("null"));
    json.EndObject();
  }
  json.EndArray();
  return json.Text();
}

void PageSession::SetMarks(std::string_view links)
{
  this->Marks.clear();
  this->MarkedSurface.reset();
  while (!links.empty())
  {
    const std::string_view text = links.substr(0, links.find('\n'));
    const auto link = ParseViewLink(text);
    this->Marks.push_back({ link ? link->place : std::nullopt, std::nullopt });
    links.remove_prefix(std::min(text.size() + 1, links.size()));
  }
}

// Places the marks again on each new surface, because a finer surface is at slightly other places.
void PageSession::PlaceMarks()
{
  const ViewerScene scene = this->Viewer.Scene();
  if (this->MarkedSurface == scene.surfaceVersion)
  {
    return;
  }
  this->MarkedSurface = scene.surfaceVersion;
  for (Mark& mark : this->Marks)
  {
    mark.point.reset();
    if (mark.view)
    {
      Camera camera = this->Viewer.GetCamera();
      camera.SetPlace(*mark.view);
      const auto hit = PickSurface(
        *scene.surface, { camera.Eye(), camera.Forward() }, camera.TangentOf(fingerPoints));
      mark.point = hit ? std::optional(hit->point) : std::nullopt;
    }
  }
}

bool PageSession::Sees(const Vec3& point) const
{
  // A share of the distance. Without this slack, the surface could hide its own mark by rounding.
  constexpr double slack = 0.01;
  const ViewerScene scene = this->Viewer.Scene();
  if (scene.section && scene.section->CutsAway(point))
  {
    return false;
  }
  const double distance = Length(point - scene.eye);
  const Ray ray{ scene.eye, Normalized(point - scene.eye) };
  const double begin = scene.section ? scene.section->KeptOf(ray).begin : 0;
  const auto hit = PickSurface(*scene.surface, ray, 0, nullptr, begin);
  return !hit || hit->distance > distance * (1 - slack);
}

std::string PageSession::MarksJson()
{
  this->PlaceMarks();
  JsonWriter json;
  json.BeginArray();
  for (const Mark& mark : this->Marks)
  {
    const auto pixel = mark.point ? this->Viewer.GetCamera().PixelOf(*mark.point) : std::nullopt;
    if (pixel)
    {
      json.BeginArray().Put((*pixel)[0]).Put((*pixel)[1]).Put(this->Sees(*mark.point)).EndArray();
    }
    else
    {
      json.PutJson("null");
    }
  }
  json.EndArray();
  return json.Text();
}

void PageSession::Describe(JsonWriter& json, bool isInFlight) const
{
  const ViewerStatus status = this->Viewer.GetStatus();
  const ViewerScene scene = this->Viewer.Scene();
  const bool waits = !this->Whole && (this->NeedsSecondPart() || status.picking ||
                                       status.mode == ViewerMode::FullScreen);
  json.Member("mode", kdstream::NameOf(status.mode))
    .Member("model", status.model)
    .Member("title", status.title)
    .Member("shownLevel", status.shownLevel)
    .Member("targetLevel", status.targetLevel)
    .Member("original", status.original)
    .Member("errorLeft", status.remainingError);
  json.Key("region").PutJson(FormatRegion(status.region));
  json.Member("vertices", status.vertices)
    .Member("triangles", status.triangles)
    .Member("blobsLoaded", status.blobsLoaded)
    .Member("blobsWanted", status.blobsWanted)
    .Member("bytesLoaded", status.bytesLoaded)
    .Member("error", status.error.empty() ? this->Refusal : status.error)
    .Member("idle", this->Viewer.IsIdle() && !isInFlight && !waits)
    .Member("waits", waits)
    .Member("canUndo", status.canUndo)
    .Member("turnsOn", status.coasting)
    .Member("spinning", status.spinning)
    .Member("measuring", this->Viewer.GetTool() == Tool::Measure)
    .Member("tool", static_cast<unsigned>(this->Viewer.GetTool()))
    .Member("depth", this->Viewer.GetSection().Plane()
                       ? std::optional(this->Viewer.GetSection().Depth())
                       : std::nullopt)
    .Member("surface", scene.surfaceVersion)
    .Member("colored", HasOwnColors(*scene.surface))
    .Member("connection", NameOf(this->Connection.GetState()))
    .Member("trouble", this->Connection.Trouble())
    .Member("stale", this->Staleness());
  if (const auto& light = this->Viewer.GetLight())
  {
    json.Member("lamp", light->lightSource.intensity)
      .Member("secondLamp", light->second ? std::optional(light->second->intensity) : std::nullopt)
      .Member("relief", light->relief);
  }
  if (status.targetLevel) // then the model is open
  {
    json.Member("finestLevel", this->Open.depths.finest)
      .Member("credit", this->Open.credit)
      .Member("license", this->Open.license)
      .Member("description", this->Open.description)
      .Member("unit", this->Open.unit)
      .Member("sides", this->Open.box.hi - this->Open.box.lo);
  }
}

}
