// SPDX-License-Identifier: BSD-3-Clause
#include "server/app/TokensWatch.h"

#include <chrono>
#include <utility>

namespace kdstream
{

namespace
{

// Streams check their tokens as often.
constexpr std::chrono::milliseconds interval{ 250 };

}

TokensWatch::TokensWatch(TokensFile file, Warn warn)
  : File(std::move(file))
  , Warning(std::move(warn))
  , Thread([this] { this->Run(); })
{
}

TokensWatch::~TokensWatch()
{
  {
    const std::lock_guard lock(this->Mutex);
    this->Ending = true;
  }
  this->Changed.notify_all();
  this->Thread.join();
}

void TokensWatch::Reload()
{
  const std::lock_guard lock(this->Mutex);
  this->Tell(this->File.Reload());
}

void TokensWatch::Run()
{
  std::unique_lock lock(this->Mutex);
  while (!this->Changed.wait_for(lock, interval, [this] { return this->Ending; }))
  {
    try
    {
      this->Tell(this->File.Look());
    }
    catch (...) // for want of memory: the next look is soon
    {
    }
  }
}

void TokensWatch::Tell(const Status& status)
{
  if (!status)
  {
    this->Warning(status.GetError().message + "; the earlier keys stay valid");
  }
}

}
