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

// A connection that can be asked to end when it has answered what is in flight. Functions: from any
// thread, except protected ones.
//
// Timers end each of a connection's states. If a timer is lost or was never set, the server's
// reaper (EndOverdue), which checks all connections every second, closes the connection; so no slot
// is lost forever.
class Drainable
{
public:
  using Clock = std::chrono::steady_clock;

  virtual ~Drainable() = default;
  virtual void Drain() = 0;
  // Its slot is needed: it ends if its client still waits for nothing.
  virtual void GiveUp() = 0;
  // Its state should have ended by now: it is closed, unless it has gone on meanwhile.
  virtual void EndIfOverdue() = 0;

  // When its slot may be taken back; the end of time while its client waits for something.
  Clock::time_point FreeFrom() const { return Clock::time_point(this->Free.load()); }
  // Its slot is about to be taken back: it is not chosen again.
  void SetChosen() { this->SetBusy(); }
  // When its state ends at the latest.
  Clock::time_point End() const { return Clock::time_point(this->EndOfState.load()); }

protected:
  bool IsBusy() const { return this->FreeFrom() == Clock::time_point::max(); }
  void SetBusy() { this->Free = Clock::time_point::max().time_since_epoch(); }
  void SetIdle(Clock::duration before) { this->Free = (Clock::now() + before).time_since_epoch(); }
  void EndBy(Clock::time_point time) { this->EndOfState = time.time_since_epoch(); }

private:
  std::atomic<Clock::duration> Free{ Clock::time_point::max().time_since_epoch() };
  // At first, the time that any connection may take to set it.
  std::atomic<Clock::duration> EndOfState{
    (Clock::now() + std::chrono::seconds(60)).time_since_epoch()
  };
};

// The address that is served: the socket's other end, or the client of a trusted proxy.
struct Client
{
  std::string peer;    // address of the other end
  std::string address; // of the client
  bool proxied = false;
};

// A client's place among all, and among those of its address; either may be missing.
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
  // Whether they listen only for this machine; set before anybody connects.
  bool isLocal = false, isAdminLocal = false;
  WorkerPool Readers{ [this](WorkerPool::Clock::duration waited)
    { this->Counters.CountWait(waited); } };
  // Threads for what takes long to make of blobs: tiles, pictures.
  WorkerPool Makers{ [this](WorkerPool::Clock::duration waited)
    { this->Counters.CountWait(waited); } };
  // Threads for what counts against quotas. Not the readers: if another process holds the quotas'
  // file, only requests that take of a quota wait.
  WorkerPool Takers{ [this](WorkerPool::Clock::duration waited)
    { this->Counters.CountWait(waited); } };
  // Threads for TLS handshakes, not the readers: a hanging disk does not stop new connections.
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
  // The same error is reported once a minute at most, with how often it has come.
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

  // The exception that is being handled, which has ended what `what` says.
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

  // Runs the task on one of the readers, or, if it takes of a quota or takes long to make, on a
  // thread for that. The task must not throw.
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
  // Has one of the threads for handshakes do it.
  void ShakeHands(WorkerPool::Work work)
  {
    this->Handshakes.Add({ [this, work = std::move(work)] { this->Guard(work, [] {}); } });
  }

  // An answer, or an error for lack of memory.
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

  // Drains every connection that there is, and every one that is still to come.
  void Drain()
  {
    this->Drains = true;
    std::vector<std::shared_ptr<Drainable>> connections;
    {
      const std::lock_guard lock(this->Mutex);
      // So that nothing throws below: the end of a connection takes the lock.
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
  // Closes the connections that are in a state for longer than it may last: their own timers should
  // have done this. Throws std::bad_alloc, before anything has changed.
  void EndOverdue()
  {
    std::vector<std::shared_ptr<Drainable>> overdue;
    // Their timers come first.
    const auto now = Drainable::Clock::now() - std::chrono::milliseconds(500);
    {
      const std::lock_guard lock(this->Mutex);
      const auto isOverdue = [now](const auto& entry) { return entry.first->End() <= now; };
      // So that nothing throws below: the end of a connection takes the lock.
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

  // A connection slot among maximumConnections, held while a client is connected; null if all are
  // taken, and no idle connection can give one back.
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
    // Not under the lock, because the deleter takes it: if there is no memory for the shared_ptr,
    // the deleter is called at once.
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
  // null if nobody asks for the log of partitions.
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

  // The connection that has been idle for longest; null if none may be ended yet. The lock is held.
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
  std::mutex LogMutex; // for Errors too
  RareMessages Errors;
  std::condition_variable Changed;
  std::unordered_map<const Drainable*, std::weak_ptr<Drainable>> Connections;
  std::size_t Count = 0;
  std::atomic<bool> Drains{ false };
};

}
