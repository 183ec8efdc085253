// SPDX-License-Identifier: BSD-3-Clause
// One WebSocket: moves messages between a socket and a Conversation. Internal to the server.
#pragma once

#include "server/http/ClientSocket.h"
#include "server/http/ServerState.h"

#include <string>

namespace kdstream
{

// Accepts the upgrade whose Sec-WebSocket-Key is `key`, and serves the stream until the client
// leaves. Then `record` is completed and logged. The seat is kept as long. The stream ends when
// `permission` does.
void ServeStream(ClientSocket socket, ServerState& state, Seat seat, Permission permission,
  AccessRecord record, const std::string& key);

}
