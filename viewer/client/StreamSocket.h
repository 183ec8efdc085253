// SPDX-License-Identifier: BSD-3-Clause
// The WebSocket to a server. This header hides Boost.
#pragma once

#include "viewer/client/ServerUrl.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

namespace boost::asio
{
class io_context;
namespace ssl
{
class context;
}
}

namespace kdstream
{

// One connection of /api/stream. All calls and callbacks are on the context's thread.
class StreamSocket
{
public:
  struct Handlers
  {
    std::function<void()> onOpen;
    std::function<void(std::span<const std::uint8_t> bytes, bool isText)> onMessage;
    // The last callback. refused: the server answers, but has no stream for this client. why: the
    // reason, by the system or by us. retryAfter: the seconds after which a busy server wants to be
    // asked again; 0 if it does not say.
    std::function<void(bool refused, const std::string& why, double retryAfter)> onEnd;
  };

  // Starts to connect. tls: for https.
  StreamSocket(boost::asio::io_context& context, const ServerUrl& server,
    std::shared_ptr<boost::asio::ssl::context> tls, Handlers handlers);
  // Closes the socket; there are no more callbacks.
  ~StreamSocket();

  // REQUIRES: onOpen was called. Messages are sent in order.
  void Send(std::string text);

private:
  class Connection;
  std::shared_ptr<Connection> Kept;
};

}
