// SPDX-License-Identifier: BSD-3-Clause
#include "server/app/FolderFollower.h"

#include "filters/core/CaughtError.h"
#include "server/app/FolderWatch.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <utility>

namespace kdstream
{

FolderFollower::FolderFollower(StoreCatalog& catalog, std::filesystem::path folder, Warn warn)
  : Catalog(catalog)
  , Folder(std::move(folder))
  , Tell(std::move(warn))
  , Bell(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK))
{
  this->Thread = std::thread([this] { this->Run(); });
}

FolderFollower::~FolderFollower()
{
  (void)this->End(std::chrono::milliseconds(0));
  this->Thread.join();
  if (this->Bell >= 0)
  {
    ::close(this->Bell);
  }
}

std::optional<Status> FolderFollower::AwaitFirst(std::chrono::milliseconds time)
{
  std::unique_lock lock(this->Mutex);
  this->Changed.wait_for(lock, time, [this] { return this->First.has_value(); });
  return this->First;
}

void FolderFollower::Follow()
{
  const std::lock_guard lock(this->Mutex);
  this->Follows = true;
  this->Changed.notify_all();
}

void FolderFollower::ReadAnew(std::function<void()> done)
{
  const std::lock_guard lock(this->Mutex);
  this->Anew = true;
  this->Done = std::move(done);
  this->Wake();
}

bool FolderFollower::End(std::chrono::milliseconds time)
{
  std::unique_lock lock(this->Mutex);
  this->Ending = true;
  this->Wake();
  this->Changed.notify_all();
  return this->Changed.wait_for(lock, time, [this] { return this->Ended; });
}

void FolderFollower::Wake() const
{
  const std::uint64_t one = 1;
  (void)!::write(this->Bell, &one, sizeof one);
}

// Waits until something has happened, or a second has passed.
void FolderFollower::Wait(int watched) const
{
  std::array<pollfd, 2> sources{ { { this->Bell, POLLIN, 0 }, { watched, POLLIN, 0 } } };
  constexpr int untilNextLook = 1000; // ms
  (void)::poll(sources.data(), sources.size(), untilNextLook);
  std::uint64_t rung = 0;
  (void)!::read(this->Bell, &rung, sizeof rung);
}

// Does the work. If memory runs out, the work is left unfinished, which is reported, and the
// follower continues.
void FolderFollower::Guarded(const std::function<void()>& work) const
{
  try
  {
    try
    {
      work();
    }
    catch (...)
    {
      this->Tell(CaughtError().message);
    }
  }
  catch (...) // there is no memory for a message either
  {
  }
}

void FolderFollower::Run()
{
  auto first = this->Catalog.Reload();
  std::unique_lock lock(this->Mutex);
  this->First = std::move(first);
  this->Changed.notify_all();
  this->Changed.wait(lock, [this] { return this->Follows || this->Ending; });
  const bool isNeeded = !this->Ending;
  lock.unlock();
  std::optional<FolderWatch> watch;
  this->Guarded(
    [&]
    {
      if (!isNeeded)
      {
        return;
      }
      auto opened = FolderWatch::Open(this->Folder);
      if (!opened)
      {
        this->Tell(opened.GetError().message + ": changes in it are only noticed at SIGHUP");
        return;
      }
      watch.emplace(std::move(*opened));
      this->Catalog.Look(); // for changes before the watch began
    });
  lock.lock();
  while (!this->Ending)
  {
    const bool anew = std::exchange(this->Anew, false);
    const auto done = std::exchange(this->Done, {});
    lock.unlock();
    if (anew)
    {
      this->Guarded(
        [&]
        {
          if (const auto status = this->Catalog.Reload(); !status)
          {
            this->Tell(status.GetError().message + "; the earlier models are still served");
          }
          done();
        });
    }
    this->Wait(watch ? watch->Descriptor() : -1);
    this->Guarded(
      [&] { watch && watch->HasChanged() ? this->Catalog.Look() : this->Catalog.Refresh(); });
    lock.lock();
  }
  this->Ended = true;
  this->Changed.notify_all();
}

}
