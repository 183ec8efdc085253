// SPDX-License-Identifier: BSD-3-Clause
// One HTTP connection: reads requests and sends the routes' answers one after the other, until the
// client leaves or asks for a WebSocket. Internal to the server.
#pragma once

#include "server/http/ClientSocket.h"
#include "server/http/ServerState.h"

#include <memory>
#include <string>

namespace kdstream
{

// How a client is admitted.
struct Admission
{
  Client client;
  ConnectionSlot slot;
  bool isAdmin = false;          // asks for metrics
  bool isIntroduced = false;     // a proxy's header comes first, and names the client
  unsigned refusedWith = 0;      // if there is no slot, the status of every answer: 503 or 429
  std::shared_ptr<void> refusal; // kept as long as the connection, so that the refusal is counted
};

void ServeHttp(ClientSocket socket, ServerState& state, Admission admission);

// Serves one WebSocket: moves messages between a socket and a Conversation (StreamConnection.cxx).
// Accepts the upgrade whose Sec-WebSocket-Key is `key`, and serves the stream until the client
// leaves. Then `record` is completed and logged, and the slot is released. The stream also ends
// when `permission` does.
void ServeStream(ClientSocket socket, ServerState& state, ConnectionSlot slot,
  Permission permission, AccessRecord record, const std::string& key);

}
