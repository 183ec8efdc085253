// SPDX-License-Identifier: BSD-3-Clause
// What has come from a server, for a session.
#include "viewer/client/ClientEvent.h"

namespace kdstream
{

BlobArrival Deliver(const ClientEvent& event, ViewerSession& session)
{
  switch (event.kind)
  {
    case ClientEvent::Kind::Opened:
      session.Opened(event.request, event.model);
      break;
    case ClientEvent::Kind::Blob:
      return session.BlobArrived(
        event.request, event.blob, event.bytes, event.transmissionSeconds, event.fromCache);
    case ClientEvent::Kind::BlobFailed:
      session.BlobFailed(event.request, event.blob, event.message);
      break;
    case ClientEvent::Kind::RequestFailed:
      session.RequestFailed(event.request, event.message);
      break;
    case ClientEvent::Kind::RequestEnded:
      session.RequestEnded(event.request);
      break;
    case ClientEvent::Kind::Notes: // sessions do not take notes
      break;
  }
  return BlobArrival::Unwanted;
}

}
