// SPDX-License-Identifier: BSD-3-Clause
#include "filters/files/HeldFolder.h"

#include "filters/core/SystemReason.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

namespace kdstream
{
namespace
{

namespace fs = std::filesystem;

bool IsOfThisUser(const struct stat& found)
{
  return found.st_uid == ::geteuid() || found.st_uid == 0;
}

}

HeldFolder::HeldFolder(int descriptor, fs::path name)
  : Descriptor(descriptor)
  , Called(std::move(name))
{
}

HeldFolder::HeldFolder(HeldFolder&& other) noexcept
  : Descriptor(std::exchange(other.Descriptor, -1))
  , Called(std::move(other.Called))
{
}

HeldFolder& HeldFolder::operator=(HeldFolder&& other) noexcept
{
  std::swap(this->Descriptor, other.Descriptor);
  std::swap(this->Called, other.Called);
  return *this;
}

HeldFolder::~HeldFolder()
{
  if (this->Descriptor >= 0)
  {
    ::close(this->Descriptor);
  }
}

Result<HeldFolder> HeldFolder::Open(const fs::path& folder)
{
  // O_PATH: also holds a folder that may be entered but not listed.
  const int descriptor = ::open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0)
  {
    return SystemError("cannot be opened", errno, folder.string());
  }
  return HeldFolder(descriptor, folder);
}

Result<HeldFolder> HeldFolder::Below(const std::string& name, mode_t mode, bool* made) const
{
  const fs::path below = this->Called / name;
  const bool isNew = ::mkdirat(this->Descriptor, name.c_str(), mode) == 0;
  if (!isNew && errno != EEXIST)
  {
    const int reason = errno;
    struct stat found = {};
    if (::fstatat(this->Descriptor, name.c_str(), &found, AT_SYMLINK_NOFOLLOW) != 0)
    {
      return SystemError("cannot be created", reason, below.string());
    }
  }
  if (made)
  {
    *made = isNew;
  }
  const int descriptor =
    ::openat(this->Descriptor, name.c_str(), O_PATH | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (descriptor >= 0)
  {
    return HeldFolder(descriptor, below);
  }
  const int reason = errno;
  struct stat found = {};
  const bool isLink = ::fstatat(this->Descriptor, name.c_str(), &found, AT_SYMLINK_NOFOLLOW) == 0 &&
                      S_ISLNK(found.st_mode);
  return isLink ? Error{ ErrorCode::InputOutput,
    "is a symbolic link, which is not followed: remove it, or give the folder itself",
    below.string() }
                : SystemError("cannot be opened", reason, below.string());
}

Error HeldFolder::NotOwn(const std::string& name) const
{
  return { ErrorCode::InputOutput, "does not belong to this user, and is not used",
    (this->Called / name).string() };
}

Result<HeldFolder> HeldFolder::OwnBelow(const std::string& name) const
{
  auto below = this->Below(name, S_IRWXU);
  KDSTREAM_TRY(below);
  struct stat found = {};
  if (::fstat(below->Descriptor, &found) != 0)
  {
    return SystemError("cannot be opened", errno, below->Called.string());
  }
  if (!IsOfThisUser(found))
  {
    return this->NotOwn(name);
  }
  constexpr mode_t ofOthers = S_IWGRP | S_IWOTH;
  const bool isOpen = (found.st_mode & ofOthers) != 0;
  if (isOpen && ::chmod(below->Path().c_str(), found.st_mode & 07777 & ~ofOthers) != 0)
  {
    return SystemError("can be written by other users", errno, below->Called.string());
  }
  return below;
}

Result<bool> HeldFolder::HasOwnFile(const std::string& name) const
{
  const int file = ::openat(
    this->Descriptor, name.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
  const int reason = errno;
  if (file < 0)
  {
    return reason == ENOENT ? Result<bool>(false)
           : reason == ELOOP
             ? this->NotOwn(name)
             : SystemError("cannot be opened", reason, (this->Called / name).string());
  }
  struct stat found = {};
  const bool isOwn = ::fstat(file, &found) == 0 && S_ISREG(found.st_mode) && found.st_nlink == 1 &&
                     IsOfThisUser(found);
  ::close(file);
  return isOwn ? Result<bool>(true) : this->NotOwn(name);
}

fs::path HeldFolder::Path() const
{
  return "/proc/" + std::to_string(::getpid()) + "/fd/" + std::to_string(this->Descriptor);
}

}
