// SPDX-License-Identifier: BSD-3-Clause
// One HTTP connection: reads requests and sends the routes' answers one after the other, until the
// client leaves or asks for a WebSocket. Internal to the server.
#pragma once

#include "server/http/ClientSocket.h"
#include "server/http/ServerState.h"

#include <memory>

namespace kdstream
{

// Without a seat, every request is answered 503. `refusal` is kept as long as the connection, to
// count it.
void ServeHttp(ClientSocket socket, ServerState& state, std::shared_ptr<void> seat,
  std::shared_ptr<void> refusal);

}
