// SPDX-License-Identifier: BSD-3-Clause
// What has arrived from a server, for a session. Step "receive" of the pipeline picture.
#pragma once

#include "filters/model/ModelDescription.h"
#include "filters/protocol/BlobId.h"
#include "viewer/session/ViewerSession.h"

#include <cstdint>
#include <string>
#include <vector>

namespace kdstream
{

struct ClientEvent
{
  enum class Kind
  {
    Opened,        // `model`
    Blob,          // `blob`, `bytes`
    BlobFailed,    // `blob`, `message`
    RequestFailed, // `message`
    RequestEnded,  // although something is missing
    Notes          // about the model `model.id`: `bytes`, for ParseNotes
  };
  Kind kind = Kind::RequestFailed;
  std::uint32_t request = 0; // the session's number of the request
  ModelDescription model;
  protocol::BlobId blob;
  std::vector<std::uint8_t> bytes;
  // For a Blob: seconds since it was requested, or since the blob before it arrived, whichever is
  // later.
  double transmissionSeconds = 0;
  bool fromCache = false;
  std::string message;
};

// Passes the event to the session. Returns what the session did with a Blob; Unwanted for other
// events.
BlobArrival Deliver(const ClientEvent& event, ViewerSession& session);

}
