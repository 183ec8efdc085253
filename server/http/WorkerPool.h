// SPDX-License-Identifier: BSD-3-Clause
// Threads for what those of the event loop must not wait for: disks, searches for regions,
// handshakes of TLS. Internal to the server.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace kdstream
{

// All functions may be called from any thread, but Start and Stop from one.
class WorkerPool
{
public:
  using Clock = std::chrono::steady_clock;
  // Throws nothing.
  using Work = std::function<void()>;

  // onBegin: told of each work how long it has waited; from any thread.
  explicit WorkerPool(std::function<void(Clock::duration waited)> onBegin = {})
    : OnBegin(std::move(onBegin))
  {
  }
  ~WorkerPool() { this->Stop(); }

  void Start(unsigned threads);
  // Finishes the work that is under way; what has not begun is dropped.
  void Stop();

  // First come, first served. How much waits at a time is for those who add to bound: a connection
  // adds one at a time. Returns how many wait now.
  std::size_t Add(Work work);

private:
  struct Entry
  {
    Work work;
    Clock::time_point added;
  };
  void Run();

  std::function<void(Clock::duration)> OnBegin;
  std::mutex Mutex;
  std::condition_variable Added;
  std::deque<Entry> Queue;
  bool Stopping = false;
  std::vector<std::thread> Threads;
};

}
