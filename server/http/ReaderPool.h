// SPDX-License-Identifier: BSD-3-Clause
// The threads that wait for disks and search regions, so that those of the event loop never do.
// Internal to the server.
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
class ReaderPool
{
public:
  using Clock = std::chrono::steady_clock;
  // Throws nothing.
  using Work = std::function<void()>;

  // onBegin: told of each work how long it has waited; from any thread.
  explicit ReaderPool(std::function<void(Clock::duration waited)> onBegin = {})
    : OnBegin(std::move(onBegin))
  {
  }
  ~ReaderPool() { this->Stop(); }

  void Start(unsigned threads);
  // Finishes the work that is under way; what has not begun is dropped.
  void Stop();

  // First come, first served. How much waits at a time is for those who add to bound: a connection
  // adds one at a time.
  void Add(Work work);
  std::size_t Waiting() const;

private:
  struct Entry
  {
    Work work;
    Clock::time_point added;
  };
  void Run();

  std::function<void(Clock::duration)> OnBegin;
  mutable std::mutex Mutex;
  std::condition_variable Added;
  std::deque<Entry> Queue;
  bool Stopping = false;
  std::vector<std::thread> Threads;
};

}
