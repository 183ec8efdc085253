// SPDX-License-Identifier: BSD-3-Clause
// One WebSocket: moves messages between a socket and a Conversation. Internal to the server.
#pragma once

#include "server/http/ClientSocket.h"
#include "server/http/ServerState.h"

#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>

#include <memory>

namespace kdstream
{

// Accepts the upgrade that `request` asks for, and serves the stream until the client leaves. Then
// `record` is completed and logged. The seat is kept as long. The stream ends when `permission`
// does.
void ServeStream(ClientSocket socket, ServerState& state, Seat seat, Permission permission,
  AccessRecord record, const beast::http::request<beast::http::empty_body>& request);

}
