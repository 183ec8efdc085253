// SPDX-License-Identifier: BSD-3-Clause
#include "server/app/FolderWatch.h"

#include "filters/core/SystemReason.h"

#include <sys/inotify.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <string_view>
#include <utility>

namespace kdstream
{

Result<FolderWatch> FolderWatch::Open(const std::filesystem::path& folder)
{
  const int file = ::inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
  if (file < 0)
  {
    return SystemError("cannot be watched", errno);
  }
  FolderWatch watch(file, folder);
  if (!watch.Watch())
  {
    return SystemError("cannot be watched", errno);
  }
  return watch;
}

FolderWatch::~FolderWatch()
{
  if (this->File >= 0)
  {
    ::close(this->File);
  }
}

FolderWatch::FolderWatch(FolderWatch&& other) noexcept
  : File(std::exchange(other.File, -1))
  , Folder(std::move(other.Folder))
  , Watched(other.Watched)
  , Number(other.Number)
{
}

// Watches the folder that has the name now, unless it is watched already. Returns whether a new
// watch has begun.
bool FolderWatch::Watch()
{
  struct stat found
  {
  };
  if (::stat(this->Folder.c_str(), &found) != 0)
  {
    return false;
  }
  const Identity now{ found.st_dev, found.st_ino };
  if (now == this->Watched)
  {
    return false;
  }
  constexpr std::uint32_t events =
    IN_CLOSE_WRITE | IN_CREATE | IN_MOVED_TO | IN_MOVED_FROM | IN_DELETE | IN_ONLYDIR;
  const int next = ::inotify_add_watch(this->File, this->Folder.c_str(), events);
  if (next < 0)
  {
    return false;
  }
  if (this->Number >= 0 && this->Number != next)
  {
    (void)::inotify_rm_watch(this->File, this->Number);
  }
  this->Number = next;
  this->Watched = now;
  return true;
}

bool FolderWatch::HasChanged()
{
  const bool changed = this->TakeEvents();
  return this->Watch() || changed;
}

bool FolderWatch::IsLink(const char* name) const
{
  struct stat found
  {
  };
  return ::lstat((this->Folder / name).c_str(), &found) == 0 &&
         (S_ISLNK(found.st_mode) || found.st_nlink > 1);
}

bool FolderWatch::TakeEvents()
{
  bool changed = false;
  alignas(inotify_event) std::array<char, 4096> buffer;
  for (;;)
  {
    const auto bytes = ::read(this->File, buffer.data(), buffer.size());
    if (bytes <= 0)
    {
      return changed;
    }
    for (std::size_t at = 0; at < static_cast<std::size_t>(bytes);)
    {
      const auto* event = reinterpret_cast<const inotify_event*>(buffer.data() + at);
      const std::string_view name = event->len == 0 ? "" : event->name;
      // A created file is complete only if it is a link; others are reported when they are closed.
      const bool isWhole = (event->mask & IN_CREATE) == 0 || this->IsLink(event->name);
      changed =
        changed || (event->mask & IN_Q_OVERFLOW) != 0 || (name.ends_with(".kds") && isWhole);
      if ((event->mask & IN_IGNORED) != 0 && event->wd == this->Number) // the folder is gone
      {
        this->Watched = {};
        this->Number = -1;
      }
      at += sizeof(inotify_event) + event->len;
    }
  }
}

}
