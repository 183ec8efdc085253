// SPDX-License-Identifier: BSD-3-Clause
#include "server/app/FolderWatch.h"

#include "filters/core/SystemReason.h"

#include <sys/inotify.h>
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
  FolderWatch watch(file);
  constexpr std::uint32_t events =
    IN_CLOSE_WRITE | IN_MOVED_TO | IN_MOVED_FROM | IN_DELETE | IN_ONLYDIR;
  if (::inotify_add_watch(file, folder.c_str(), events) < 0)
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
{
}

bool FolderWatch::HasChanged()
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
      changed = changed || (event->mask & IN_Q_OVERFLOW) != 0 || name.ends_with(".kds");
      at += sizeof(inotify_event) + event->len;
    }
  }
}

}
