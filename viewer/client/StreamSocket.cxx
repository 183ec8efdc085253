// SPDX-License-Identifier: BSD-3-Clause
// The WebSocket to a server.
#include "viewer/client/StreamSocket.h"

#include "filters/protocol/ControlMessage.h"
#include "filters/protocol/ResourcePath.h"
#include "viewer/client/HttpFetch.h"
#include "viewer/client/ServerStream.h"

#include <boost/asio/io_context.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket/stream.hpp>

#include <algorithm>
#include <chrono>
#include <deque>
#include <utility>

namespace kdstream
{
namespace
{
namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using boost::system::error_code;

constexpr std::chrono::seconds socketConnectTimeout{ 10 };
// After this time of silence a ping is sent to the server; after the same time again the connection
// is given up.
constexpr std::chrono::seconds socketIdleTimeout{ 20 };
}

class StreamSocket::Connection : public std::enable_shared_from_this<Connection>
{
public:
  Connection(asio::io_context& context, ServerUrl server, std::shared_ptr<asio::ssl::context> tls,
    Handlers handlers)
    : Server(std::move(server))
    , Callbacks(std::move(handlers))
    , Socket(context, this->Server, std::move(tls))
  {
  }

  void Connect()
  {
    this->Socket.next_layer().Connect(socketConnectTimeout,
      [self = this->shared_from_this()](const Status& connected)
      { connected ? self->Handshake() : self->End(false, connected.GetError().message); });
  }

  void Send(std::string text)
  {
    this->Outgoing.push_back(std::move(text));
    if (this->Outgoing.size() == 1)
    {
      this->Write();
    }
  }

  void Close()
  {
    this->Callbacks = {};
    this->Socket.next_layer().Close();
  }

private:
  void Handshake()
  {
    beast::get_lowest_layer(this->Socket).expires_never(); // the WebSocket has timeouts of its own
    websocket::stream_base::timeout timeout;
    timeout.handshake_timeout = socketConnectTimeout;
    timeout.idle_timeout = socketIdleTimeout * 2;
    timeout.keep_alive_pings = true;
    this->Socket.set_option(timeout);
    this->Socket.set_option(websocket::stream_base::decorator(
      [token = this->Server.token](websocket::request_type& request)
      {
        if (!token.empty())
        {
          request.set(http::field::authorization, "Bearer " + token);
        }
        request.set(http::field::sec_websocket_protocol, std::string(protocol::streamSubprotocol));
        request.set(http::field::user_agent, "kdstream");
      }));
    this->Socket.read_message_max(protocol::maximumServerMessageBytes);
    this->Socket.async_handshake(this->Answer, this->Server.Authority(),
      std::string(protocol::streamPath),
      [self = this->shared_from_this()](error_code error) { self->Shaken(error); });
  }

  void Shaken(error_code error)
  {
    if (error)
    {
      const bool declined = error == websocket::error::upgrade_declined;
      const auto status = this->Answer.result_int();
      const bool busy = declined && IsBusy(status);
      const std::string pause(this->Answer[http::field::retry_after]);
      this->End(declined && !busy && !IsForbidden(status),
        !declined       ? error.message()
        : status == 401 ? "the server says 401: the token has expired or was revoked"
                        : "the server says " + std::to_string(status),
        busy ? std::max(1.0, RetryAfterIn(pause)) : 0); // at least 1 s: proxies name no time
    }
    else if (std::string(this->Answer[http::field::sec_websocket_protocol]) !=
             protocol::streamSubprotocol)
    {
      this->End(true, "the server does not speak " + std::string(protocol::streamSubprotocol));
    }
    else
    {
      this->Callbacks.onOpen ? this->Callbacks.onOpen() : void();
      this->Read();
    }
  }

  void Read()
  {
    this->Socket.async_read(this->Incoming,
      [self = this->shared_from_this()](error_code error, std::size_t)
      {
        if (error)
        {
          self->End(false, error.message());
          return;
        }
        const auto data = self->Incoming.cdata();
        if (self->Callbacks.onMessage)
        {
          self->Callbacks.onMessage({ static_cast<const std::uint8_t*>(data.data()), data.size() },
            self->Socket.got_text());
        }
        self->Incoming.clear();
        self->Read();
      });
  }

  void Write()
  {
    this->Socket.text(true);
    this->Socket.async_write(asio::buffer(this->Outgoing.front()),
      [self = this->shared_from_this()](error_code error, std::size_t)
      {
        if (error)
        {
          self->End(false, error.message());
          return;
        }
        self->Outgoing.pop_front();
        if (!self->Outgoing.empty())
        {
          self->Write();
        }
      });
  }

  void End(bool refused, const std::string& why, double retryAfter = 0)
  {
    const Handlers callbacks = std::exchange(this->Callbacks, {});
    this->Socket.next_layer().Close();
    if (callbacks.onEnd)
    {
      callbacks.onEnd(refused, why, retryAfter);
    }
  }

  ServerUrl Server;
  Handlers Callbacks;
  websocket::stream<ServerStream, false> Socket; // false: no code for compression
  websocket::response_type Answer;
  beast::flat_buffer Incoming;
  std::deque<std::string> Outgoing; // the first one is being written
};

StreamSocket::StreamSocket(asio::io_context& context, const ServerUrl& server,
  std::shared_ptr<asio::ssl::context> tls, Handlers handlers)
  : Kept(std::make_shared<Connection>(context, server, std::move(tls), std::move(handlers)))
{
  this->Kept->Connect();
}

StreamSocket::~StreamSocket()
{
  this->Kept->Close();
}

void StreamSocket::Send(std::string text)
{
  this->Kept->Send(std::move(text));
}

}
