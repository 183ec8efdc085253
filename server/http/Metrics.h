// SPDX-License-Identifier: BSD-3-Clause
// Counters of a server, and their text for /metrics (Prometheus text format). All functions may be
// called from any thread.
#pragma once

#include "server/session/Catalog.h"

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>

namespace kdstream
{

// How often something took how long.
class Histogram
{
public:
  static constexpr std::array<double, 11> bounds{ 0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.1,
    0.5, 1, 5, 30 }; // seconds

  void Count(std::chrono::steady_clock::duration time);
  void Write(std::string& text, const char* name, const char* help) const;

private:
  std::array<std::atomic<std::uint64_t>, bounds.size() + 1> Counts{};
  std::atomic<std::uint64_t> Nanoseconds{ 0 };
};

class Metrics
{
public:
  void CountRequest(unsigned status);
  void CountBytes(std::uint64_t bytes) { this->SentBytes += bytes; }
  void ConnectionOpened() { ++this->OpenConnections; }
  void ConnectionClosed() { --this->OpenConnections; }
  void ConnectionRefused() { ++this->RefusedConnections; }
  // Why a client was refused or dropped.
  enum class Reason
  {
    Address,     // too many connections of its address
    Requests,    // too many requests a minute
    Host,        // it named another host
    Slow,        // it took too little
    Idle,        // its seat was needed
    Descriptors, // the process has no more files
    Count
  };
  void CountRefusal(Reason reason) { ++this->Refusals[static_cast<std::size_t>(reason)]; }
  void StreamOpened()
  {
    ++this->OpenStreams;
    ++this->TotalStreams;
  }
  void StreamClosed() { --this->OpenStreams; }
  void CountFailedBlob() { ++this->FailedBlobs; }
  // A request waits for a reader; one has got it, after so long.
  void CountWaiting() { ++this->Queued; }
  void CountWait(std::chrono::steady_clock::duration time)
  {
    ++this->Begun;
    this->Waits.Count(time);
  }

  std::string Text(const CacheUse& memory) const;

private:
  using Counter = std::atomic<std::uint64_t>;
  std::array<Counter, 600> Requests{}; // by status
  std::array<Counter, static_cast<std::size_t>(Reason::Count)> Refusals{};
  Counter SentBytes{ 0 }, OpenConnections{ 0 }, RefusedConnections{ 0 };
  Histogram Waits;
  Counter Queued{ 0 }, Begun{ 0 };
  Counter OpenStreams{ 0 }, TotalStreams{ 0 }, FailedBlobs{ 0 };
};

}
