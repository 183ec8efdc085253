// SPDX-License-Identifier: BSD-3-Clause
// The WebSocket to a server. Boost stays in the source.
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
    // The last call. refused: the server answers, but has no stream for this client. why: the
    // system's or our reason. retryAfter: the seconds after which a busy server wants to be asked
    // again; 0 if it does not say.
    std::function<void(bool refused, const std::string& why, double retryAfter)> onEnd;
  };

  // Starts to connect. tls: for https.
  StreamSocket(boost::asio::io_context& context, const ServerUrl& server,
    std::shared_ptr<boost::asio::ssl::context> tls, Handlers handlers);
  // Closes; no callback comes any more.
  ~StreamSocket();

  // After onOpen. Messages go out in order.
  void Send(std::string text);

private:
  class Connection;
  std::shared_ptr<Connection> Kept;
};

}
