// SPDX-License-Identifier: BSD-3-Clause
#include "server/session/PatientLoop.h"

#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

namespace kdstream
{

namespace
{

// Shared by the threads, each of which may outlive the loop.
struct Loop
{
  std::size_t count = 0;
  std::function<void(std::size_t)> work;
  std::mutex mutex; // for what follows
  std::condition_variable changed;
  std::size_t next = 0; // the first index that no thread has begun
  unsigned thread = 0;  // the number of the working thread
  std::exception_ptr thrown;
  bool done = false;

  void Run(unsigned self)
  {
    std::unique_lock lock(this->mutex);
    while (this->thread == self && this->next < this->count && !this->thrown)
    {
      const auto i = this->next++;
      lock.unlock();
      std::exception_ptr caught;
      try
      {
        this->work(i);
      }
      catch (...)
      {
        caught = std::current_exception();
      }
      lock.lock();
      if (this->thread != self) // another thread continues in place of this one
      {
        return;
      }
      this->thrown = caught;
      this->changed.notify_all();
    }
    this->done = this->done || this->thread == self;
    this->changed.notify_all();
  }
};

void Start(const std::shared_ptr<Loop>& loop, unsigned self)
{
  std::thread([loop, self] { loop->Run(self); }).detach();
}

}

void ForEachPatiently(std::size_t count, std::chrono::milliseconds patience,
  std::function<void(std::size_t)> work, const std::function<void(std::size_t)>& late)
{
  const auto loop = std::make_shared<Loop>();
  loop->count = count;
  loop->work = std::move(work);
  Start(loop, 0);
  std::unique_lock lock(loop->mutex);
  while (!loop->done)
  {
    const auto before = loop->next;
    const bool goesOn =
      loop->changed.wait_for(lock, patience, [&] { return loop->done || loop->next > before; });
    if (goesOn || loop->next == 0) // no call has begun yet: the thread starts slowly
    {
      continue;
    }
    const auto stuck = loop->next - 1;
    const auto self = ++loop->thread;
    lock.unlock();
    late(stuck);
    Start(loop, self);
    lock.lock();
  }
  if (loop->thrown)
  {
    std::rethrow_exception(loop->thrown);
  }
}

}
