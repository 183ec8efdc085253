// SPDX-License-Identifier: BSD-3-Clause
#include "server/http/ClientSocket.h"

#include "server/http/SocketLayers.h"
#include "server/http/TlsLayers.h"

#include <boost/asio/read.hpp>

namespace kdstream
{

namespace
{

class PlainLayers final : public ClientSocket::Layers
{
public:
  explicit PlainLayers(TcpSocket socket)
    : Socket(std::move(socket))
  {
  }
  TcpStream& Lowest() override { return this->Socket; }
  void Handshake(ClientSocket::ErrorHandler handler) override { handler({}); }
  void EndOutput(ClientSocket::ErrorHandler handler) override
  {
    beast::error_code error;
    this->Socket.socket().shutdown(TcpSocket::shutdown_send, error);
    handler(error);
  }
  void ReadSome(asio::mutable_buffer buffer, ClientSocket::BytesHandler handler) override
  {
    this->Socket.async_read_some(buffer, std::move(handler));
  }
  void WriteSome(const ClientSocket::Output& buffers, ClientSocket::BytesHandler handler) override
  {
    this->Socket.async_write_some(buffers, std::move(handler));
  }

private:
  TcpStream Socket;
};

}

ClientSocket::ClientSocket(TcpSocket socket)
  : Below(std::make_unique<PlainLayers>(std::move(socket)))
{
}

ClientSocket::ClientSocket(TcpSocket socket, ssl_ctx_st& tls, Offload elsewhere)
  : Below(std::make_unique<TlsLayers>(std::move(socket), tls, std::move(elsewhere)))
{
}

ClientSocket::ClientSocket(ClientSocket&&) noexcept = default;
ClientSocket::~ClientSocket() = default;

ClientSocket::executor_type ClientSocket::get_executor() const noexcept
{
  return this->Below->Lowest().get_executor();
}

TcpSocket& ClientSocket::Tcp()
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
  if (this->Below) // if this socket was not moved away
  {
    this->Below->Lowest().close();
  }
}

void ClientSocket::ReadPlain(asio::mutable_buffer buffer, BytesHandler handler)
{
  asio::async_read(this->Below->Lowest(), buffer, std::move(handler));
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

}
