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

// Whatever fails (memory, descriptors, the connection), the listener begins the next accept: if it
// ever stopped accepting, nothing would wake it again. All functions except Listen may be called
// from any thread.
class Listener
{
public:
  // Chooses the event loop of the next connection.
  using Choose = std::function<EventLoop()>;
  // Serves a connection; its handlers run on the chosen event loop. An exception that this function
  // throws ends the connection.
  using Serve = std::function<void(TcpSocket)>;

  // REQUIRES: context and state outlive the listener; the listener outlives the context's threads.
  Listener(asio::io_context& context, ServerState& state, Choose choose, Serve serve);

  // Errors: InvalidArgument for the host; InputOutput if the port is taken or not allowed.
  Status Listen(const ListenAddress& address);
  // The address where it listens: "127.0.0.1:8700".
  const std::string& Address() const { return this->BoundAddress; }
  // Whether it listens only for this machine.
  bool IsLocal() const { return this->Local; }
  std::uint16_t Port() const { return this->LocalPort; }

  // Makes sure that an accept is in progress.
  void Accept() noexcept;
  void Close();

private:
  static constexpr int mostTurnedAway = 64; // clients that are being refused at a time
  static constexpr std::chrono::milliseconds pauseOfAccept{ 100 };

  void OnAccept(boost::system::error_code error, TcpSocket socket) noexcept;
  void AcceptAfterPause();
  void TurnAway();
  void KeepSpare();

  asio::io_context& Context;
  ServerState& State;
  Choose Loop;
  Serve Take;
  std::mutex Mutex; // for the next three members
  asio::ip::tcp::acceptor Acceptor;
  asio::steady_timer Pause;
  std::weak_ptr<int> Accepting; // lives as long as the handler of the accept that is in progress
  std::string BoundAddress;
  bool Local = false;
  std::uint16_t LocalPort = 0;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> Spare{ nullptr, nullptr };
};

}
