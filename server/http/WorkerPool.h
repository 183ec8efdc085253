// SPDX-License-Identifier: BSD-3-Clause
// A thread pool for work that event loops must not wait for: disks, searches for regions, TLS
// handshakes. Internal to the server.
//
// A disk that hangs delays only the requests that need it:
//   - a source (such as a store) occupies at most half of the threads; its further tasks wait in a
//     queue of the source, which needs no thread;
//   - a request for something that is already being read waits for that read, without a thread;
//   - a thread that is blocked for longer than `stalledAfter` is replaced by another, for up to
//     mostReplaced threads; when it returns, there is one thread too many, which ends;
//   - a task that is not done within `patience` is given up: its giveUp is called. If tasks that
//     were given up block all threads that a source may have, its further tasks are given up at
//     once.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace kdstream
{

// All functions may be called from any thread, but Start and Stop from only one.
class WorkerPool
{
public:
  using Clock = std::chrono::steady_clock;
  // Work must not throw.
  using Work = std::function<void()>;

  struct Task
  {
    Work work;
    // Called once, from any thread, if the task has waited or run for too long: from then on nobody
    // waits for it. A task that has not begun is dropped. Empty: the task is never given up.
    Work giveUp = {};
    // The source that the task waits for, by its address; null: the task waits for nothing that may
    // hang.
    const void* source = nullptr;
    // The part of the source that the task reads; "": no other task might read the same.
    std::string part = {};
  };

  struct Limits
  {
    Clock::duration stalledAfter = std::chrono::seconds(1);
    Clock::duration patience = std::chrono::seconds(30);
  };
  static constexpr std::size_t mostReplaced = 256;

  // onBegin: called for each task when it begins or is given up, with the time that it has waited;
  // from any thread.
  explicit WorkerPool(std::function<void(Clock::duration waited)> onBegin = {})
    : OnBegin(std::move(onBegin))
  {
  }
  ~WorkerPool() { this->Stop(); }

  void Start(unsigned threads, const Limits& limits);
  void Start(unsigned threads) { this->Start(threads, Limits()); }
  // Finishes the tasks that are running; drops those that have not begun.
  void Stop();
  // Does the same, but waits at most for this time. False if a thread is still blocked; then Stop()
  // and the destructor wait for it.
  bool Stop(Clock::duration time);

  // Adds a task. Tasks run in the order in which they were added, if their source may have a
  // thread. Callers must limit the number of waiting tasks: a connection adds one at a time.
  // Returns the number of tasks that wait now.
  std::size_t Add(Task task);

private:
  struct Entry
  {
    Task task;
    Clock::time_point added;
    Clock::time_point begun = {};
    bool lost = false;             // started, then given up
    std::list<Entry> waiting = {}; // tasks for the same part, waiting for this one
  };
  // Entries move from list to list without allocating memory, which may be short.
  using Entries = std::list<Entry>;
  struct Source
  {
    Entries queue;
    unsigned running = 0, lost = 0;
  };
  using Thread = std::list<std::thread>::iterator;

  void Run(Thread self);
  void Watch();
  void StartThread();
  Entries::iterator Pick();
  void Finish(Entries::iterator entry, Entries& done);
  void Look(Entries& late, std::vector<Work>& lost);
  void TakeLate(Entries& queue, bool all, Entries& late);
  unsigned MostOf(const void* source) const;
  bool IsHopeless(const Task& task) const;
  Entry* FindRunning(const Task& task);
  std::size_t CountStalled() const;
  void BeginStopping();

  std::function<void(Clock::duration)> OnBegin;
  Limits Times;
  std::mutex Mutex; // for the members below
  std::condition_variable Added, Watched, Ended;
  unsigned Wanted = 0; // threads that are not stalled
  std::size_t Waiting = 0;
  std::map<const void*, Source> Sources; // the sources that have tasks
  Entries Running;
  std::size_t Stalled = 0; // how many of Running were stalled at the last check
  bool Stopping = false, Idle = false;
  std::list<std::thread> Threads, Surplus; // Surplus: threads that have ended
  std::thread Watcher;
};

}
