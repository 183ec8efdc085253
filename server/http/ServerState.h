// SPDX-License-Identifier: BSD-3-Clause
// What all connections of one server share. Internal to the server.
#pragma once

#include "filters/core/CaughtError.h"
#include "server/http/ClientLimits.h"
#include "server/http/HttpServer.h"
#include "server/http/Metrics.h"
#include "server/http/RareMessages.h"
#include "server/http/Routes.h"
#include "server/http/TlsCertificate.h"
#include "server/http/WorkerPool.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

namespace kdstream
{

// A connection that can be asked to end after the answers in flight. All functions may be called
// from any thread, except protected ones.
//
// Timers end each of a connection's states. A timer might be lost, or never set. So the server's
// reaper (EndOverdue) checks all connections every second, and closes those whose state has lasted
// too long; no slot is lost forever.
class Drainable
{
public:
  using Clock = std::chrono::steady_clock;

  virtual ~Drainable() = default;
  virtual void Drain() = 0;
  // The connection's slot is needed: it ends if its client is still waiting for nothing.
  virtual void GiveUp() = 0;
  // The connection's state should have ended by now: the connection is closed, unless its state has
  // changed meanwhile.
  virtual void EndIfOverdue() = 0;

  // When the connection's slot may be taken back; the end of time while its client waits for
  // something.
  Clock::time_point FreeFrom() const { return Clock::time_point(this->Free.load()); }
  // The connection's slot is about to be taken back: this connection is not chosen again.
  void SetChosen() { this->SetBusy(); }
  // When the connection's state must have ended.
  Clock::time_point End() const { return Clock::time_point(this->EndOfState.load()); }

protected:
  bool IsBusy() const { return this->FreeFrom() == Clock::time_point::max(); }
  void SetBusy() { this->Free = Clock::time_point::max().time_since_epoch(); }
  void SetIdle(Clock::duration before) { this->Free = (Clock::now() + before).time_since_epoch(); }
  void EndBy(Clock::time_point time) { this->EndOfState = time.time_since_epoch(); }

private:
  std::atomic<Clock::duration> Free{ Clock::time_point::max().time_since_epoch() };
  // Until a connection sets this time itself, it has 60 s.
  std::atomic<Clock::duration> EndOfState{
    (Clock::now() + std::chrono::seconds(60)).time_since_epoch()
  };
};

// The client that is served: at the socket's other end, or behind a trusted proxy.
struct Client
{
  std::string peer;    // address of the other end
  std::string address; // address of the client
  bool proxied = false;
};

// A client's slot among all connections, and its slot among those of its address; either may be
// missing.
struct ConnectionSlot
{
  std::shared_ptr<void> ofAll, ofAddress;
};

class ServerState
{
public:
  ServerState(const Catalog& catalog, HttpServerOptions options)
    : Models(catalog)
    , Options(std::move(options))
    , Clients(this->Options.connectionsOfAddress, this->Options.requestsOfAddress)
    , Proxies(TrustedProxies::Parse(this->Options.trustedProxies).value_or(TrustedProxies()))
    , Answers(catalog, Counters,
        RouteOptions{ this->Options.allowOrigin, this->Options.web, this->Options.version,
          !this->Options.admin, [this] { return this->Draining(); }, this->Options.guard,
          this->MakeLedger(), this->Options.lostLines, this->Options.contact })
  {
  }

  const Catalog& Models;
  const HttpServerOptions Options;
  ClientLimits Clients;
  const TrustedProxies Proxies;
  Metrics Counters;
  const Routes Answers;
  TlsCertificate Certificate;
  // Whether the server, and its admin address, listen only for this machine; set before anybody
  // connects.
  bool isLocal = false, isAdminLocal = false;
  WorkerPool Readers{ [this](WorkerPool::Clock::duration waited)
    { this->Counters.CountWait(waited); } };
  // Threads that make tiles and pictures, which takes longer than reading blobs.
  WorkerPool Makers{ [this](WorkerPool::Clock::duration waited)
    { this->Counters.CountWait(waited); } };
  // Threads for requests that count against quotas. The readers do not do this: if another process
  // holds the file of the quotas, only requests that count against a quota wait.
  WorkerPool Takers{ [this](WorkerPool::Clock::duration waited)
    { this->Counters.CountWait(waited); } };
  // Threads for TLS handshakes. The readers do not do this: so a hanging disk does not stop new
  // connections.
  WorkerPool Handshakes;

  bool IsTls() const { return !this->Options.tlsCertificate.empty(); }

  // How long a client may take to receive this number of bytes.
  std::chrono::milliseconds PatienceFor(std::size_t bytes) const
  {
    return this->Options.answerTimeout +
           std::chrono::seconds(bytes / std::max<std::size_t>(1, this->Options.slowestBytes));
  }

  // A line that cannot be written is lost: nothing else may fail because of a log.
  void Log(const AccessRecord& record) noexcept
  {
    if (this->Options.onAccess)
    {
      this->WriteLog([&] { this->Options.onAccess(record); });
    }
  }
  // Reports the same error at most once a minute, together with how often it has occurred.
  void LogError(std::string_view message) noexcept
  {
    if (this->Options.onError)
    {
      this->WriteLog(
        [&]
        {
          if (const auto text = this->Errors.Take(message))
          {
            this->Options.onError(*text);
          }
        });
    }
  }

  // Logs the exception that is being handled; `what` says what it has ended.
  void LogCaught(const char* what) noexcept
  {
    std::string text;
    try
    {
      text = what + (": " + CaughtError().message);
    }
    catch (...) // no memory to say more
    {
    }
    this->LogError(text.empty() ? "out of memory" : std::string_view(text));
  }

  // Runs a connection's handler. An exception, mostly lack of memory, is logged and ends only that
  // connection.
  template <class Work, class Close>
  void Guard(const Work& work, const Close& close) noexcept
  {
    try
    {
      work();
    }
    catch (...)
    {
      this->Counters.CountFailure(Metrics::Failure::Connection);
      this->LogCaught("a connection was closed after an error");
      close();
    }
  }

  // Runs the task on a reader. If the task counts against a quota, or takes much computing
  // (isMade), it runs on one of the threads for that. The task must not throw.
  void Read(bool takes, WorkerPool::Task task, bool isMade = false)
  {
    auto& pool = takes && this->Options.quotas ? this->Takers
                 : isMade                      ? this->Makers
                                               : this->Readers;
    this->Counters.CountWaiting(pool.Add(std::move(task)));
  }
  // Counts a read that was given up.
  void CountGivenUp()
  {
    this->Counters.CountFailure(Metrics::Failure::Disk);
    this->LogError("a disk does not respond: clients that wait for it are asked to try again");
  }
  // Runs the work on one of the threads for handshakes.
  void ShakeHands(WorkerPool::Work work)
  {
    this->Handshakes.Add({ [this, work = std::move(work)] { this->Guard(work, [] {}); } });
  }

  // Returns the answer; if making it throws (lack of memory), an error as the answer.
  template <class Work>
  std::optional<HttpResponse> Caught(const Work& answer)
  {
    try
    {
      return answer();
    }
    catch (...)
    {
      this->Counters.CountFailure(Metrics::Failure::Answer);
      this->LogCaught("a request was not answered");
      return this->Answers.Failure(503, "the server is out of memory");
    }
  }

  bool Draining() const { return this->Drains; }

  // Asks every open connection, and every later one, to end after the answers in flight.
  void Drain()
  {
    this->Drains = true;
    std::vector<std::shared_ptr<Drainable>> connections;
    {
      const std::lock_guard lock(this->Mutex);
      // Reserved, so that nothing throws below, where connections are held: the end of a connection
      // takes the lock.
      connections.reserve(this->Connections.size());
      for (const auto& entry : this->Connections)
      {
        if (auto connection = entry.second.lock())
        {
          connections.push_back(std::move(connection));
        }
      }
    }
    for (const auto& connection : connections)
    {
      connection->Drain();
    }
  }
  // Closes the connections whose state has lasted too long; their own timers should have done this.
  // Throws std::bad_alloc, before anything has changed.
  void EndOverdue()
  {
    std::vector<std::shared_ptr<Drainable>> overdue;
    // The connections' own timers get half a second first.
    const auto now = Drainable::Clock::now() - std::chrono::milliseconds(500);
    {
      const std::lock_guard lock(this->Mutex);
      const auto isOverdue = [now](const auto& entry) { return entry.first->End() <= now; };
      // Reserved, so that nothing throws below, where connections are held: the end of a connection
      // takes the lock.
      overdue.reserve(static_cast<std::size_t>(
        std::count_if(this->Connections.begin(), this->Connections.end(), isOverdue)));
      for (const auto& entry : this->Connections)
      {
        auto connection =
          overdue.size() < overdue.capacity() && isOverdue(entry) ? entry.second.lock() : nullptr;
        if (connection)
        {
          overdue.push_back(std::move(connection));
        }
      }
    }
    for (const auto& connection : overdue)
    {
      connection->EndIfOverdue();
    }
  }
  bool WaitForConnections(std::chrono::milliseconds timeout)
  {
    std::unique_lock lock(this->Mutex);
    return this->Changed.wait_for(lock, timeout, [this] { return this->Count == 0; });
  }

  // A connection slot among maximumConnections, held while a client is connected. Null if all slots
  // are taken, and no idle connection can give one back.
  std::shared_ptr<void> TakeSlot()
  {
    std::shared_ptr<Drainable> idle;
    {
      const std::lock_guard lock(this->Mutex);
      if (this->Count >= this->Options.maximumConnections)
      {
        idle = this->TakeIdle();
        if (!idle)
        {
          return nullptr;
        }
      }
      ++this->Count;
    }
    if (idle)
    {
      this->Counters.CountRefusal(Metrics::Reason::Idle);
      idle->GiveUp();
    }
    this->Counters.ConnectionOpened();
    // The lock is released first, because the deleter takes it: if there is no memory for the
    // shared_ptr, the deleter is called at once.
    return std::shared_ptr<void>(
      this, [](void* state) { static_cast<ServerState*>(state)->GiveSlotBack(); });
  }

  void Enter(const std::shared_ptr<Drainable>& connection)
  {
    {
      const std::lock_guard lock(this->Mutex);
      this->Connections[connection.get()] = connection;
    }
    if (this->Drains)
    {
      connection->Drain();
    }
  }
  void Leave(const Drainable* connection)
  {
    const std::lock_guard lock(this->Mutex);
    this->Connections.erase(connection);
  }

private:
  // The ledger of partitions that clients get; null if there are neither quotas nor a log of
  // partitions.
  std::shared_ptr<const PartitionLedger> MakeLedger()
  {
    if (!this->Options.quotas && !this->Options.onPartition)
    {
      return nullptr;
    }
    PartitionLedger::OnPartition tell;
    if (this->Options.onPartition)
    {
      tell = [this](const PartitionRecord& record)
      { this->WriteLog([&] { this->Options.onPartition(record); }); };
    }
    return std::make_shared<PartitionLedger>(
      this->Options.quotas, std::move(tell),
      [this] { this->Counters.CountRefusal(Metrics::Reason::Quota); },
      [this](const std::string& what, bool isNew)
      {
        this->Counters.CountFailure(Metrics::Failure::Quota);
        if (isNew)
        {
          this->LogError(what);
        }
      });
  }

  // The connection that has been idle for longest; null if none may be ended yet. The caller holds
  // the lock.
  std::shared_ptr<Drainable> TakeIdle()
  {
    auto first = Drainable::Clock::now();
    auto chosen = this->Connections.end();
    for (auto each = this->Connections.begin(); each != this->Connections.end(); ++each)
    {
      if (each->first->FreeFrom() <= first)
      {
        first = each->first->FreeFrom();
        chosen = each;
      }
    }
    if (chosen == this->Connections.end())
    {
      return nullptr;
    }
    auto connection = chosen->second.lock();
    if (connection)
    {
      connection->SetChosen();
    }
    return connection;
  }

  template <class Write>
  void WriteLog(const Write& write) noexcept
  {
    const std::lock_guard lock(this->LogMutex);
    try
    {
      write();
    }
    catch (...)
    {
    }
  }
  void GiveSlotBack()
  {
    this->Counters.ConnectionClosed();
    const std::lock_guard lock(this->Mutex);
    --this->Count;
    this->Changed.notify_all();
  }

  std::mutex Mutex;
  std::mutex LogMutex; // for Errors, and for writing logs
  RareMessages Errors;
  std::condition_variable Changed;
  std::unordered_map<const Drainable*, std::weak_ptr<Drainable>> Connections;
  std::size_t Count = 0;
  std::atomic<bool> Drains{ false };
};

}
