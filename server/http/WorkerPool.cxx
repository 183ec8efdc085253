// SPDX-License-Identifier: BSD-3-Clause
#include "server/http/WorkerPool.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace kdstream
{

namespace
{

// The interval of the search for tasks that take too long, while there are tasks.
constexpr std::chrono::milliseconds betweenLooks{ 100 };

}

void WorkerPool::Start(unsigned threads, const Limits& limits)
{
  const std::lock_guard lock(this->Mutex);
  this->Times = limits;
  this->Wanted = threads;
  for (unsigned i = 0; i < threads; ++i)
  {
    this->StartThread();
  }
  this->Watcher = std::thread([this] { this->Watch(); });
}

// The caller holds the lock.
void WorkerPool::StartThread()
{
  const auto place = this->Threads.emplace(this->Threads.end());
  try
  {
    *place = std::thread([this, place] { this->Run(place); });
  }
  catch (...)
  {
    this->Threads.erase(place);
    throw;
  }
}

void WorkerPool::BeginStopping()
{
  std::map<const void*, Source> dropped; // destroyed without holding the lock
  Entries waiting;
  {
    const std::lock_guard lock(this->Mutex);
    this->Stopping = true;
    dropped.swap(this->Sources);
    this->Waiting = 0;
    for (auto& running : this->Running)
    {
      waiting.splice(waiting.end(), running.waiting);
    }
  }
  this->Added.notify_all();
  this->Watched.notify_all();
}

void WorkerPool::Stop()
{
  this->BeginStopping();
  if (this->Watcher.joinable())
  {
    this->Watcher.join();
  }
  for (auto* threads : { &this->Threads, &this->Surplus })
  {
    for (auto& thread : *threads)
    {
      thread.join();
    }
    threads->clear();
  }
}

bool WorkerPool::Stop(Clock::duration time)
{
  this->BeginStopping();
  {
    std::unique_lock lock(this->Mutex);
    if (!this->Ended.wait_for(lock, time, [this] { return this->Running.empty(); }))
    {
      return false;
    }
  }
  this->Stop();
  return true;
}

std::size_t WorkerPool::Add(Task task)
{
  Entries added;
  added.push_back({ std::move(task), Clock::now() });
  std::size_t waiting = 0;
  {
    const std::lock_guard lock(this->Mutex);
    if (this->Stopping)
    {
      return 0;
    }
    const auto& entry = added.front().task;
    if (!entry.giveUp || !this->IsHopeless(entry))
    {
      auto* const same = this->FindRunning(entry);
      auto& queue = same ? same->waiting : this->Sources[entry.source].queue;
      queue.splice(queue.end(), added);
      waiting = ++this->Waiting;
    }
  }
  if (waiting == 0)
  {
    if (this->OnBegin)
    {
      this->OnBegin({});
    }
    added.front().task.giveUp();
    return 0;
  }
  this->Added.notify_one();
  return waiting;
}

// How many threads a source may have.
unsigned WorkerPool::MostOf(const void* source) const
{
  // If as many threads hang as there are, each source gets one thread until it has shown that it
  // does not hang.
  return !source ? this->Wanted : this->Stalled < this->Wanted ? (this->Wanted + 1) / 2 : 1;
}

// Whether the task would wait for a task that has been given up.
bool WorkerPool::IsHopeless(const Task& task) const
{
  const auto source = this->Sources.find(task.source);
  if (!task.source || source == this->Sources.end() || source->second.lost == 0)
  {
    return false;
  }
  return source->second.lost >= this->MostOf(task.source) ||
         std::any_of(this->Running.begin(), this->Running.end(),
           [&](const Entry& running)
           {
             return running.lost && running.task.source == task.source && !task.part.empty() &&
                    running.task.part == task.part;
           });
}

// The running task that reads the same part; null if there is none.
WorkerPool::Entry* WorkerPool::FindRunning(const Task& task)
{
  if (!task.source || task.part.empty())
  {
    return nullptr;
  }
  const auto found = std::find_if(this->Running.begin(), this->Running.end(),
    [&](const Entry& running)
    { return running.task.source == task.source && running.task.part == task.part; });
  return found == this->Running.end() ? nullptr : &*found;
}

// Begins the task that has waited longest among those that may begin. Returns it, or the end of
// Running if there is none. The caller holds the lock.
WorkerPool::Entries::iterator WorkerPool::Pick()
{
  for (;;)
  {
    Source* chosen = nullptr;
    for (auto& [source, tasks] : this->Sources)
    {
      if (!tasks.queue.empty() && tasks.running < this->MostOf(source) &&
          (!chosen || tasks.queue.front().added < chosen->queue.front().added))
      {
        chosen = &tasks;
      }
    }
    if (!chosen)
    {
      return this->Running.end();
    }
    const auto first = chosen->queue.begin();
    if (auto* const same = this->FindRunning(first->task))
    {
      same->waiting.splice(same->waiting.end(), chosen->queue, first);
      continue;
    }
    this->Running.splice(this->Running.end(), chosen->queue, first);
    first->begun = Clock::now();
    ++chosen->running;
    --this->Waiting;
    return first;
  }
}

// Moves the task to `done`. Tasks that wait for the same part continue one by one; mostly they find
// the part in memory. The caller holds the lock.
void WorkerPool::Finish(Entries::iterator entry, Entries& done)
{
  const auto found = this->Sources.find(entry->task.source);
  if (found != this->Sources.end()) // otherwise the pool is stopping
  {
    auto& source = found->second;
    --source.running;
    source.lost -= entry->lost ? 1 : 0;
    for (auto& each : entry->waiting)
    {
      each.task.part.clear();
    }
    if (entry->waiting.size() > 1 || entry->lost)
    {
      this->Added.notify_all();
    }
    source.queue.splice(source.queue.begin(), entry->waiting);
    if (source.queue.empty() && source.running == 0)
    {
      this->Sources.erase(found);
    }
  }
  done.splice(done.end(), this->Running, entry);
  this->Stalled = this->CountStalled();
  if (this->Stopping)
  {
    this->Ended.notify_all();
  }
}

// The number of threads that a disk has blocked for too long.
std::size_t WorkerPool::CountStalled() const
{
  const auto before = Clock::now() - this->Times.stalledAfter;
  return static_cast<std::size_t>(std::count_if(this->Running.begin(), this->Running.end(),
    [before](const Entry& running) { return running.task.source && running.begun < before; }));
}

void WorkerPool::Run(Thread self)
{
  std::unique_lock lock(this->Mutex);
  while (!this->Stopping)
  {
    if (this->Threads.size() > this->Wanted + this->Stalled)
    {
      this->Surplus.splice(this->Surplus.end(), this->Threads, self);
      this->Added.notify_one(); // this thread may have been woken for a task
      return;
    }
    const auto entry = this->Pick();
    if (entry == this->Running.end())
    {
      this->Added.wait(lock);
      continue;
    }
    if (std::exchange(this->Idle, false))
    {
      this->Watched.notify_all();
    }
    lock.unlock();
    if (this->OnBegin)
    {
      this->OnBegin(entry->begun - entry->added);
    }
    entry->task.work();
    Entries done; // destroyed without holding the lock
    lock.lock();
    this->Finish(entry, done);
    lock.unlock();
    done.clear();
    lock.lock();
  }
}

void WorkerPool::Watch()
{
  std::unique_lock lock(this->Mutex);
  while (!this->Stopping)
  {
    if (this->Running.empty()) // then no task waits either
    {
      this->Idle = true;
      this->Watched.wait(lock, [this] { return this->Stopping || !this->Idle; });
      continue;
    }
    this->Watched.wait_for(lock, betweenLooks, [this] { return this->Stopping; });
    Entries late;
    std::vector<Work> lost; // not a deque, which allocates even when empty
    std::list<std::thread> surplus;
    this->Look(late, lost);
    surplus.swap(this->Surplus);
    lock.unlock();
    for (const auto& each : late)
    {
      if (this->OnBegin)
      {
        this->OnBegin(Clock::now() - each.added);
      }
      each.task.giveUp();
    }
    for (const auto& giveUp : lost)
    {
      giveUp();
    }
    late.clear();
    lost.clear();
    for (auto& thread : surplus)
    {
      thread.join();
    }
    lock.lock();
  }
}

// Removes the tasks that have waited for too long, and replaces blocked threads. The caller holds
// the lock.
void WorkerPool::Look(Entries& late, std::vector<Work>& lost)
{
  const auto before = Clock::now() - this->Times.patience;
  this->Stalled = this->CountStalled();
  try
  {
    for (auto& running : this->Running)
    {
      const auto source = this->Sources.find(running.task.source);
      if (!running.lost && running.task.giveUp && running.added < before &&
          source != this->Sources.end())
      {
        lost.push_back(running.task.giveUp);
        running.task.giveUp = {};
        running.lost = true;
        ++source->second.lost;
      }
      this->TakeLate(running.waiting, running.lost, late);
    }
    for (auto& [source, tasks] : this->Sources)
    {
      this->TakeLate(tasks.queue, source && tasks.lost >= this->MostOf(source), late);
    }
    const auto most = this->Wanted + std::min(this->Stalled, mostReplaced);
    while (!this->Stopping && this->Threads.size() < most)
    {
      this->StartThread();
    }
  }
  catch (...) // lack of memory or threads: tried at the next look
  {
  }
}

// Removes from the queue the tasks that have waited for too long, or (`all`) every task that can be
// given up.
void WorkerPool::TakeLate(Entries& queue, bool all, Entries& late)
{
  const auto before = Clock::now() - this->Times.patience;
  for (auto each = queue.begin(); each != queue.end();)
  {
    const auto entry = each++;
    if (entry->task.giveUp && (all || entry->added < before))
    {
      late.splice(late.end(), queue, entry);
      --this->Waiting;
    }
  }
}

}
