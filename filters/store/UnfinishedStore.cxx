// SPDX-License-Identifier: BSD-3-Clause
#include "filters/store/UnfinishedStore.h"

#include "filters/core/SystemReason.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace kdstream
{
namespace
{

// What a store is called until it is whole: ".NAME.", letters that nobody else has taken, and this.
constexpr std::string_view unfinished = ".unfinished";
constexpr std::size_t randomLetters = 6;

std::string RandomLetters()
{
  std::random_device random;
  std::string letters;
  while (letters.size() < randomLetters)
  {
    letters += static_cast<char>('a' + random() % 26);
  }
  return letters;
}

// Removes what writers of this store that were killed have left: theirs are locked by nobody.
void RemoveLeftovers(const std::filesystem::path& folder, const std::string& prefix)
{
  std::error_code ignored;
  std::vector<std::filesystem::path> left;
  for (std::filesystem::directory_iterator entry(folder, ignored), end; entry != end;
       entry.increment(ignored))
  {
    const std::string name = entry->path().filename().string();
    if (name.size() == prefix.size() + randomLetters + unfinished.size() &&
        name.starts_with(prefix) && name.ends_with(unfinished))
    {
      left.push_back(entry->path());
    }
  }
  for (const std::filesystem::path& path : left)
  {
    const int descriptor = ::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
    if (descriptor >= 0 && ::flock(descriptor, LOCK_EX | LOCK_NB) == 0)
    {
      ::unlink(path.c_str());
    }
    if (descriptor >= 0)
    {
      ::close(descriptor);
    }
  }
}

bool IsLinked(int descriptor)
{
  struct stat state = {};
  return ::fstat(descriptor, &state) == 0 && state.st_nlink > 0;
}

// Gives a file the owner, the group and the permissions of the one that it replaces.
Status TakeOverAccess(int file, const struct stat& replaced)
{
  mode_t mode = replaced.st_mode & 0777;
  // Only root gives files away, and others only to a group that they belong to.
  if (::fchown(file, replaced.st_uid, replaced.st_gid) != 0 &&
      ::fchown(file, static_cast<uid_t>(-1), replaced.st_gid) != 0)
  {
    mode &= ~mode_t{ 070 } | (mode & 07) << 3; // another group may do what everybody may
  }
  return ::fchmod(file, mode) == 0
           ? Status{}
           : Status{ SystemError("cannot be given its permissions", errno) };
}

Status SyncFolder(const std::filesystem::path& folder)
{
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0)
  {
    return SystemError("cannot open to make durable", errno);
  }
  const Status synced =
    ::fsync(descriptor) == 0 ? Status{} : Status{ SystemError("cannot make durable", errno) };
  ::close(descriptor);
  return synced;
}

}

UnfinishedStore::UnfinishedStore(UnfinishedStore&& other) noexcept
  : Target(std::move(other.Target))
  , Temporary(std::exchange(other.Temporary, {}))
  , File(std::exchange(other.File, -1))
{
}

UnfinishedStore::~UnfinishedStore()
{
  if (!this->Temporary.empty())
  {
    ::unlink(this->Temporary.c_str());
  }
  if (this->File >= 0)
  {
    ::close(this->File);
  }
}

std::filesystem::path UnfinishedStore::Folder() const
{
  return this->Target.has_parent_path() ? this->Target.parent_path() : ".";
}

Result<UnfinishedStore> UnfinishedStore::Create(const std::filesystem::path& store)
{
  UnfinishedStore file(store);
  KDSTREAM_TRY(file.MakeFile());
  return file;
}

Status UnfinishedStore::MakeFile()
{
  const std::string prefix = "." + this->Target.filename().string() + ".";
  RemoveLeftovers(this->Folder(), prefix);
  struct stat replaced = {};
  // Whoever opens the file now can read all that is written later.
  const mode_t mode = ::stat(this->Target.c_str(), &replaced) == 0 ? 0600 : 0666;
  for (;;)
  {
    const std::filesystem::path name =
      this->Folder() / (prefix + RandomLetters() + std::string(unfinished));
    this->File = ::open(name.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, mode);
    if (this->File < 0 && errno == EEXIST)
    {
      continue;
    }
    if (this->File < 0)
    {
      return SystemError("cannot create a file in " + this->Folder().string(), errno);
    }
    // Before it was locked another writer may have taken it for a leftover.
    const bool taken = ::flock(this->File, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    if (!taken && IsLinked(this->File))
    {
      this->Temporary = name;
      return {};
    }
    ::unlink(name.c_str());
    ::close(std::exchange(this->File, -1));
  }
}

int UnfinishedStore::WhyFull() const
{
  // Some pages may have room where a piece had none.
  const std::vector<char> block(std::size_t{ 1 } << 16);
  const off_t end = ::lseek(this->File, 0, SEEK_END);
  const ssize_t written = ::pwrite(this->File, block.data(), block.size(), end);
  if (written >= 0 && static_cast<std::size_t>(written) < block.size())
  {
    return ENOSPC;
  }
  return written < 0 && IsDiskFull(errno) ? errno : 0;
}

Status UnfinishedStore::Finish()
{
  struct stat replaced = {};
  if (::stat(this->Target.c_str(), &replaced) == 0)
  {
    KDSTREAM_TRY(TakeOverAccess(this->File, replaced));
  }
  if (::fsync(this->File) != 0)
  {
    return SystemError("cannot make durable", errno);
  }
  if (::rename(this->Temporary.c_str(), this->Target.c_str()) != 0)
  {
    return SystemError("cannot be put in place", errno);
  }
  this->Temporary.clear();
  return SyncFolder(this->Folder());
}

}
