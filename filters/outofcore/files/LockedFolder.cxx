// SPDX-License-Identifier: BSD-3-Clause
#include "filters/outofcore/files/LockedFolder.h"

#include "filters/core/SystemReason.h"
#include "filters/files/Folders.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

namespace kdstream
{
namespace
{

namespace fs = std::filesystem;

constexpr std::string_view lockedBegin = ".kdstream-files-";
// A build that still works changes its files at least this often.
constexpr std::chrono::hours longestPause{ 24 };

// Identifies where process numbers are valid: on this machine since it was started, in this
// container.
std::string PlaceOfProcesses()
{
  std::string boot;
  std::ifstream("/proc/sys/kernel/random/boot_id") >> boot;
  std::error_code unknown;
  const std::string place = boot + fs::read_symlink("/proc/self/ns/pid", unknown).string();
  std::array<char, 17> text{};
  std::snprintf(text.data(), text.size(), "%016llx",
    static_cast<unsigned long long>(XXH3_64bits(place.data(), place.size())));
  return text.data();
}

struct FolderOwner
{
  std::string place;
  pid_t process = 0;
};

// Splits a folder's name, which is ".kdstream-files-" and PLACE-PROCESS-LETTERS.
std::optional<FolderOwner> OwnerOf(const std::string& name)
{
  if (!name.starts_with(lockedBegin))
  {
    return {};
  }
  const std::size_t place = lockedBegin.size(), process = name.find('-', place) + 1;
  FolderOwner owner{ name.substr(place, process - 1 - place), 0 };
  const char* const end = name.data() + name.size();
  const auto read = std::from_chars(name.data() + process, end, owner.process);
  const bool whole = process > place && read.ec == std::errc() && read.ptr != end &&
                     *read.ptr == '-' && owner.process > 0;
  return whole ? std::optional(owner) : std::nullopt;
}

// Whether no other machine can see these files. Then a lock excludes all other processes.
bool IsOnDiskOfMachine(int descriptor)
{
  constexpr std::array<long, 7> disks{ 0xEF53, 0x58465342, 0x9123683E, 0x01021994, 0x794C7630,
    0x2FC12FC1, static_cast<long>(0xF2F52010) }; // ext, xfs, btrfs, tmpfs, overlay, zfs, f2fs
  struct statfs state = {};
  return fstatfs(descriptor, &state) == 0 &&
         std::find(disks.begin(), disks.end(), static_cast<long>(state.f_type)) != disks.end();
}

// Returns nothing if the folder cannot be examined; errno tells why.
std::optional<bool> IsSameFolder(int descriptor, const fs::path& path)
{
  struct stat opened = {}, named = {};
  if (fstat(descriptor, &opened) != 0)
  {
    return {};
  }
  if (lstat(path.c_str(), &named) != 0)
  {
    return errno == ENOENT ? std::optional(false) : std::nullopt;
  }
  return opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

bool IsUnchangedForLong(const fs::path& folder)
{
  std::error_code failed;
  auto last = fs::last_write_time(folder, failed);
  const auto names = NamesIn(folder);
  if (failed || !names)
  {
    return false;
  }
  for (const std::string& name : *names)
  {
    std::error_code gone;
    const auto time = fs::last_write_time(folder / name, gone);
    last = gone ? last : std::max(last, time);
  }
  return fs::file_time_type::clock::now() - last > longestPause;
}

// Whether the folder's process has ended. descriptor: of the folder. locked: whether the caller
// could lock it; as far as is known, nobody else holds the lock.
bool IsDead(int descriptor, bool locked, const fs::path& folder, const FolderOwner& owner)
{
  if (locked && IsOnDiskOfMachine(descriptor))
  {
    return true;
  }
  const bool gone =
    owner.place == PlaceOfProcesses() && kill(owner.process, 0) != 0 && errno == ESRCH;
  return gone || IsUnchangedForLong(folder);
}

// A folder that was just made. It is removed again if memory runs out before somebody owns it.
struct FolderInTheMaking
{
  explicit FolderInTheMaking(const char* folder)
    : name(folder)
  {
  }
  ~FolderInTheMaking()
  {
    if (this->descriptor >= 0)
    {
      close(this->descriptor);
    }
    if (this->isRemoved)
    {
      rmdir(this->name);
    }
  }
  FolderInTheMaking(const FolderInTheMaking&) = delete;
  FolderInTheMaking& operator=(const FolderInTheMaking&) = delete;

  const char* name;
  int descriptor = -1;
  bool isRemoved = true;
};

}

Result<LockedFolder> MakeLockedFolder(const fs::path& parent)
{
  const std::string begin =
    std::string(lockedBegin) + PlaceOfProcesses() + "-" + std::to_string(getpid()) + "-XXXXXX";
  const fs::path in = parent.empty() ? "." : parent;
  for (;;)
  {
    std::string name = in / begin;
    if (mkdtemp(name.data()) == nullptr)
    {
      return SystemError("cannot create a folder for temporary files in it", errno, in.string());
    }
    FolderInTheMaking made(name.c_str());
    const int descriptor = open(name.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    made.descriptor = descriptor;
    const bool refused = descriptor >= 0 && flock(descriptor, LOCK_EX | LOCK_NB) != 0;
    const bool taken = refused && errno == EWOULDBLOCK;
    const std::optional<bool> isSame =
      descriptor >= 0 && !taken ? IsSameFolder(descriptor, name) : std::nullopt;
    const int reason = errno;
    if (isSame.value_or(false))
    {
      fs::path path = name;
      // The deleter closes it, even if there is no memory for the shared_ptr.
      made.descriptor = -1;
      LockedFolder locked{ std::move(path),
        std::shared_ptr<void>(nullptr, [descriptor](void*) { close(descriptor); }) };
      made.isRemoved = false;
      return locked;
    }
    if (taken || isSame || (descriptor < 0 && reason == ENOENT))
    {
      made.isRemoved = false;
      // Another process took it for an abandoned folder before it was locked.
      continue;
    }
    return SystemError("its folder for temporary files cannot be opened", reason, in.string());
  }
}

void RemoveDeadFolders(const fs::path& parent)
{
  const fs::path in = parent.empty() ? "." : parent;
  const auto names = NamesIn(in);
  for (const std::string& name : names ? *names : std::vector<std::string>())
  {
    const auto owner = OwnerOf(name);
    if (!owner)
    {
      continue;
    }
    const fs::path folder = in / name;
    struct stat state = {};
    const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (descriptor < 0)
    {
      continue;
    }
    const bool locked = flock(descriptor, LOCK_EX | LOCK_NB) == 0;
    const bool taken = !locked && errno == EWOULDBLOCK;
    if (!taken && fstat(descriptor, &state) == 0 && state.st_uid == geteuid() &&
        IsDead(descriptor, locked, folder, *owner))
    {
      RemoveTree(folder);
    }
    close(descriptor);
  }
}

}
