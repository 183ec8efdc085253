// SPDX-License-Identifier: BSD-3-Clause
#include "server/http/Listener.h"

#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <thread>
#include <utility>

namespace kdstream
{

using asio::ip::tcp;

Listener::Listener(asio::io_context& context, ServerState& state, Choose choose, Serve serve)
  : Context(context)
  , State(state)
  , Loop(std::move(choose))
  , Take(std::move(serve))
  , Acceptor(context)
  , Pause(context)
{
}

Status Listener::Listen(const ListenAddress& address)
{
  boost::system::error_code error;
  tcp::resolver resolver(this->Context);
  const auto found = resolver.resolve(address.host, std::to_string(address.port),
    tcp::resolver::passive | tcp::resolver::numeric_service, error);
  if (error || found.empty())
  {
    return Error{ ErrorCode::InvalidArgument, address.host + ": " + error.message() };
  }
  const auto endpoint = found.begin()->endpoint();
  this->Acceptor.open(endpoint.protocol(), error);
  if (!error)
  {
    this->Acceptor.set_option(asio::socket_base::reuse_address(true), error);
  }
  if (!error)
  {
    this->Acceptor.bind(endpoint, error);
  }
  if (!error)
  {
    this->Acceptor.listen(asio::socket_base::max_listen_connections, error);
  }
  if (error)
  {
    return Error{ ErrorCode::InputOutput,
      address.host + ":" + std::to_string(address.port) + ": " + error.message() };
  }
  const auto local = this->Acceptor.local_endpoint();
  const auto host = local.address().to_string();
  this->LocalPort = local.port();
  this->Local = local.address().is_loopback();
  this->BoundAddress =
    (local.address().is_v6() ? "[" + host + "]" : host) + ":" + std::to_string(this->LocalPort);
  this->KeepSpare();
  return {};
}

void Listener::Accept() noexcept
{
  for (;;)
  {
    try
    {
      const std::lock_guard lock(this->Mutex);
      if (this->Acceptor.is_open() && this->Accepting.expired())
      {
        auto accepting = std::make_shared<int>();
        this->Accepting = accepting;
        this->Acceptor.async_accept(this->Loop(),
          [this, accepting](beast::error_code error, TcpSocket socket) mutable
          {
            accepting.reset();
            this->OnAccept(error, std::move(socket));
          });
      }
      return;
    }
    catch (...)
    {
      this->State.Counters.CountFailure(Metrics::Failure::Accept);
      this->State.LogCaught("a connection cannot be accepted");
    }
    std::this_thread::sleep_for(pauseOfAccept); // no memory for a timer either
  }
}

void Listener::OnAccept(beast::error_code error, TcpSocket socket) noexcept
{
  try
  {
    if (error && error != asio::error::operation_aborted)
    {
      // Mostly the process is out of file descriptors: waits until some are released.
      this->State.Counters.CountFailure(Metrics::Failure::Accept);
      this->State.LogError("a connection cannot be accepted: " + error.message());
      if (error.value() == EMFILE || error.value() == ENFILE)
      {
        this->TurnAway();
      }
      this->AcceptAfterPause();
      return;
    }
    if (!error)
    {
      this->Take(std::move(socket));
    }
  }
  catch (...) // ends this connection, not the server
  {
    this->State.Counters.CountFailure(Metrics::Failure::Connection);
    this->State.LogCaught("a connection was closed after an error");
  }
  this->Accept();
}

void Listener::AcceptAfterPause()
{
  const std::lock_guard lock(this->Mutex);
  this->Pause.expires_after(pauseOfAccept);
  this->Pause.async_wait([this](beast::error_code) { this->Accept(); });
}

// The process is out of descriptors. Uses the descriptor that is reserved for this case to
// disconnect new clients at once, instead of letting them wait.
void Listener::TurnAway()
{
  const std::lock_guard lock(this->Mutex);
  this->Spare.reset();
  for (int turned = 0; turned < mostTurnedAway; ++turned)
  {
    const int client = !this->Acceptor.is_open() ? -1
                                                 : ::accept4(this->Acceptor.native_handle(),
                                                     nullptr, nullptr, SOCK_CLOEXEC);
    if (client < 0)
    {
      break;
    }
    ::close(client);
    this->State.Counters.CountRefusal(Metrics::Reason::Descriptors);
  }
  this->KeepSpare();
}

void Listener::KeepSpare()
{
  this->Spare = std::unique_ptr<std::FILE, int (*)(std::FILE*)>(
    std::fopen("/dev/null", "re"), [](std::FILE* file) { return file ? std::fclose(file) : 0; });
}

void Listener::Close()
{
  const std::lock_guard lock(this->Mutex);
  beast::error_code error;
  this->Acceptor.close(error);
  this->Pause.cancel();
}

}
