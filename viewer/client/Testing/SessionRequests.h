// SPDX-License-Identifier: BSD-3-Clause
// Requests of a session, for tests of connections.
#pragma once

#include "viewer/session/SessionTypes.h"

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace kdstream::testing
{

inline SessionRequest OpenModel(std::uint32_t id, const std::string& model = "m")
{
  SessionRequest request;
  request.id = id;
  request.model = model;
  return request;
}

inline SessionRequest Partitions(std::uint32_t id, std::vector<protocol::BlobId> blobs)
{
  SessionRequest request;
  request.kind = SessionRequest::Kind::Blobs;
  request.id = id;
  request.blobs = std::move(blobs);
  return request;
}

}
