// A session and its line to the server, as a page drives them: see PageSession.h.
#include "viewer/mobile/web/PageSession.h"

#include "viewer/session/SceneRules.h"

#include <algorithm>
#include <array>
#include <utility>

namespace kdstream
{
namespace
{

// What a phone bears. A browser gives a page a few hundred megabytes before it ends it, and all of
// this is held beside the drawn surface (about 120 bytes a triangle while it is drawn anew):
// - decoded pieces beyond what is shown: 96 MiB, a few levels and regions to go back to;
// - levels of at most 600,000 triangles: more than a phone's screen has points, and drawn anew
//   within a second;
// - regions of at most 192 partitions, about as many triangles again;
// - no statistics of blobs, which the page does not show.
SessionOptions PhoneOptions(std::function<double()> clock)
{
  SessionOptions options;
  options.cacheBytes = std::size_t{ 96 } << 20;
  options.policy.triangleBudget = 600'000;
  options.mostRegionPartitions = 192;
  options.mostStatistics = 0;
  options.clock = std::move(clock);
  return options;
}

ServerLineOptions PatientLine()
{
  ServerLineOptions options;
  options.authority = "the server"; // the page has only one
  options.patient = true;
  options.longestSilence = 20;
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

// [x, y, z]: the lengths of the model's box, in its unit.
std::string SidesOf(const protocol::ModelDescription& model)
{
  std::array<double, 3> sides{};
  for (std::size_t k = 0; k < 3; ++k)
  {
    sides[k] = model.boxHi[k] - model.boxLo[k];
  }
  return JsonArray(sides, [](double side) { return JsonNumber(side); });
}

}

PageSession::PageSession(std::function<double()> clock)
  : Viewer(PhoneOptions(std::move(clock)))
  , Talk(PatientLine())
{
}

Status PageSession::SetModels(std::string_view json)
{
  auto models = protocol::ParseModelList(json);
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

void PageSession::Exchange(double now)
{
  this->Send(now);
  for (const ClientEvent& event : this->Talk.TakeEvents())
  {
    if (event.kind == ClientEvent::Kind::Opened)
    {
      this->Open = event.model;
    }
    Deliver(event, this->Viewer);
  }
  this->Send(now); // what the events have led to
}

void PageSession::Send(double now)
{
  for (const SessionRequest& request : this->Viewer.TakeRequests())
  {
    this->Talk.Send(request, now);
  }
}

// What the list says of the model that is open: "" (all is well), "removed" or "replaced".
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

std::string PageSession::ModelsJson() const
{
  return JsonArray(this->Viewer.Models(),
    [](const protocol::ModelSummary& model)
    {
      return JsonObject()
        .Add("id", model.id)
        .Add("title", model.title)
        .Add("vertices", model.vertices)
        .Add("triangles", model.triangles)
        .Text();
    });
}

JsonObject PageSession::Describe() const
{
  const ViewerStatus status = this->Viewer.GetStatus();
  const ViewerScene scene = this->Viewer.Scene();
  JsonObject json;
  json.Add("mode", kdstream::NameOf(status.mode))
    .Add("model", status.model)
    .Add("title", status.title)
    .AddRaw("shownLevel", JsonNumber(status.shownLevel))
    .AddRaw("targetLevel", JsonNumber(status.targetLevel))
    .AddRaw("region", FormatRegion(status.region))
    .Add("vertices", status.vertices)
    .Add("triangles", status.triangles)
    .Add("blobsLoaded", status.blobsLoaded)
    .Add("blobsWanted", status.blobsWanted)
    .Add("bytesLoaded", status.bytesLoaded)
    .Add("error", status.error.empty() ? this->Refusal : status.error)
    .Add("idle", this->Viewer.IsIdle())
    .Add("surface", scene.surfaceVersion)
    .Add("colored", OwnColors(*scene.surface) != nullptr)
    .Add("connection", NameOf(this->Talk.GetState()))
    .Add("trouble", this->Talk.Trouble())
    .Add("stale", this->Staleness());
  if (status.targetLevel) // the model is open
  {
    json.Add("finestLevel", this->Open.finestDepth)
      .Add("credit", this->Open.credit)
      .Add("license", this->Open.license)
      .Add("unit", this->Open.unit)
      .AddRaw("sides", SidesOf(this->Open));
  }
  return json;
}

}
