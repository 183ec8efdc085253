// SPDX-License-Identifier: BSD-3-Clause
#include "server/http/ReaderPool.h"

#include <utility>

namespace kdstream
{

void ReaderPool::Start(unsigned threads)
{
  for (unsigned i = 0; i < threads; ++i)
  {
    this->Threads.emplace_back([this] { this->Run(); });
  }
}

void ReaderPool::Stop()
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

void ReaderPool::Add(Work work)
{
  {
    const std::lock_guard lock(this->Mutex);
    if (this->Stopping)
    {
      return;
    }
    this->Queue.push_back({ std::move(work), Clock::now() });
  }
  this->Added.notify_one();
}

std::size_t ReaderPool::Waiting() const
{
  const std::lock_guard lock(this->Mutex);
  return this->Queue.size();
}

void ReaderPool::Run()
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
