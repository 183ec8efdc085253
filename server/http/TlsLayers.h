// SPDX-License-Identifier: BSD-3-Clause
// A ClientSocket's bytes through TLS: part of step "serve" of the pipeline picture. Internal.
#pragma once

#include "server/http/ClientSocket.h"
#include "server/http/SocketLayers.h"
#include "server/http/TlsEngine.h"

#include <array>
#include <memory>
#include <vector>

namespace kdstream
{

// A read and a write may be in progress at the same time, as in a WebSocket. Both may have
// something to send, but the socket sends one thing at a time. Every handler waits until everything
// has been sent, so that nothing accumulates for a client that does not read.
class TlsLayers final : public ClientSocket::Layers
{
public:
  TlsLayers(TcpSocket socket, ssl_ctx_st& context, ClientSocket::Offload offload);

  TcpStream& Lowest() override { return this->Socket; }
  void Handshake(ClientSocket::ErrorHandler handler) override;
  void EndOutput(ClientSocket::ErrorHandler handler) override;
  void ReadSome(asio::mutable_buffer buffer, ClientSocket::BytesHandler handler) override;
  void WriteSome(const ClientSocket::Output& buffers, ClientSocket::BytesHandler handler) override;

private:
  using Outcome = TlsEngine::Outcome;
  struct ShakingHands;
  void Shake(const std::shared_ptr<ShakingHands>& hands);
  void GoOnShaking(const std::shared_ptr<ShakingHands>& hands);
  void Receive(ClientSocket::ErrorHandler handler);
  void Flush(ClientSocket::ErrorHandler handler);
  using Handlers = std::vector<ClientSocket::ErrorHandler>;
  void SendNext(std::shared_ptr<Handlers> untilAllIsSent);

  TcpStream Socket;
  TlsEngine Engine;
  ClientSocket::Offload Elsewhere;
  std::array<char, 16384> Arrived{};
  std::vector<char> Leaving; // what is being sent, if anything
  // Called when everything has been sent. Only the send operation owns these handlers: they own the
  // connection, which owns this object.
  std::weak_ptr<Handlers> UntilAllIsSent;
};

}
