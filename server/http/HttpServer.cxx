// SPDX-License-Identifier: BSD-3-Clause
#include "server/http/HttpServer.h"

#include "server/http/HttpConnection.h"
#include "server/http/Listener.h"

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

namespace kdstream
{

bool IsNetwork(const std::string& text)
{
  return TrustedProxies::Parse({ text }).has_value();
}

// Has one listener, or two, on the first of a few event loops. Each loop has its own thread.
// Connections are distributed over the loops in turn.
struct HttpServer::Implementation
{
  struct Loop
  {
    asio::io_context context{ 1 };
    // Keeps the loop's thread waiting for work, even if there are no connections, until it is
    // stopped.
    asio::executor_work_guard<EventLoop> working{ context.get_executor() };
  };

  Implementation(const Catalog& catalog, HttpServerOptions options)
    : State(catalog, std::move(options))
    , Others(std::max(1u, this->State.Options.threads) - 1)
    , Public(
        this->First.context, this->State, [this] { return this->Choose(); },
        [this](TcpSocket socket) { this->Serve(std::move(socket)); })
    , Admin(
        this->First.context, this->State, [this] { return this->Choose(); },
        [this](TcpSocket socket) { this->ServeAdmin(std::move(socket)); })
  {
  }

  EventLoop Choose() noexcept
  {
    const std::size_t turn = this->Turn++ % (this->Others.size() + 1);
    return (turn == 0 ? this->First : this->Others[turn - 1]).context.get_executor();
  }
  Status Prepare();
  Status LoadCertificate();
  void StartThreads();
  void Run(Loop& loop) noexcept;
  void Reap() noexcept;
  void Serve(TcpSocket socket);
  void ServeAdmin(TcpSocket socket);
  ClientSocket Wrap(TcpSocket socket);
  Admission Admit(const TcpSocket& socket);
  void StopLoops(std::chrono::milliseconds drainTimeout);
  bool StopPools(std::optional<std::chrono::milliseconds> patience);

  // Whether another connection may join those that are served without a connection slot.
  bool MayJoin(const std::shared_ptr<int>& others) const
  {
    return static_cast<std::size_t>(others.use_count()) <= this->State.Options.extraConnections;
  }

  ServerState State;
  std::atomic<std::size_t> Turn{ 0 };
  std::vector<Loop> Others;
  Loop First; // destroyed first: it may be accepting for another loop
  Listener Public, Admin;
  std::shared_ptr<int> Refusals = std::make_shared<int>(0); // the number of copies counts
  std::shared_ptr<int> Administrators = std::make_shared<int>(0);
  std::vector<std::thread> Threads;
  std::thread Reaper; // not on an event loop, so that lack of memory there cannot stop it
  std::mutex ReaperMutex;
  std::condition_variable ReaperIsDone;
  bool Stopping = false; // guarded by ReaperMutex
};

Status HttpServer::Implementation::Prepare()
{
  const auto& options = this->State.Options;
  const auto& proxies = options.trustedProxies;
  if (const auto wrong = std::find_if_not(proxies.begin(), proxies.end(), IsNetwork);
      wrong != proxies.end())
  {
    return Error{ ErrorCode::InvalidArgument,
      *wrong + " is not the address or network of a proxy" };
  }
  KDSTREAM_TRY(this->LoadCertificate());
  KDSTREAM_TRY(this->Public.Listen(options.address));
  KDSTREAM_TRY(options.admin ? this->Admin.Listen(*options.admin) : Status{});
  this->State.isLocal = this->Public.IsLocal();
  this->State.isAdminLocal = this->Admin.IsLocal();
  return {};
}

Status HttpServer::Implementation::LoadCertificate()
{
  const auto& options = this->State.Options;
  const bool isPlain = options.tlsCertificate.empty() && options.tlsKey.empty();
  return isPlain ? Status{} : this->State.Certificate.Load(options.tlsCertificate, options.tlsKey);
}

void HttpServer::Implementation::StartThreads()
{
  const auto& options = this->State.Options;
  const unsigned threads = std::max(1u, options.threads);
  WorkerPool::Limits limits;
  limits.patience = options.answerTimeout;
  this->State.Readers.Start(std::max(1u, options.readers), limits);
  this->State.Makers.Start(options.Makers(), limits);
  if (options.quotas)
  {
    this->State.Takers.Start(std::max(1u, options.readers), limits);
  }
  if (this->State.IsTls())
  {
    // Fewer threads than those that answer: however many new connections there are, some processors
    // are left for existing ones.
    this->State.Handshakes.Start(std::max(1u, threads / 2));
  }
  this->Public.Accept();
  this->Admin.Accept();
  this->Reaper = std::thread([this] { this->Reap(); });
  this->Threads.emplace_back([this] { this->Run(this->First); });
  for (auto& loop : this->Others)
  {
    this->Threads.emplace_back([this, &loop] { this->Run(loop); });
  }
}

// A request that fails (mostly out of memory) ends its own connection, not the server.
void HttpServer::Implementation::Run(Loop& loop) noexcept
{
  for (bool done = false; !done;)
  {
    try
    {
      loop.context.run();
      done = true;
    }
    catch (...)
    {
      this->State.Counters.CountFailure(Metrics::Failure::Connection);
      this->State.LogCaught("a connection was closed after an error");
      this->Public.Accept(); // if an accept failed, its handler was lost
      this->Admin.Accept();
    }
  }
}

// Once a second, ends connections whose own timers should have ended them.
void HttpServer::Implementation::Reap() noexcept
{
  constexpr std::chrono::seconds interval{ 1 };
  std::unique_lock lock(this->ReaperMutex);
  while (!this->ReaperIsDone.wait_for(lock, interval, [this] { return this->Stopping; }))
  {
    try
    {
      this->State.EndOverdue();
    }
    catch (...) // no memory: tried again the next time
    {
    }
  }
}

void HttpServer::Implementation::Serve(TcpSocket socket)
{
  auto admission = this->Admit(socket);
  if (admission.refusedWith != 0)
  {
    if (!this->MayJoin(this->Refusals))
    {
      return;
    }
    admission.refusal = this->Refusals;
  }
  ServeHttp(this->Wrap(std::move(socket)), this->State, std::move(admission));
}

ClientSocket HttpServer::Implementation::Wrap(TcpSocket socket)
{
  if (!this->State.IsTls())
  {
    return ClientSocket(std::move(socket));
  }
  return ClientSocket(std::move(socket), *this->State.Certificate.Current(),
    [this](WorkerPool::Work work) { this->State.ShakeHands(std::move(work)); });
}

void HttpServer::Implementation::ServeAdmin(TcpSocket socket)
{
  if (this->MayJoin(this->Administrators))
  {
    Admission admission;
    admission.isAdmin = true;
    admission.refusal = this->Administrators;
    ServeHttp(ClientSocket(std::move(socket)), this->State, std::move(admission));
  }
}

// Takes the address's connection slot before one of all slots, so that one address cannot take back
// the slots of others.
Admission HttpServer::Implementation::Admit(const TcpSocket& socket)
{
  Admission admission;
  beast::error_code error;
  const auto address = socket.remote_endpoint(error).address();
  auto& client = admission.client;
  client.peer = error ? "-" : PlainAddress(address.to_string());
  client.address = client.peer;
  client.proxied = this->State.Proxies.Holds(client.peer);
  admission.isIntroduced = client.proxied && this->State.Options.proxyProtocol;
  if (this->State.Draining())
  {
    admission.refusedWith = 503;
    return admission;
  }
  auto& slot = admission.slot;
  if (!client.proxied)
  {
    slot.ofAddress = this->State.Clients.TakeSlot(client.address);
    if (!slot.ofAddress)
    {
      this->State.Counters.CountRefusal(Metrics::Reason::Address);
      admission.refusedWith = 429;
      return admission;
    }
  }
  slot.ofAll = this->State.TakeSlot();
  if (!slot.ofAll)
  {
    this->State.Counters.ConnectionRefused();
    admission.refusedWith = 503;
  }
  return admission;
}

void HttpServer::Implementation::StopLoops(std::chrono::milliseconds drainTimeout)
{
  if (!this->Reaper.joinable())
  {
    return;
  }
  this->State.Drain();
  this->State.WaitForConnections(drainTimeout);
  this->Public.Close();
  this->Admin.Close();
  {
    const std::lock_guard lock(this->ReaperMutex);
    this->Stopping = true;
  }
  this->ReaperIsDone.notify_all();
  this->Reaper.join();
  this->First.context.stop();
  for (auto& loop : this->Others)
  {
    loop.context.stop();
  }
  for (auto& thread : this->Threads)
  {
    thread.join();
  }
  this->Threads.clear();
}

// Stops the pools. Call this while the event loops exist, because sockets that the pools hold need
// them. False if a disk blocks one of the pools' threads for longer than `patience`.
bool HttpServer::Implementation::StopPools(std::optional<std::chrono::milliseconds> patience)
{
  const auto until = WorkerPool::Clock::now() + patience.value_or(std::chrono::milliseconds(0));
  bool stopped = true;
  for (auto* pool :
    { &this->State.Readers, &this->State.Makers, &this->State.Takers, &this->State.Handshakes })
  {
    if (!patience)
    {
      pool->Stop();
    }
    else if (!pool->Stop(std::max({}, until - WorkerPool::Clock::now())))
    {
      stopped = false;
    }
  }
  return stopped;
}

HttpServer::HttpServer(std::unique_ptr<Implementation> implementation)
  : Server(std::move(implementation))
{
}

HttpServer::~HttpServer()
{
  this->Server->StopLoops(std::chrono::milliseconds(0));
  this->Server->StopPools(std::nullopt);
}

Result<std::unique_ptr<HttpServer>> HttpServer::Start(
  const Catalog& catalog, HttpServerOptions options)
{
  auto implementation = std::make_unique<Implementation>(catalog, std::move(options));
  KDSTREAM_TRY(implementation->Prepare());
  std::unique_ptr<HttpServer> server(new HttpServer(std::move(implementation)));
  server->Server->StartThreads(); // if one fails, the started threads end with `server`
  return server;
}

std::uint16_t HttpServer::Port() const
{
  return this->Server->Public.Port();
}

std::string HttpServer::Url() const
{
  return (this->Server->State.IsTls() ? "https://" : "http://") + this->Server->Public.Address();
}

std::string HttpServer::AdminUrl() const
{
  return this->Server->State.Options.admin ? "http://" + this->Server->Admin.Address() : "";
}

Status HttpServer::ReloadTls()
{
  return this->Server->LoadCertificate();
}

void HttpServer::BeginDrain()
{
  this->Server->State.Drain();
}

bool HttpServer::WaitUntilDrained(std::chrono::milliseconds time)
{
  return this->Server->State.WaitForConnections(time);
}

void HttpServer::Stop()
{
  this->Server->StopLoops(this->Server->State.Options.drainTimeout);
  this->Server->StopPools(std::nullopt);
}

bool HttpServer::StopWithin(std::chrono::milliseconds patience)
{
  this->Server->StopLoops(std::chrono::milliseconds(0));
  return this->Server->StopPools(patience);
}

}
