// SPDX-License-Identifier: BSD-3-Clause
#include "server/http/HttpServer.h"

#include "server/http/HttpConnection.h"

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/strand.hpp>

#include <openssl/err.h>
#include <openssl/x509.h>

#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <fstream>
#include <memory>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace kdstream
{

using asio::ip::tcp;

namespace
{

Status CheckReadable(const std::string& file)
{
  if (!std::ifstream(file))
  {
    return Error{ ErrorCode::InputOutput,
      file + ": cannot be read: " + std::generic_category().message(errno) };
  }
  return {};
}

}

// One acceptor; each connection runs on a strand of its own; a few threads run all of them.
struct HttpServer::Implementation
{
  Implementation(const Catalog& catalog, HttpServerOptions options)
    : State(catalog, std::move(options))
    , Context(static_cast<int>(this->State.Options.threads))
    , Tls(asio::ssl::context::tls_server)
    , Working(this->Context.get_executor())
    , Acceptor(this->Context)
    , Pause(this->Context)
  {
  }

  bool IsTls() const { return !this->State.Options.tlsCertificate.empty(); }

  Status PrepareTls();
  Status Listen();
  void StartThreads();
  void Accept() noexcept;
  void OnAccept(beast::error_code error, tcp::socket socket) noexcept;
  void AcceptAfterPause();
  void Serve(tcp::socket socket);
  Admission Admit(const tcp::socket& socket);
  void TurnAway();
  void KeepSpare();
  void Stop(std::chrono::milliseconds drainTimeout);

  // At most so many clients without a seat are answered 503 at a time. Further ones are closed
  // without an answer.
  static constexpr int maximumRefusals = 64;
  static constexpr std::chrono::milliseconds pauseOfAccept{ 100 };

  ServerState State;
  asio::io_context Context;
  asio::ssl::context Tls;
  // Threads wait for work until they are stopped, also while nobody accepts.
  asio::executor_work_guard<asio::io_context::executor_type> Working;
  std::mutex AcceptMutex; // for the next three
  tcp::acceptor Acceptor;
  asio::steady_timer Pause;
  std::weak_ptr<int> Accepting; // lives as long as the handler of the accept that is under way
  std::string Address;
  std::uint16_t Port = 0;
  std::shared_ptr<int> Refusals = std::make_shared<int>(0); // its copies count
  std::vector<std::thread> Threads;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> Spare{ nullptr, nullptr };
};

Status HttpServer::Implementation::PrepareTls()
{
  if (!this->IsTls() && this->State.Options.tlsKey.empty())
  {
    return {};
  }
  boost::system::error_code error;
  const auto& options = this->State.Options;
  this->Tls.set_options(asio::ssl::context::default_workarounds | asio::ssl::context::no_sslv2 |
                          asio::ssl::context::no_sslv3 | asio::ssl::context::no_tlsv1 |
                          asio::ssl::context::no_tlsv1_1,
    error);
  const std::string certificate = options.tlsCertificate.string(), key = options.tlsKey.string();
  KDSTREAM_TRY(CheckReadable(certificate));
  this->Tls.use_certificate_chain_file(certificate, error);
  if (error)
  {
    return Error{ ErrorCode::InvalidInput, certificate + ": holds no certificate in PEM" };
  }
  KDSTREAM_TRY(CheckReadable(key));
  // Without this OpenSSL asks the terminal for the passphrase.
  this->Tls.set_password_callback(
    [](std::size_t, asio::ssl::context::password_purpose) { return std::string(); }, error);
  this->Tls.use_private_key_file(key, asio::ssl::context::pem, error);
  if (error)
  {
    const bool another =
      ERR_GET_REASON(static_cast<unsigned long>(error.value())) == X509_R_KEY_VALUES_MISMATCH;
    return Error{ ErrorCode::InvalidInput,
      key + (another ? ": holds the key of another certificate than " + certificate
                     : ": holds no private key in PEM without a passphrase") };
  }
  return {};
}

Status HttpServer::Implementation::Listen()
{
  const auto& options = this->State.Options;
  if (!TrustedProxies::Parse(options.trustedProxies))
  {
    return Error{ ErrorCode::InvalidArgument,
      "a trusted proxy is an address or a network (10.0.0.0/8)" };
  }
  boost::system::error_code error;
  tcp::resolver resolver(this->Context);
  const auto found = resolver.resolve(options.host, std::to_string(options.port),
    tcp::resolver::passive | tcp::resolver::numeric_service, error);
  if (error || found.empty())
  {
    return Error{ ErrorCode::InvalidArgument, options.host + ": " + error.message() };
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
      options.host + ":" + std::to_string(options.port) + ": " + error.message() };
  }
  const auto local = this->Acceptor.local_endpoint();
  this->Port = local.port();
  this->Address =
    local.address().is_v6() ? "[" + local.address().to_string() + "]" : local.address().to_string();
  return {};
}

void HttpServer::Implementation::StartThreads()
{
  this->KeepSpare();
  this->State.Readers.Start(std::max(1u, this->State.Options.readers));
  this->Accept();
  for (unsigned i = 0; i < std::max(1u, this->State.Options.threads); ++i)
  {
    this->Threads.emplace_back(
      [this]
      {
        // A request that fails (out of memory, mostly) ends its own connection, not the server.
        for (bool done = false; !done;)
        {
          try
          {
            this->Context.run();
            done = true;
          }
          catch (...)
          {
            this->State.LogCaught();
            this->Accept(); // it may have been the accept that failed: its handler is lost then
          }
        }
      });
  }
}

// Makes sure that an accept is under way. Whatever fails leads here: a server that accepts no more
// would be deaf, and nothing would wake it.
void HttpServer::Implementation::Accept() noexcept
{
  for (;;)
  {
    try
    {
      const std::lock_guard lock(this->AcceptMutex);
      if (this->Acceptor.is_open() && this->Accepting.expired())
      {
        auto accepting = std::make_shared<int>();
        this->Accepting = accepting;
        this->Acceptor.async_accept(asio::make_strand(this->Context),
          [this, accepting](beast::error_code error, tcp::socket socket) mutable
          {
            accepting.reset();
            this->OnAccept(error, std::move(socket));
          });
      }
      return;
    }
    catch (...)
    {
      this->State.LogCaught();
    }
    std::this_thread::sleep_for(pauseOfAccept); // there is no memory for a timer either
  }
}

void HttpServer::Implementation::OnAccept(beast::error_code error, tcp::socket socket) noexcept
{
  try
  {
    if (error && error != asio::error::operation_aborted)
    {
      // Out of file descriptors, mostly: wait for some to be given back.
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
      this->Serve(std::move(socket));
    }
  }
  catch (...) // ends this connection, not the server
  {
    this->State.LogCaught();
  }
  this->Accept();
}

void HttpServer::Implementation::AcceptAfterPause()
{
  const std::lock_guard lock(this->AcceptMutex);
  this->Pause.expires_after(pauseOfAccept);
  this->Pause.async_wait([this](beast::error_code) { this->Accept(); });
}

void HttpServer::Implementation::Serve(tcp::socket socket)
{
  auto admission = this->Admit(socket);
  if (admission.refusedWith != 0)
  {
    if (this->Refusals.use_count() > maximumRefusals)
    {
      return;
    }
    admission.refusal = this->Refusals;
  }
  ServeHttp(
    this->IsTls() ? ClientSocket(std::move(socket), this->Tls) : ClientSocket(std::move(socket)),
    this->State, std::move(admission));
}

// A seat of its address first, so that one address takes no others' seats back.
Admission HttpServer::Implementation::Admit(const tcp::socket& socket)
{
  Admission admission;
  beast::error_code error;
  const auto address = socket.remote_endpoint(error).address();
  auto& client = admission.client;
  client.peer = error ? "-" : address.to_string();
  client.address = client.peer;
  client.proxied = this->State.Proxies.Holds(client.peer);
  auto& seat = admission.seat;
  if (!client.proxied)
  {
    seat.ofAddress = this->State.Clients.TakeSeat(client.address);
    if (!seat.ofAddress)
    {
      this->State.Counters.CountRefusal(Metrics::Reason::Address);
      admission.refusedWith = 429;
      return admission;
    }
  }
  seat.ofAll = this->State.TakeSeat();
  if (!seat.ofAll)
  {
    this->State.Counters.ConnectionRefused();
    admission.refusedWith = 503;
  }
  return admission;
}

// The process is out of descriptors: who knocks is turned away at once, by means of the one that is
// kept for this, instead of being left waiting.
void HttpServer::Implementation::TurnAway()
{
  const std::lock_guard lock(this->AcceptMutex);
  this->Spare.reset();
  for (int turned = 0; turned < maximumRefusals; ++turned)
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

void HttpServer::Implementation::KeepSpare()
{
  this->Spare = std::unique_ptr<std::FILE, int (*)(std::FILE*)>(
    std::fopen("/dev/null", "re"), [](std::FILE* file) { return file ? std::fclose(file) : 0; });
}

void HttpServer::Implementation::Stop(std::chrono::milliseconds drainTimeout)
{
  if (this->Threads.empty())
  {
    return;
  }
  {
    const std::lock_guard lock(this->AcceptMutex);
    beast::error_code error;
    this->Acceptor.close(error);
    this->Pause.cancel();
  }
  this->State.Drain();
  this->State.WaitForConnections(drainTimeout);
  this->Context.stop();
  for (auto& thread : this->Threads)
  {
    thread.join();
  }
  this->Threads.clear();
  this->State.Readers.Stop(); // while the sockets of what it holds have their context
}

HttpServer::HttpServer(std::unique_ptr<Implementation> implementation)
  : Server(std::move(implementation))
{
}

HttpServer::~HttpServer()
{
  this->Server->Stop(std::chrono::milliseconds(0));
}

Result<std::unique_ptr<HttpServer>> HttpServer::Start(
  const Catalog& catalog, HttpServerOptions options)
{
  auto implementation = std::make_unique<Implementation>(catalog, std::move(options));
  KDSTREAM_TRY(implementation->PrepareTls());
  KDSTREAM_TRY(implementation->Listen());
  std::unique_ptr<HttpServer> server(new HttpServer(std::move(implementation)));
  server->Server->StartThreads(); // what has started ends with `server`, should one fail
  return server;
}

std::uint16_t HttpServer::Port() const
{
  return this->Server->Port;
}

std::string HttpServer::Url() const
{
  return (this->Server->IsTls() ? "https://" : "http://") + this->Server->Address + ":" +
         std::to_string(this->Server->Port);
}

void HttpServer::Stop()
{
  this->Server->Stop(this->Server->State.Options.drainTimeout);
}

}
