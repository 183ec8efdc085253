// SPDX-License-Identifier: BSD-3-Clause
#include "filters/files/Folders.h"

#include "filters/core/SystemReason.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <string_view>

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
  // Some file systems cannot synchronize folders.
  const bool failed = ::fsync(descriptor) != 0 && errno != EINVAL && errno != EROFS;
  const int reason = errno;
  ::close(descriptor);
  return failed ? Status{ SystemError("cannot be written", reason, path.string()) } : Status{};
}

// Reads the names in an open folder, and finally closes it.
class Entries
{
public:
  explicit Entries(int descriptor)
    : Folder(descriptor < 0 ? nullptr : ::fdopendir(descriptor))
    , Reason(this->Folder ? 0 : errno)
  {
    if (!this->Folder && descriptor >= 0)
    {
      ::close(descriptor);
    }
  }
  ~Entries()
  {
    if (this->Folder)
    {
      ::closedir(this->Folder);
    }
  }
  Entries(const Entries&) = delete;
  Entries& operator=(const Entries&) = delete;

  // The next name; null after the last one, and after a failure.
  const char* Next()
  {
    for (;;)
    {
      errno = 0;
      const dirent* const entry = this->Folder ? ::readdir(this->Folder) : nullptr;
      if (!entry)
      {
        this->Reason = this->Folder ? errno : this->Reason;
        return nullptr;
      }
      const std::string_view name = entry->d_name;
      if (name != "." && name != "..")
      {
        return entry->d_name;
      }
    }
  }
  int Failure() const { return this->Reason; }
  int Descriptor() const { return ::dirfd(this->Folder); }

private:
  DIR* Folder;
  int Reason;
};

// Synchronizes everything in an open folder, and the folder itself; closes it.
Status SyncBelow(int folder, const fs::path& path)
{
  Entries entries(folder);
  while (const char* const name = entries.Next())
  {
    const fs::path below = path / name;
    const int file = ::openat(
      entries.Descriptor(), name, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    struct stat state = {};
    if (file >= 0 && ::fstat(file, &state) == 0 && S_ISDIR(state.st_mode))
    {
      KDSTREAM_TRY(SyncBelow(file, below));
    }
    else if (file >= 0)
    {
      ::close(file);
    }
    else if (errno == ELOOP)
    {
      continue; // a link
    }
    KDSTREAM_TRY(Sync(below, O_NOFOLLOW | O_NONBLOCK));
  }
  return entries.Failure() == 0
           ? Status{}
           : Status{ SystemError("cannot be read", entries.Failure(), path.string()) };
}

// Removes everything in an open folder, as far as possible; closes the folder.
void RemoveBelow(int folder) noexcept
{
  Entries entries(folder);
  while (const char* const name = entries.Next())
  {
    if (::unlinkat(entries.Descriptor(), name, 0) == 0)
    {
      continue;
    }
    const int child =
      ::openat(entries.Descriptor(), name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (child >= 0)
    {
      RemoveBelow(child);
      ::unlinkat(entries.Descriptor(), name, AT_REMOVEDIR);
    }
  }
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
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor >= 0)
  {
    // Synchronizes all files at once, so that the disk writes them in its own order; after that
    // each fsync has nothing left to do.
    (void)::syncfs(descriptor);
    KDSTREAM_TRY(SyncBelow(descriptor, folder));
  }
  return SyncFolder(folder);
}

Result<std::vector<std::string>> NamesIn(const fs::path& folder)
{
  Entries entries(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  std::vector<std::string> names;
  while (const char* const name = entries.Next())
  {
    names.emplace_back(name);
  }
  if (entries.Failure() != 0)
  {
    return SystemError("cannot be read", entries.Failure(), folder.string());
  }
  return names;
}

int OpenNameless(const fs::path& folder)
{
  int descriptor = -1;
#ifdef O_TMPFILE
  descriptor = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
#endif
  if (descriptor < 0) // not every file system has files without a name
  {
    std::string name = (folder / ".kdstream-scratch-XXXXXX").string();
    descriptor = ::mkostemp(name.data(), O_CLOEXEC);
    if (descriptor >= 0)
    {
      ::unlink(name.c_str());
    }
  }
  return descriptor;
}

void RemoveTree(const fs::path& folder) noexcept
{
  bool isGone = false;
  for (int attempt = 0; attempt < 2 && !isGone; ++attempt)
  {
    const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (descriptor >= 0)
    {
      RemoveBelow(descriptor);
    }
    isGone = ::rmdir(folder.c_str()) == 0 || ::unlink(folder.c_str()) == 0;
  }
}

}
