// A session's trace: one line of JSON after every input, with the state and what there is to send.
// Tests compare whole traces, so nothing in it depends on clocks, threads or pointers.
#include "viewer/session/JsonText.h"
#include "viewer/session/ViewerSession.h"

#include <utility>

namespace kdstream
{
namespace
{

std::string Triple(const Vec3& v)
{
  return JsonArray(v, [](double x) { return JsonNumber(x); });
}

std::string CameraJson(const Camera& camera)
{
  const Quaternion& turn = camera.Orientation();
  const std::array<double, 4> orientation{ turn.w, turn.x, turn.y, turn.z };
  return JsonObject()
    .AddRaw("focal", Triple(camera.Focal()))
    .AddRaw("eye", Triple(camera.Eye()))
    .Add("distance", camera.Distance())
    .AddRaw("orientation", JsonArray(orientation, [](double x) { return JsonNumber(x); }))
    .Text();
}

}

std::string FormatRegion(const std::optional<ViewerStatus::Region>& region)
{
  if (!region)
  {
    return "null";
  }
  return JsonObject()
    .Add("cell", region->cell)
    .Add("rings", region->rings)
    .Add("partitions", region->partitions)
    .Add("shown", region->shown)
    .Text();
}

std::string FormatRequest(const SessionRequest& request)
{
  JsonObject json;
  json.Add("request", request.id).Add("kind", NameOf(request.kind));
  switch (request.kind)
  {
    case SessionRequest::Kind::Open:
      json.Add("model", request.model);
      break;
    case SessionRequest::Kind::Region:
      json.Add("cell", request.cell).Add("rings", static_cast<unsigned>(request.rings));
      json.AddRaw(
        "except", JsonArray(request.except, [](std::uint32_t p) { return JsonNumber(p); }));
      break;
    default:
      break;
  }
  json.AddRaw("blobs", JsonArray(request.blobs, [](const protocol::BlobId& blob)
                         { return JsonString(protocol::BlobName(blob)); }));
  return json.Text();
}

void SessionOptions::TraceTo(std::function<void(std::string_view)> sink)
{
  this->FormatTrace = sink ? &ViewerSession::FormatTrace : nullptr;
  this->Sink = std::move(sink);
}

std::string ViewerSession::FormatTrace(std::string_view input, std::string_view detail) const
{
  const ViewerStatus status = this->GetStatus();
  JsonObject line;
  line.Add("input", input)
    .Add("detail", detail)
    .Add("mode", NameOf(status.mode))
    .Add("model", status.model)
    .AddRaw("shown", JsonNumber(status.shownLevel))
    .AddRaw("target", JsonNumber(status.targetLevel))
    .AddRaw("region", FormatRegion(status.region))
    .AddRaw("camera", CameraJson(this->Eye))
    .Add("surface", this->Shown.Version())
    .Add("vertices", status.vertices)
    .Add("triangles", status.triangles)
    .Add("blobs_loaded", status.blobsLoaded)
    .Add("blobs_wanted", status.blobsWanted)
    .Add("idle", this->IsIdle())
    .Add("error", status.error)
    .AddRaw("outgoing", JsonArray(this->Book.Outgoing(), FormatRequest));
  return line.Text();
}

}
