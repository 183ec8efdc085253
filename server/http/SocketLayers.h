// SPDX-License-Identifier: BSD-3-Clause
// What differs between plain sockets and TLS. Internal to the server.
#pragma once

#include "server/http/ClientSocket.h"

#include <boost/beast/core/basic_stream.hpp>

namespace kdstream
{

using TcpStream = beast::basic_stream<asio::ip::tcp, EventLoop>;

// Functions must be called on the socket's executor. Handlers run there, too, but never inside the
// function that they were passed to, except those of Handshake and EndOutput.
class ClientSocket::Layers
{
public:
  virtual ~Layers() = default;
  virtual TcpStream& Lowest() = 0;
  virtual void Handshake(ErrorHandler handler) = 0;
  virtual void EndOutput(ErrorHandler handler) = 0;
  virtual void ReadSome(asio::mutable_buffer buffer, BytesHandler handler) = 0;
  virtual void WriteSome(const Output& buffers, BytesHandler handler) = 0;
};

}
