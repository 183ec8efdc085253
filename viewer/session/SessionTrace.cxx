// SPDX-License-Identifier: BSD-3-Clause
// A session's trace: one line of JSON after every input, with the state and the requests to send.
// Tests compare whole traces, so nothing in it depends on clocks, threads or pointers.
#include "filters/model/JsonWriter.h"
#include "viewer/session/SessionParts.h"
#include "viewer/session/ViewerSession.h"

#include <array>
#include <utility>

namespace kdstream
{
namespace
{

void PutCamera(JsonWriter& json, const Camera& camera)
{
  const Quaternion& turn = camera.Orientation();
  json.BeginObject()
    .Member("focal", camera.Focal())
    .Member("eye", camera.Eye())
    .Member("distance", camera.Distance())
    .Member("orientation", std::array<double, 4>{ turn.w, turn.x, turn.y, turn.z })
    .EndObject();
}

}

std::string FormatRegion(const std::optional<ViewerStatus::Region>& region)
{
  if (!region)
  {
    return "null";
  }
  JsonWriter json;
  json.BeginObject()
    .Member("cell", region->cell)
    .Member("rings", region->rings)
    .Member("partitions", region->partitions)
    .Member("shown", region->shown)
    .EndObject();
  return json.Text();
}

std::string FormatRequest(const SessionRequest& request, bool isPreview)
{
  using Kind = SessionRequest::Kind;
  const bool opens = request.kind == Kind::Open;
  JsonWriter json;
  json.BeginObject()
    .Member("request", request.id)
    .Member("kind", isPreview                      ? "preview"
                    : request.kind == Kind::Cancel ? "cancel"
                    : opens                        ? "open"
                                                   : "blobs");
  if (opens)
  {
    json.Member("model", request.model);
  }
  json.Key("blobs").BeginArray();
  for (const protocol::BlobId& blob : request.blobs)
  {
    json.Put(protocol::BlobName(blob));
  }
  json.EndArray().EndObject();
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
  JsonWriter line;
  line.BeginObject()
    .Member("input", input)
    .Member("detail", detail)
    .Member("mode", NameOf(status.mode))
    .Member("model", status.model)
    .Member("shown", status.shownLevel)
    .Member("target", status.targetLevel)
    .Member("original", status.original)
    .Member("error_left", status.remainingError);
  line.Key("region").PutJson(FormatRegion(status.region)).Key("camera");
  PutCamera(line, this->Own->camera.Get());
  line.Member("surface", this->Own->model.surface.Version())
    .Member("vertices", status.vertices)
    .Member("triangles", status.triangles)
    .Member("blobs_loaded", status.blobsLoaded)
    .Member("blobs_wanted", status.blobsWanted)
    .Member("idle", this->IsIdle())
    .Member("error", status.error)
    .Key("outgoing")
    .BeginArray();
  for (const SessionRequest& request : this->Own->fetcher.Wishes().Book().Outgoing())
  {
    const bool isPreview =
      this->Own->model.open && request.blobs == std::vector{ this->Own->model.PreviewBlob() };
    line.PutJson(FormatRequest(request, isPreview));
  }
  line.EndArray().EndObject();
  return line.Text();
}

}
