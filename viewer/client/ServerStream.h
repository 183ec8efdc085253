// SPDX-License-Identifier: BSD-3-Clause
// Bytes to and from a server, plain or in TLS.
#pragma once

#include "filters/core/Result.h"
#include "viewer/client/ServerUrl.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/beast/core/role.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/websocket/teardown.hpp>

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace kdstream
{

// Makes a TLS context with the trusted certificate authorities: those in a PEM file, if one is
// named, otherwise those that the system trusts. At least TLS 1.2. Errors: NotFound, InvalidInput,
// naming the file.
Result<std::shared_ptr<boost::asio::ssl::context>> MakeTlsContext(const std::string& authorities);

// A connection that can be made again when necessary. It is an AsyncStream of Boost.Beast, so that
// both HTTP and WebSocket can use it. All calls and callbacks are on the context's thread.
class ServerStream
{
public:
  using next_layer_type = boost::beast::tcp_stream;
  using executor_type = next_layer_type::executor_type;

  // tls: for https. REQUIRES: server.isSecure or no tls.
  ServerStream(boost::asio::io_context& context, ServerUrl server,
    std::shared_ptr<boost::asio::ssl::context> tls);

  // Resolves the server's name, connects, and checks its certificate; each may take at most
  // `atMost`. The captures of `done` must keep this object alive. Errors given to `done`:
  // InputOutput, with the system's reason; InvalidInput if the server's certificate is not trusted,
  // or if it does not speak TLS.
  void Connect(std::chrono::seconds atMost, std::function<void(Status)> done);
  // Everything in flight ends with an error.
  void Close();

  executor_type get_executor() noexcept { return this->Plain.get_executor(); }
  // For timeouts.
  next_layer_type& next_layer() noexcept { return this->Plain; }
  const next_layer_type& next_layer() const noexcept { return this->Plain; }

  template <class Buffers, class Handler>
  void async_read_some(const Buffers& buffers, Handler&& handler)
  {
    this->Secure ? this->Secure->async_read_some(buffers, std::forward<Handler>(handler))
                 : this->Plain.async_read_some(buffers, std::forward<Handler>(handler));
  }
  template <class Buffers, class Handler>
  void async_write_some(const Buffers& buffers, Handler&& handler)
  {
    this->Secure ? this->Secure->async_write_some(buffers, std::forward<Handler>(handler))
                 : this->Plain.async_write_some(buffers, std::forward<Handler>(handler));
  }

private:
  void Introduce(std::chrono::seconds atMost, std::function<void(Status)> done);
  Status PrepareTls();
  Error NotTrusted(const boost::system::error_code& error);

  ServerUrl Server;
  boost::asio::ip::tcp::resolver Resolver;
  next_layer_type Plain;
  std::shared_ptr<boost::asio::ssl::context> Tls;
  std::optional<boost::asio::ssl::stream<next_layer_type&>> Secure;
};

// Called by Boost.Beast's WebSocket when it ends. Nothing needs to be sent, because the socket is
// closed.
template <class Handler>
void async_teardown(boost::beast::role_type role, ServerStream& stream, Handler&& handler)
{
  boost::beast::websocket::async_teardown(
    role, stream.next_layer().socket(), std::forward<Handler>(handler));
}

}
