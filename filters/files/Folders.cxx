// SPDX-License-Identifier: BSD-3-Clause
#include "filters/files/Folders.h"

#include "filters/core/SystemReason.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <new>
#include <system_error>

namespace kdstream
{
namespace
{

namespace fs = std::filesystem;

Status Sync(const fs::path& path, int flags)
{
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | flags);
  if (descriptor < 0)
  {
    return errno == EACCES ? Status{}
                           : Status{ SystemError("cannot be opened", errno, path.string()) };
  }
  // Some file systems cannot do it with folders.
  const bool failed = ::fsync(descriptor) != 0 && errno != EINVAL && errno != EROFS;
  const int reason = errno;
  ::close(descriptor);
  return failed ? Status{ SystemError("cannot be written", reason, path.string()) } : Status{};
}

}

Status MakePrivateFolder(const fs::path& folder)
{
  const fs::path path = folder.has_filename() ? folder : folder.parent_path();
  const auto refused = [&](int reason)
  { return SystemError("cannot be created", reason, folder.string()); };
  std::error_code failure;
  if (path.has_parent_path())
  {
    fs::create_directories(path.parent_path(), failure);
  }
  if (failure)
  {
    return refused(failure.value());
  }
  if (::mkdir(path.c_str(), 0700) == 0)
  {
    return {};
  }
  const int reason = errno;
  return reason == EEXIST && fs::is_directory(path, failure)
           ? Status{}
           : Status{ refused(reason == EEXIST ? ENOTDIR : reason) };
}

Status SyncFolder(const fs::path& folder)
{
  return Sync(folder, O_DIRECTORY);
}

Status SyncTree(const fs::path& folder)
{
  // At once, so that the disk takes them in its own order; then nothing is left to do for each.
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor >= 0)
  {
    (void)::syncfs(descriptor);
    ::close(descriptor);
  }
  std::error_code failure;
  for (fs::recursive_directory_iterator entry(folder, failure), end; !failure && entry != end;
       entry.increment(failure))
  {
    if (entry->is_symlink(failure))
    {
      continue;
    }
    KDSTREAM_TRY(Sync(entry->path(), O_NOFOLLOW | O_NONBLOCK));
  }
  if (failure)
  {
    return SystemError("cannot be read", failure.value(), folder.string());
  }
  return SyncFolder(folder);
}

void RemoveTree(const fs::path& folder) noexcept
{
  std::error_code failure(EAGAIN, std::generic_category());
  for (int attempt = 0; attempt < 2 && failure; ++attempt)
  {
    try
    {
      fs::remove_all(folder, failure);
    }
    catch (const std::bad_alloc&)
    {
      failure = std::make_error_code(std::errc::not_enough_memory);
    }
  }
}

}
