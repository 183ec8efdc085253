// SPDX-License-Identifier: BSD-3-Clause
#include "server/app/BackgroundJob.h"

#include <utility>

namespace kdstream
{

BackgroundJob::BackgroundJob(Work work, std::optional<std::chrono::milliseconds> interval)
  : Does(std::move(work))
  , Interval(interval)
  , Thread([this] { this->Run(); })
{
}

BackgroundJob::~BackgroundJob()
{
  (void)this->End(std::chrono::milliseconds(0));
  this->Thread.join();
}

void BackgroundJob::Ask()
{
  const std::lock_guard lock(this->Mutex);
  this->Asked = true;
  this->Changed.notify_all();
}

bool BackgroundJob::End(std::chrono::milliseconds time)
{
  std::unique_lock lock(this->Mutex);
  this->Ending = true;
  this->Changed.notify_all();
  return this->Changed.wait_for(lock, time, [this] { return this->Ended; });
}

void BackgroundJob::Run()
{
  std::unique_lock lock(this->Mutex);
  for (;;)
  {
    const auto isNeeded = [this] { return this->Asked || this->Ending; };
    if (this->Interval)
    {
      this->Changed.wait_for(lock, *this->Interval, isNeeded);
    }
    else
    {
      this->Changed.wait(lock, isNeeded);
    }
    if (this->Ending && !this->Asked)
    {
      break;
    }
    const bool isAsked = std::exchange(this->Asked, false);
    lock.unlock();
    this->Does(isAsked);
    lock.lock();
  }
  this->Ended = true;
  this->Changed.notify_all();
}

}
