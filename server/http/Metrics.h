// SPDX-License-Identifier: BSD-3-Clause
// Counters of a server, and their text for /metrics (Prometheus text format). All functions may be
// called from any thread.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string>

namespace kdstream
{

class Metrics
{
public:
  void CountRequest(unsigned status);
  void CountBytes(std::uint64_t bytes) { this->SentBytes += bytes; }
  void ConnectionOpened() { ++this->OpenConnections; }
  void ConnectionClosed() { --this->OpenConnections; }
  void ConnectionRefused() { ++this->RefusedConnections; }
  void StreamOpened()
  {
    ++this->OpenStreams;
    ++this->TotalStreams;
  }
  void StreamClosed() { --this->OpenStreams; }
  void CountFailedBlob() { ++this->FailedBlobs; }

  std::string Text() const;

private:
  using Counter = std::atomic<std::uint64_t>;
  std::array<Counter, 600> Requests{}; // by status
  Counter SentBytes{ 0 }, OpenConnections{ 0 }, RefusedConnections{ 0 };
  Counter OpenStreams{ 0 }, TotalStreams{ 0 }, FailedBlobs{ 0 };
};

}
