// SPDX-License-Identifier: BSD-3-Clause
// Accepts connections at one address. Internal to the server.
#pragma once

#include "server/http/ClientSocket.h"
#include "server/http/HttpServer.h"
#include "server/http/ServerState.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>

#include <cstdint>
#include <cstdio>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

namespace kdstream
{

// Whatever fails (memory, descriptors, the connection), the next accept follows: a server that
// stopped accepting would never be woken again. Functions: from any thread, except Listen.
class Listener
{
public:
  // The event loop of the next connection.
  using Choose = std::function<EventLoop()>;
  // Takes a connection, whose handlers run on that. What it throws ends that connection.
  using Serve = std::function<void(TcpSocket)>;

  // REQUIRES: context and state outlive the listener, which outlives the context's threads.
  Listener(asio::io_context& context, ServerState& state, Choose choose, Serve serve);

  // Errors: InvalidArgument for the host; InputOutput where the port is taken or not allowed.
  Status Listen(const ListenAddress& address);
  // "127.0.0.1:8700": where it listens.
  const std::string& Address() const { return this->BoundAddress; }
  // Whether it listens only for this machine.
  bool IsLocal() const { return this->Local; }
  std::uint16_t Port() const { return this->LocalPort; }

  // Makes sure that an accept is in progress.
  void Accept() noexcept;
  void Close();

private:
  static constexpr int mostTurnedAway = 64; // at once
  static constexpr std::chrono::milliseconds pauseOfAccept{ 100 };

  void OnAccept(boost::system::error_code error, TcpSocket socket) noexcept;
  void AcceptAfterPause();
  void TurnAway();
  void KeepSpare();

  asio::io_context& Context;
  ServerState& State;
  Choose Loop;
  Serve Take;
  std::mutex Mutex; // for the next three
  asio::ip::tcp::acceptor Acceptor;
  asio::steady_timer Pause;
  std::weak_ptr<int> Accepting; // lives as long as the handler of the accept that is in progress
  std::string BoundAddress;
  bool Local = false;
  std::uint16_t LocalPort = 0;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> Spare{ nullptr, nullptr };
};

}
