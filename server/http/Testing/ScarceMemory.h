// SPDX-License-Identifier: BSD-3-Clause
// Memory that runs out at a chosen moment, in a test program that has ScarceMemory.cxx among its
// sources.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <thread>

namespace kdstream
{

// While an object of this class exists, a single allocation fails: number `n`, counted from 0 among
// the allocations of at least `leastBytes` that have been made since it was constructed.
class ScarceMemory
{
public:
  enum class Where
  {
    Everywhere,
    OtherThreads // this thread's are not counted: it is the client in the test
  };

  ScarceMemory(long n, Where where, std::size_t leastBytes = 0)
  {
    spared = where == Where::OtherThreads;
    least = leastBytes;
    failedBytes = 0;
    untilFailure = n;
  }
  ~ScarceMemory()
  {
    untilFailure = never;
    spared = false;
  }
  ScarceMemory(const ScarceMemory&) = delete;
  ScarceMemory& operator=(const ScarceMemory&) = delete;

  // On this thread, allocation number `n` from now fails; -1: no allocation fails.
  static void FailHere(long n) { untilFailureHere = n; }

  bool HasFailed() const { return failedBytes != 0; }
  // Waits until the allocation has failed, for at most a minute. Returns the size of that
  // allocation in bytes, or 0.
  std::size_t AwaitFailure() const
  {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    while (failedBytes == 0 && std::chrono::steady_clock::now() < end)
    {
      std::this_thread::yield();
    }
    return failedBytes;
  }

  static bool FailsNow(std::size_t bytes)
  {
    if (untilFailureHere >= 0 && untilFailureHere-- == 0)
    {
      return true;
    }
    if (spared || untilFailure < 0 || bytes < least || untilFailure.fetch_sub(1) != 0)
    {
      return false;
    }
    failedBytes = bytes;
    return true;
  }

private:
  static constexpr long never = -1;
  static inline std::atomic<long> untilFailure{ never };
  static inline std::atomic<std::size_t> least{ 0 }, failedBytes{ 0 };
  static inline thread_local bool spared = false;
  static inline thread_local long untilFailureHere = never;
};

}
