// SPDX-License-Identifier: BSD-3-Clause
#include "server/http/ClientSocket.h"

#include <boost/asio/ssl/context.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/ssl/ssl_stream.hpp>
#include <boost/beast/websocket/ssl.hpp>
#include <boost/beast/websocket/teardown.hpp>

namespace kdstream
{

// What differs between plain and TLS.
class ClientSocket::Layers
{
public:
  virtual ~Layers() = default;
  virtual beast::tcp_stream& Lowest() = 0;
  virtual void Handshake(ErrorHandler handler) = 0;
  virtual void EndOutput(ErrorHandler handler) = 0;
  virtual void ReadSome(asio::mutable_buffer buffer, BytesHandler handler) = 0;
  virtual void WriteSome(const Output& buffers, BytesHandler handler) = 0;
  virtual void TearDown(ErrorHandler handler) = 0;
};

namespace
{

template <class Stream>
class LayersOver : public ClientSocket::Layers
{
public:
  template <class... Arguments>
  explicit LayersOver(asio::ip::tcp::socket socket, Arguments&... arguments)
    : Socket(std::move(socket), arguments...)
  {
  }
  beast::tcp_stream& Lowest() override { return beast::get_lowest_layer(this->Socket); }
  void ReadSome(asio::mutable_buffer buffer, ClientSocket::BytesHandler handler) override
  {
    this->Socket.async_read_some(buffer, std::move(handler));
  }
  void WriteSome(const ClientSocket::Output& buffers, ClientSocket::BytesHandler handler) override
  {
    this->Socket.async_write_some(buffers, std::move(handler));
  }
  void TearDown(ClientSocket::ErrorHandler handler) override
  {
    using beast::websocket::async_teardown;
    async_teardown(beast::role_type::server, this->Socket, std::move(handler));
  }

protected:
  Stream Socket;
};

class PlainLayers : public LayersOver<beast::tcp_stream>
{
public:
  using LayersOver::LayersOver;
  void Handshake(ClientSocket::ErrorHandler handler) override { handler({}); }
  void EndOutput(ClientSocket::ErrorHandler handler) override
  {
    beast::error_code error;
    this->Socket.socket().shutdown(asio::ip::tcp::socket::shutdown_send, error);
    handler(error);
  }
};

class TlsLayers : public LayersOver<beast::ssl_stream<beast::tcp_stream>>
{
public:
  using LayersOver::LayersOver;
  void Handshake(ClientSocket::ErrorHandler handler) override
  {
    this->Socket.async_handshake(asio::ssl::stream_base::server, std::move(handler));
  }
  void EndOutput(ClientSocket::ErrorHandler handler) override
  {
    this->Socket.async_shutdown(std::move(handler));
  }
};

}

ClientSocket::ClientSocket(asio::ip::tcp::socket socket)
  : Below(std::make_unique<PlainLayers>(std::move(socket)))
{
}

ClientSocket::ClientSocket(asio::ip::tcp::socket socket, asio::ssl::context& tls)
  : Below(std::make_unique<TlsLayers>(std::move(socket), tls))
{
}

ClientSocket::ClientSocket(ClientSocket&&) noexcept = default;
ClientSocket::~ClientSocket() = default;

ClientSocket::executor_type ClientSocket::get_executor() const noexcept
{
  return this->Below->Lowest().get_executor();
}

asio::ip::tcp::socket& ClientSocket::Tcp()
{
  return this->Below->Lowest().socket();
}

void ClientSocket::ExpireAfter(std::chrono::milliseconds time)
{
  this->Below->Lowest().expires_after(time);
}

void ClientSocket::ExpireNever()
{
  this->Below->Lowest().expires_never();
}

void ClientSocket::Close()
{
  if (this->Below) // not moved away
  {
    this->Below->Lowest().close();
  }
}

void ClientSocket::Handshake(ErrorHandler handler)
{
  this->Below->Handshake(std::move(handler));
}

void ClientSocket::EndOutput(ErrorHandler handler)
{
  this->Below->EndOutput(std::move(handler));
}

void ClientSocket::ReadSome(asio::mutable_buffer buffer, BytesHandler handler)
{
  this->Below->ReadSome(buffer, std::move(handler));
}

void ClientSocket::WriteSome(const Output& buffers, BytesHandler handler)
{
  this->Below->WriteSome(buffers, std::move(handler));
}

void ClientSocket::TearDown(ErrorHandler handler)
{
  this->Below->TearDown(std::move(handler));
}

}
