// SPDX-License-Identifier: BSD-3-Clause
// GET over one connection that is kept open. This header hides Boost.
#pragma once

#include "filters/core/Result.h"
#include "viewer/client/HttpFetch.h"
#include "viewer/client/ServerUrl.h"

#include <functional>
#include <memory>

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

// Fetches one thing at a time. Connects when necessary, and again if the server has closed the kept
// connection. All calls and callbacks are on the context's thread. Gives up if an answer makes no
// progress for 30 s.
class HttpFetcher
{
public:
  using Handler = std::function<void(Result<HttpReply>)>;
  // tls: for https.
  HttpFetcher(boost::asio::io_context& context, ServerUrl server,
    std::shared_ptr<boost::asio::ssl::context> tls);
  ~HttpFetcher();

  // Errors given to the handler: InputOutput, with the server's address and the system's reason;
  // InvalidInput if its certificate is not trusted; LimitExceeded if the answer is too large.
  // REQUIRES: the last fetch has been answered.
  void Fetch(const HttpFetch& fetch, Handler handler);

private:
  class Connection;
  std::shared_ptr<Connection> Kept;
};

}
