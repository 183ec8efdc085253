// SPDX-License-Identifier: BSD-3-Clause
#include "filters/files/NewFile.h"

#include "filters/core/SystemReason.h"
#include "filters/files/Folders.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace kdstream
{
namespace
{

// The end of a file's name until it is complete. The name is ".NAME.", then random letters so that
// the name is not used yet, then this.
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

std::string PrefixOf(const std::filesystem::path& target)
{
  constexpr std::size_t longestName = 200; // of 255 bytes
  return "." + target.filename().string().substr(0, longestName) + ".";
}

std::filesystem::path FolderOf(const std::filesystem::path& target)
{
  return target.has_parent_path() ? target.parent_path() : ".";
}

Result<bool> IsLinked(int descriptor)
{
  struct stat state = {};
  if (::fstat(descriptor, &state) != 0)
  {
    return SystemError("cannot be written", errno);
  }
  return state.st_nlink > 0;
}

// The permissions with which a new file is created. They matter because whoever opens the file at
// this time can read everything that is written later. The umask is applied.
mode_t FirstMode(const std::filesystem::path& target, const struct stat* replaced)
{
  constexpr mode_t ofAnybody = 0666, ofOwner = 0600;
  struct stat link = {};
  if (!replaced)
  {
    return ofAnybody;
  }
  const bool isLink = ::lstat(target.c_str(), &link) == 0 && S_ISLNK(link.st_mode);
  return isLink ? (replaced->st_mode & ofAnybody) | ofOwner : ofOwner;
}

// Gives a file the owner, the group and the permissions of the one that it replaces.
Status TakeOverAccess(int file, const struct stat& replaced)
{
  mode_t mode = replaced.st_mode & 0777;
  // Only root can give files to other users; others can give them only to groups to which they
  // belong.
  if (::fchown(file, replaced.st_uid, replaced.st_gid) != 0 &&
      ::fchown(file, static_cast<uid_t>(-1), replaced.st_gid) != 0)
  {
    mode &= ~mode_t{ 070 } | (mode & 07) << 3; // another group may only do what everybody may
  }
  return ::fchmod(file, mode) == 0 ? Status{}
                                   : Status{ SystemError("its permissions cannot be set", errno) };
}

void CloseFile(int& descriptor)
{
  if (descriptor >= 0)
  {
    ::close(std::exchange(descriptor, -1));
  }
}

}

void NewFile::RemoveLeftovers(const std::filesystem::path& target)
{
  const std::string prefix = PrefixOf(target);
  const auto names = NamesIn(FolderOf(target));
  std::vector<std::filesystem::path> left;
  for (const std::string& name : names ? *names : std::vector<std::string>())
  {
    if (name.size() == prefix.size() + randomLetters + unfinished.size() &&
        name.starts_with(prefix) && name.ends_with(unfinished))
    {
      left.push_back(FolderOf(target) / name);
    }
  }
  for (const std::filesystem::path& path : left)
  {
    // Files of writers that have ended are not locked.
    int descriptor = ::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
    if (descriptor >= 0 && ::flock(descriptor, LOCK_EX | LOCK_NB) == 0)
    {
      ::unlink(path.c_str());
    }
    CloseFile(descriptor);
  }
}

NewFile::NewFile(NewFile&& other) noexcept
{
  *this = std::move(other);
}

NewFile& NewFile::operator=(NewFile&& other) noexcept
{
  if (this != &other)
  {
    this->Discard();
    this->Place = std::move(other.Place);
    this->Temporary = std::exchange(other.Temporary, {});
    this->File = std::exchange(other.File, -1);
    this->FolderFile = std::exchange(other.FolderFile, -1);
  }
  return *this;
}

NewFile::~NewFile()
{
  this->Discard();
}

void NewFile::Discard()
{
  if (!this->Temporary.empty())
  {
    ::unlink(this->Temporary.c_str());
    this->Temporary.clear();
  }
  CloseFile(this->File);
  CloseFile(this->FolderFile);
}

std::filesystem::path NewFile::Folder() const
{
  return FolderOf(this->Place);
}

Result<NewFile> NewFile::Create(const std::filesystem::path& target)
{
  NewFile file(target);
  KDSTREAM_TRY(file.Make());
  return file;
}

Status NewFile::Make()
{
  struct stat replaced = {};
  const bool replaces = ::stat(this->Place.c_str(), &replaced) == 0;
  if (!replaces && errno != ENOENT) // then the new file's permissions are unknown
  {
    return SystemError("cannot be written", errno);
  }
  if (replaces && !S_ISREG(replaced.st_mode))
  {
    return Error{ ErrorCode::InputOutput, "cannot be written: it is not a regular file" };
  }
  // Opened now, so that errors occur before the rename. A folder that this user may write to but
  // not read cannot be synchronized.
  this->FolderFile = ::open(this->Folder().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (this->FolderFile < 0 && errno != EACCES && errno != EPERM)
  {
    return SystemError("cannot be written", errno);
  }
  const mode_t mode = FirstMode(this->Place, replaces ? &replaced : nullptr);
  for (;;)
  {
    std::filesystem::path name =
      this->Folder() / (PrefixOf(this->Place) + RandomLetters() + std::string(unfinished));
    this->File = ::open(name.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, mode);
    if (this->File < 0 && errno == EEXIST)
    {
      continue;
    }
    if (this->File < 0)
    {
      return SystemError("cannot be written", errno);
    }
    // Before the file was locked, another writer may have taken it for a leftover.
    const bool taken = ::flock(this->File, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    const Result<bool> linked = IsLinked(this->File);
    if (!taken && linked && *linked)
    {
      this->Temporary = std::move(name); // moved, not copied, because memory may have run out
      return {};
    }
    ::unlink(name.c_str());
    CloseFile(this->File);
    KDSTREAM_TRY(linked);
  }
}

Status NewFile::Write(std::string_view bytes)
{
  return WriteAll(this->File, bytes);
}

Status WriteAll(int descriptor, std::string_view bytes)
{
  while (!bytes.empty())
  {
    const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno != EINTR)
    {
      return SystemError("cannot be written", errno);
    }
    bytes.remove_prefix(written < 0 ? 0 : static_cast<std::size_t>(written));
  }
  return {};
}

int NewFile::WhyFull() const
{
  // Single pages may still fit where the failed write did not; the error after they are written
  // gives the reason.
  const std::vector<char> block(std::size_t{ 1 } << 16);
  const off_t end = ::lseek(this->File, 0, SEEK_END);
  for (std::size_t done = 0; done < block.size();)
  {
    const ssize_t written =
      ::pwrite(this->File, block.data(), block.size() - done, end + static_cast<off_t>(done));
    if (written <= 0)
    {
      return written == 0 ? ENOSPC : IsDiskFull(errno) ? errno : 0;
    }
    done += static_cast<std::size_t>(written);
  }
  return 0;
}

Status NewFile::Finish(Lasts lasts)
{
  struct stat replaced = {};
  const bool replaces = ::lstat(this->Place.c_str(), &replaced) == 0;
  if (!replaces && errno != ENOENT)
  {
    return SystemError("cannot be written", errno);
  }
  if (replaces && S_ISREG(replaced.st_mode))
  {
    KDSTREAM_TRY(TakeOverAccess(this->File, replaced));
  }
  if (lasts == Lasts::PowerCuts && ::fsync(this->File) != 0)
  {
    return SystemError("cannot be written", errno);
  }
  if (::rename(this->Temporary.c_str(), this->Place.c_str()) != 0)
  {
    return SystemError("cannot be renamed to its final name", errno);
  }
  this->Temporary.clear();
  // Some file systems cannot synchronize folders; the file itself is safe by now.
  const bool isSafe = lasts == Lasts::Processes || this->FolderFile < 0 ||
                      ::fsync(this->FolderFile) == 0 || errno != EIO;
  return isSafe
           ? Status{}
           : Status{ SystemError(
               "is written, but its folder cannot be flushed to disk: a power failure may lose it",
               EIO) };
}

}
