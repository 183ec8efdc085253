// SPDX-License-Identifier: BSD-3-Clause
// Names and texts of what goes in and out of a viewer's session.
#include "viewer/session/SessionTypes.h"

#include "filters/model/JsonWriter.h"

namespace kdstream
{

const char* NameOf(ViewerMode mode)
{
  switch (mode)
  {
    case ViewerMode::Browsing:
      return "browsing";
    case ViewerMode::FullScreen:
      return "full screen";
    case ViewerMode::NoModel:
      break;
  }
  return "no model";
}

SessionRequest LeftOf(SessionRequest request, const std::vector<protocol::BlobId>& here)
{
  for (const protocol::BlobId& blob : here)
  {
    std::erase(request.blobs, blob);
  }
  return request;
}

std::string StatisticsJson(const std::deque<BlobStatistics>& statistics)
{
  std::string text = "[";
  for (const BlobStatistics& blob : statistics)
  {
    text += text.size() > 1 ? ",\n " : "\n ";
    JsonWriter json;
    json.BeginObject()
      .Member("what", blob.what)
      .Member("id", blob.id)
      .Member("vertices", blob.vertices)
      .Member("triangles", blob.triangles)
      .Member("bytes", blob.bytes)
      .Member("transmission_s", blob.transmissionSeconds)
      .Member("parsing_s", blob.parsingSeconds)
      .Member("rendering_s", blob.renderingSeconds)
      .Member("from_cache", blob.fromCache)
      .EndObject();
    text += json.Text();
  }
  return text + "\n]\n";
}

}
