// SPDX-License-Identifier: BSD-3-Clause
// Counters of a server, and their values as text for /metrics (Prometheus text format). All
// functions may be called from any thread.
#pragma once

#include "server/session/Catalog.h"

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <span>
#include <string>

namespace kdstream
{

// A histogram: counts how often a value fell into each range.
class Histogram
{
public:
  static constexpr std::size_t mostBounds = 12;
  static constexpr std::array<double, 12> seconds{ 0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.1,
    0.25, 0.5, 1, 5, 30 };
  static constexpr std::array<double, 9> lengths{ 0, 1, 2, 4, 8, 16, 64, 256, 1024 };

  // The bounds ascend; there are at most mostBounds of them. REQUIRES: they outlive the histogram.
  explicit Histogram(std::span<const double> bounds)
    : Bounds(bounds)
  {
  }
  void Count(double value);
  void Count(std::chrono::steady_clock::duration time)
  {
    this->Count(std::chrono::duration<double>(time).count());
  }
  void Write(std::string& text, const char* name, const char* help) const;

private:
  std::span<const double> Bounds;
  std::array<std::atomic<std::uint64_t>, mostBounds + 1> Counts{};
  std::atomic<double> Sum{ 0 };
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
    Address,     // its address has too many connections
    Requests,    // too many requests a minute
    Host,        // the request named another host
    Slow,        // the client received too slowly
    Idle,        // another client needed its slot
    Descriptors, // the process may open no more files
    Stopping,    // the server is stopping
    Handshake,   // no TLS handshake, or a late one
    Proxy,       // a proxy's header could not be read
    Token,       // no token, or one that does not allow the request
    Quota,       // the quota is used up
    Origin,      // a page of another origin wanted a stream
    Count
  };
  void CountRefusal(Reason reason) { ++this->Refusals[static_cast<std::size_t>(reason)]; }
  // Failures of the server itself: memory, descriptors or the disk.
  enum class Failure
  {
    Accept,     // a connection could not be accepted
    Connection, // a connection was ended by this failure
    Answer,     // HTTP: answered with 503
    Quota,      // quotas could not be kept
    Disk,       // a disk did not respond in time
    Count
  };
  void CountFailure(Failure failure) { ++this->Failures[static_cast<std::size_t>(failure)]; }
  void StreamOpened()
  {
    ++this->OpenStreams;
    ++this->TotalStreams;
  }
  void StreamClosed() { --this->OpenStreams; }
  void CountFailedBlob() { ++this->FailedBlobs; }
  // A request waits for a reader; `waiting` requests wait now, including this one.
  void CountWaiting(std::size_t waiting)
  {
    ++this->Queued;
    this->Lengths.Count(static_cast<double>(waiting));
  }
  void CountWait(std::chrono::steady_clock::duration time)
  {
    ++this->Begun;
    this->Waits.Count(time);
  }
  // The time from a request's arrival until its answer was sent. For a stream: the times until the
  // first and the last blob of a request were sent.
  void CountAnswer(std::chrono::steady_clock::duration time) { this->Answers.Count(time); }
  void CountFirstBlob(std::chrono::steady_clock::duration time) { this->FirstBlobs.Count(time); }
  void CountLastBlob(std::chrono::steady_clock::duration time) { this->LastBlobs.Count(time); }

  // lostLines: lines that the server's logs have lost. tiles: counts about 3D Tiles.
  std::string Text(
    const CacheUse& memory, std::uint64_t lostLines = 0, const CacheUse& tiles = {}) const;

private:
  using Counter = std::atomic<std::uint64_t>;
  std::array<Counter, 600> Requests{}; // by status
  std::array<Counter, static_cast<std::size_t>(Reason::Count)> Refusals{};
  std::array<Counter, static_cast<std::size_t>(Failure::Count)> Failures{};
  Counter SentBytes{ 0 }, OpenConnections{ 0 }, RefusedConnections{ 0 };
  Histogram Waits{ Histogram::seconds }, Lengths{ Histogram::lengths };
  Histogram Answers{ Histogram::seconds }, FirstBlobs{ Histogram::seconds },
    LastBlobs{ Histogram::seconds };
  Counter Queued{ 0 }, Begun{ 0 };
  Counter OpenStreams{ 0 }, TotalStreams{ 0 }, FailedBlobs{ 0 };
};

}
