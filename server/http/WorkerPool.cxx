// SPDX-License-Identifier: BSD-3-Clause
#include "server/http/WorkerPool.h"

#include <utility>

namespace kdstream
{

void WorkerPool::Start(unsigned threads)
{
  for (unsigned i = 0; i < threads; ++i)
  {
    this->Threads.emplace_back([this] { this->Run(); });
  }
}

void WorkerPool::Stop()
{
  std::deque<Entry> dropped; // ends what holds it without the lock
  {
    const std::lock_guard lock(this->Mutex);
    this->Stopping = true;
    dropped.swap(this->Queue);
  }
  this->Added.notify_all();
  for (auto& thread : this->Threads)
  {
    thread.join();
  }
  this->Threads.clear();
}

std::size_t WorkerPool::Add(Work work)
{
  std::size_t waiting = 0;
  {
    const std::lock_guard lock(this->Mutex);
    if (this->Stopping)
    {
      return 0;
    }
    this->Queue.push_back({ std::move(work), Clock::now() });
    waiting = this->Queue.size();
  }
  this->Added.notify_one();
  return waiting;
}

void WorkerPool::Run()
{
  for (;;)
  {
    Entry entry;
    {
      std::unique_lock lock(this->Mutex);
      this->Added.wait(lock, [this] { return this->Stopping || !this->Queue.empty(); });
      if (this->Stopping)
      {
        return;
      }
      entry = std::move(this->Queue.front());
      this->Queue.pop_front();
    }
    if (this->OnBegin)
    {
      this->OnBegin(Clock::now() - entry.added);
    }
    entry.work();
  }
}

}
