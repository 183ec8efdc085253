// SPDX-License-Identifier: BSD-3-Clause
#include "filters/store/StoreFile.h"

#include "filters/core/SystemReason.h"

#include <fcntl.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <chrono>
#include <ctime>
#include <thread>

namespace kdstream
{
namespace
{

// File systems stamp a change with the time of the kernel's last tick: at most 10 ms ago.
constexpr std::chrono::milliseconds clockStep{ 20 };
constexpr int mostWaits = 10;

bool SameTime(const timespec& a, const timespec& b)
{
  return a.tv_sec == b.tv_sec && a.tv_nsec == b.tv_nsec;
}

FileState StateOf(const struct stat& status)
{
  return { status.st_dev, status.st_ino, status.st_size, status.st_mtim, status.st_ctim };
}

// Whether another change now would get a later time than `time`, that of the last change.
bool IsPast(const timespec& time)
{
  timespec now = {};
  ::clock_gettime(CLOCK_REALTIME, &now);
  const std::chrono::nanoseconds age = std::chrono::seconds(now.tv_sec - time.tv_sec) +
                                       std::chrono::nanoseconds(now.tv_nsec - time.tv_nsec);
  return age > clockStep;
}

}

bool FileState::SameContent(const FileState& other) const
{
  return this->device == other.device && this->inode == other.inode && this->size == other.size &&
         SameTime(this->modified, other.modified);
}

bool FileState::operator==(const FileState& other) const
{
  return this->SameContent(other) && SameTime(this->changed, other.changed);
}

FileState FileState::Of(const std::filesystem::path& file)
{
  struct stat status = {};
  return ::stat(file.c_str(), &status) == 0 ? StateOf(status) : FileState{};
}

Result<std::unique_ptr<const StoreFile>> StoreFile::Open(const std::filesystem::path& file)
{
  // Does not block if the file is a pipe.
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0)
  {
    const int reason = errno;
    const bool missing = reason == ENOENT || reason == ENOTDIR;
    return Error{ missing ? ErrorCode::NotFound : ErrorCode::InputOutput,
      missing ? "no such file" : "cannot be opened: " + SystemReason(reason) };
  }
  std::unique_ptr<const StoreFile> opened(new StoreFile(descriptor));
  Result<FileState> before = opened->State();
  KDSTREAM_TRY(before);
  for (int waits = 0; waits < mostWaits; ++waits)
  {
    if (IsPast(before->changed))
    {
      return opened;
    }
    std::this_thread::sleep_for(clockStep + std::chrono::milliseconds(1));
    Result<FileState> after = opened->State();
    KDSTREAM_TRY(after);
    if (*after == *before)
    {
      return opened; // also if the file system's clock is ahead of ours
    }
    before = std::move(after);
  }
  return Error{ ErrorCode::InputOutput, "is being written" };
}

Result<FileState> StoreFile::KnownState() const
{
  struct statx status = {};
  constexpr unsigned wanted = STATX_TYPE | STATX_INO | STATX_SIZE | STATX_MTIME | STATX_CTIME;
  if (::statx(this->Handle, "", AT_EMPTY_PATH | AT_STATX_DONT_SYNC, wanted, &status) != 0 ||
      (status.stx_mask & wanted) != wanted)
  {
    return SystemError("cannot be read", errno);
  }
  const auto time = [](const statx_timestamp& from) {
    return timespec{ from.tv_sec, static_cast<long>(from.tv_nsec) };
  };
  return FileState{ gnu_dev_makedev(status.stx_dev_major, status.stx_dev_minor), status.stx_ino,
    static_cast<off_t>(status.stx_size), time(status.stx_mtime), time(status.stx_ctime) };
}

StoreFile::~StoreFile()
{
  ::close(this->Handle);
}

Result<FileState> StoreFile::State() const
{
  struct stat status = {};
  if (::fstat(this->Handle, &status) != 0)
  {
    return SystemError("cannot be read", errno);
  }
  if (!S_ISREG(status.st_mode))
  {
    return Error{ ErrorCode::NotFound, "is not a file" };
  }
  return StateOf(status);
}

}
