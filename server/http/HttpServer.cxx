#include "server/http/HttpServer.h"

#include "server/http/HttpConnection.h"

#include <array>
#include <thread>
#include <vector>

namespace kdstream
{

using asio::ip::tcp;

// Steps: accept in one place, each connection on a strand of its own, all on a few threads.
struct HttpServer::Implementation
{
  Implementation(const Catalog& catalog, HttpServerOptions options)
    : State(catalog, std::move(options))
    , Context(static_cast<int>(this->State.Options.threads))
    , Tls(asio::ssl::context::tls_server)
    , Acceptor(asio::make_strand(this->Context))
    , Pause(this->Acceptor.get_executor())
  {
  }

  bool IsTls() const { return !this->State.Options.tlsCertificate.empty(); }

  Status PrepareTls();
  Status Listen();
  void StartThreads();
  void Accept();
  void Serve(tcp::socket socket);
  void Stop(std::chrono::milliseconds drainTimeout);

  // More clients than there are seats wait for a 503 at once; any beyond that are closed without an
  // answer.
  static constexpr int maximumRefusals = 64;

  ServerState State;
  asio::io_context Context;
  asio::ssl::context Tls;
  tcp::acceptor Acceptor;
  asio::steady_timer Pause;
  std::string Address;
  std::uint16_t Port = 0;
  std::shared_ptr<int> Refusals = std::make_shared<int>(0); // its copies count
  std::vector<std::thread> Threads;
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
  this->Tls.use_certificate_chain_file(options.tlsCertificate.string(), error);
  if (error)
  {
    return Error{ ErrorCode::InvalidInput,
      options.tlsCertificate.string() + ": no certificates in PEM: " + error.message() };
  }
  this->Tls.use_private_key_file(options.tlsKey.string(), asio::ssl::context::pem, error);
  if (error)
  {
    return Error{ ErrorCode::InvalidInput,
      options.tlsKey.string() +
        ": no private key in PEM that fits the certificate: " + error.message() };
  }
  return {};
}

Status HttpServer::Implementation::Listen()
{
  const auto& options = this->State.Options;
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
  this->Accept();
  for (unsigned i = 0; i < std::max(1u, this->State.Options.threads); ++i)
  {
    this->Threads.emplace_back(
      [this]
      {
        // One request that goes wrong (memory, mostly) ends its connection, not the server.
        for (bool done = false; !done;)
        {
          try
          {
            this->Context.run();
            done = true;
          }
          catch (const std::exception& exception)
          {
            this->State.LogError(exception.what());
          }
        }
      });
  }
}

void HttpServer::Implementation::Accept()
{
  this->Acceptor.async_accept(asio::make_strand(this->Context),
    [this](beast::error_code error, tcp::socket socket)
    {
      if (!this->Acceptor.is_open())
      {
        return;
      }
      if (!error)
      {
        this->Serve(std::move(socket));
        this->Accept();
        return;
      }
      // Out of file descriptors, mostly: wait for some to be given back.
      this->State.LogError("a connection cannot be accepted: " + error.message());
      this->Pause.expires_after(std::chrono::milliseconds(100));
      this->Pause.async_wait(
        [this](beast::error_code)
        {
          if (this->Acceptor.is_open())
          {
            this->Accept();
          }
        });
    });
}

void HttpServer::Implementation::Serve(tcp::socket socket)
{
  auto seat = this->State.TakeSeat();
  const bool refused = !seat;
  if (refused && this->Refusals.use_count() > maximumRefusals)
  {
    this->State.Counters.ConnectionRefused();
    return;
  }
  beast::tcp_stream stream(std::move(socket));
  if (this->IsTls())
  {
    std::make_shared<HttpConnection<beast::ssl_stream<beast::tcp_stream>>>(
      beast::ssl_stream<beast::tcp_stream>(std::move(stream), this->Tls), this->State,
      std::move(seat), refused ? this->Refusals : nullptr)
      ->Run();
  }
  else
  {
    std::make_shared<HttpConnection<beast::tcp_stream>>(
      std::move(stream), this->State, std::move(seat), refused ? this->Refusals : nullptr)
      ->Run();
  }
}

void HttpServer::Implementation::Stop(std::chrono::milliseconds drainTimeout)
{
  if (this->Threads.empty())
  {
    return;
  }
  asio::post(this->Acceptor.get_executor(),
    [this]
    {
      beast::error_code error;
      this->Acceptor.close(error);
      this->Pause.cancel();
    });
  this->State.Drain();
  this->State.WaitForConnections(drainTimeout);
  this->Context.stop();
  for (auto& thread : this->Threads)
  {
    thread.join();
  }
  this->Threads.clear();
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
  implementation->StartThreads();
  return std::unique_ptr<HttpServer>(new HttpServer(std::move(implementation)));
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
