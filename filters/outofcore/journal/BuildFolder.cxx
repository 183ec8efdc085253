// SPDX-License-Identifier: BSD-3-Clause
// Build folders: see BuildFolder.h.
//   NAME         files, named by number, and `journal`
//   NAME.lock    locked by the process that builds, and removed only by that process
#include "filters/outofcore/journal/BuildFolder.h"

#include "filters/core/SystemReason.h"
#include "filters/files/Folders.h"
#include "filters/outofcore/journal/BuildFingerprint.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <cerrno>
#include <map>
#include <memory>
#include <set>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace kdstream
{
namespace
{

namespace fs = std::filesystem;

// A locked file. It is removed while it is still locked, so the next process must lock a new one.
class FileLock
{
public:
  FileLock(fs::path path, FileHook hook)
    : Path(std::move(path))
    , Hook(std::move(hook))
  {
  }
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;
  ~FileLock()
  {
    if (this->Descriptor < 0)
    {
      return;
    }
    if (this->Hook)
    {
      this->Hook(FileOperation::Remove);
    }
    unlink(this->Path.c_str());
    close(this->Descriptor);
  }

  void Hold(int descriptor) { this->Descriptor = descriptor; }

private:
  int Descriptor = -1;
  fs::path Path;
  FileHook Hook;
};

Result<bool> IsSameFile(int descriptor, const fs::path& path)
{
  struct stat opened = {}, named = {};
  if (fstat(descriptor, &opened) != 0 || (stat(path.c_str(), &named) != 0 && errno != ENOENT))
  {
    return SystemError(path.string() + " cannot be examined", errno);
  }
  return opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

Result<std::shared_ptr<void>> Lock(const fs::path& path, const FileHook& hook)
{
  // Allocated before locking: afterwards there may be no memory.
  const auto lock = std::make_shared<FileLock>(path, hook);
  for (;;)
  {
    const int descriptor =
      open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, S_IRUSR | S_IWUSR);
    if (descriptor < 0)
    {
      return SystemError("cannot create the lock " + path.string(), errno);
    }
    if (flock(descriptor, LOCK_EX | LOCK_NB) != 0)
    {
      const int reason = errno;
      close(descriptor);
      if (reason == EWOULDBLOCK)
      {
        return Error{ ErrorCode::LimitExceeded,
          "another build of this store is running: it has locked " + path.string() };
      }
      return SystemError(path.string() + " cannot be locked", reason);
    }
    // Its previous owner may have removed the file between our open and our lock.
    const Result<bool> isSame = IsSameFile(descriptor, path);
    if (isSame && *isSame)
    {
      lock->Hold(descriptor);
      return std::shared_ptr<void>(lock);
    }
    close(descriptor);
    KDSTREAM_TRY(isSame);
  }
}

// Whether the folder is this user's, and only this user's. Its name can be predicted, and others
// may be able to write to its parent folder.
bool IsOwnFolder(const fs::path& path)
{
  struct stat found = {};
  return lstat(path.c_str(), &found) == 0 && S_ISDIR(found.st_mode) && found.st_uid == geteuid() &&
         (found.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

Status MakeFolder(const fs::path& path)
{
  if (mkdir(path.c_str(), S_IRWXU) == 0)
  {
    return {};
  }
  if (errno != EEXIST)
  {
    return SystemError("cannot create the folder for temporary files " + path.string(), errno);
  }
  if (!IsOwnFolder(path))
  {
    return Error{ ErrorCode::InputOutput,
      path.string() + " is not a folder that only this user can write to" };
  }
  return {};
}

// The time of the last change to a file's bytes, in nanoseconds.
std::int64_t TimeOf(const struct stat& state)
{
  return std::int64_t{ state.st_mtim.tv_sec } * 1000000000 + state.st_mtim.tv_nsec;
}

Status SyncBuildFolder(const fs::path& path)
{
  const int descriptor = open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0 || fsync(descriptor) != 0)
  {
    const int reason = errno;
    if (descriptor >= 0)
    {
      close(descriptor);
    }
    return SystemError(
      "temporary folder " + path.string() + " cannot be written", reason, path.parent_path());
  }
  close(descriptor);
  return {};
}

// Whether a process builds in the folder now.
bool IsLocked(const fs::path& path)
{
  const int descriptor = open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW);
  if (descriptor < 0)
  {
    return false;
  }
  const bool locked = flock(descriptor, LOCK_EX | LOCK_NB) != 0;
  close(descriptor);
  return locked;
}

fs::path LockOf(fs::path path)
{
  path += ".lock";
  return path;
}

}

fs::path BuildFolder::PathFor(const fs::path& store, const fs::path& temporaryFolder)
{
  const fs::path canonical = CanonicalPath(store);
  const std::string whole = canonical.string();
  constexpr const char* digits = "0123456789abcdef";
  std::string hash;
  for (std::uint64_t rest = XXH3_64bits(whole.data(), whole.size()), i = 0; i < 16; ++i, rest >>= 4)
  {
    hash += digits[rest & 15];
  }
  // A file name has at most 255 bytes.
  constexpr std::size_t longestName = 200;
  const std::string name = "." + canonical.filename().string().substr(0, longestName) + "." + hash;
  return (temporaryFolder.empty() ? canonical.parent_path() : temporaryFolder) / (name + ".build");
}

Result<BuildFolder> BuildFolder::Open(
  const fs::path& path, std::string_view fingerprint, bool resume, FileHook hook)
{
  const std::string disk = path.parent_path().string(); // the folder that the user knows
  Result<std::shared_ptr<void>> lock = Lock(LockOf(path), hook);
  if (!lock && lock.GetError().code != ErrorCode::LimitExceeded) // is not an error of the folder
  {
    return OfFile(disk, std::move(lock)).GetError();
  }
  KDSTREAM_TRY(lock);
  if (hook)
  {
    hook(FileOperation::Create);
  }
  auto ledger = std::make_shared<detail::SpillLedger>();
  ledger->folder = path;
  KDSTREAM_TRY(OfFile(disk, MakeFolder(path)));
  ledger->hook = std::move(hook);
  ledger->lock = std::move(*lock);
  ledger->sums = true;
  BuildFolder folder{ SpillFolder(std::move(ledger)) };
  if (Status taken = folder.TakeUp(fingerprint, resume); !taken)
  {
    folder.Keep(true);
    return taken.GetError();
  }
  return folder;
}

std::optional<LeftBuild> BuildFolder::LeftIn(const fs::path& path)
{
  if (!IsOwnFolder(path) || IsLocked(LockOf(path)))
  {
    return {};
  }
  auto ledger = std::make_shared<detail::SpillLedger>();
  ledger->folder = path;
  ledger->keepFolder = true;
  const BuildFolder folder{ SpillFolder(std::move(ledger)) };
  const Result<PhaseJournal> journal = folder.ReadJournal();
  const std::size_t usable =
    journal ? UsablePhases(*journal, [&](const JournalFile& file) { return folder.IsThere(file); })
            : 0;
  return usable == 0
           ? std::nullopt
           : std::optional(LeftBuild{ journal->fingerprint, journal->phases[usable - 1].name });
}

BuildFolder::~BuildFolder()
{
  if (this->Folder.Ledger && !this->Folder.Ledger->keepFolder)
  {
    // The journal goes first: without it the other files do not count, wherever this is
    // interrupted.
    this->Folder.Ledger->Note(FileOperation::Remove);
    unlink(this->JournalPath.c_str());
  }
}

void BuildFolder::Keep(bool keep)
{
  this->Folder.Ledger->keepFolder = keep;
}

fs::path BuildFolder::PathOf(std::uint64_t number) const
{
  return this->Folder.Path() / std::to_string(number);
}

bool BuildFolder::IsThere(const JournalFile& file) const
{
  struct stat state = {};
  return lstat(this->PathOf(file.number).c_str(), &state) == 0 && S_ISREG(state.st_mode) &&
         static_cast<std::uint64_t>(state.st_size) == file.bytes && TimeOf(state) == file.changed;
}

bool BuildFolder::IsWhole(const JournalFile& file) const
{
  if (!this->IsThere(file))
  {
    return false;
  }
  const Result<SpillFile> opened = this->OpenKept(this->PathOf(file.number), file.name, file);
  const Result<std::uint64_t> sum = opened ? opened->ReadSum() : opened.GetError();
  return sum && *sum == file.sum;
}

Status BuildFolder::TakeUp(std::string_view fingerprint, bool resume)
{
  Result<PhaseJournal> found =
    resume ? this->ReadJournal() : Error{ ErrorCode::NotFound, "not requested" };
  if (found)
  {
    KDSTREAM_TRY(CheckSameBuild(found->fingerprint, fingerprint));
  }
  this->Earlier = found                                          ? Found::SameBuild
                  : found.GetError().code == ErrorCode::NotFound ? Found::Nothing
                                                                 : Found::Damaged;
  if (this->Earlier == Found::SameBuild)
  {
    this->Journal = std::move(*found);
  }
  else
  {
    this->Folder.Ledger->Note(FileOperation::Remove);
    RemoveTree(this->JournalPath); // whatever has this name
    this->Journal.fingerprint = fingerprint;
  }
  std::uint64_t next = 0;
  for (const JournalPhase& phase : this->Journal.phases)
  {
    for (const JournalFile& file : phase.files)
    {
      // Numbers of removed files count too, because the old journal names them until it is
      // replaced.
      next = file.number == JournalFile::noNumber ? next : std::max(next, file.number + 1);
    }
  }
  this->Folder.Ledger->files = next;
  std::map<std::pair<std::uint64_t, std::uint64_t>, bool> whole; // by number and sum
  const std::size_t usable = UsablePhases(this->Journal,
    [&](const JournalFile& file)
    {
      const auto [known, isNew] = whole.try_emplace({ file.number, file.sum });
      known->second = isNew ? this->IsWhole(file) : known->second;
      return known->second;
    });
  this->Lost = usable < this->Journal.phases.size();
  this->Journal.phases.resize(usable);
  this->RemoveUnnamed();
  return {};
}

void BuildFolder::RemoveUnnamed()
{
  std::set<std::string> named;
  for (const JournalPhase& phase : this->Journal.phases)
  {
    for (const JournalFile& file : phase.files)
    {
      if (file.releasedAfter == 0 && file.number != JournalFile::noNumber &&
          named.insert(std::to_string(file.number)).second)
      {
        this->Folder.Ledger->Grow(file.bytes);
      }
    }
  }
  named.insert(journalName);
  const auto found = NamesIn(this->Folder.Path());
  for (const std::string& name : found ? *found : std::vector<std::string>())
  {
    if (!named.count(name))
    {
      this->Folder.Ledger->Note(FileOperation::Remove);
      RemoveTree(this->Folder.Path() / name);
    }
  }
}

Result<PhaseJournal> BuildFolder::ReadJournal() const
{
  const fs::path path = this->JournalPath;
  struct stat state = {};
  if (lstat(path.c_str(), &state) != 0 || !S_ISREG(state.st_mode))
  {
    return Error{ ErrorCode::NotFound, "there is no journal" };
  }
  const auto size = static_cast<std::uint64_t>(state.st_size);
  Result<SpillFile> file = this->OpenKept(path, "journal of the build", { journalName, 0, size });
  KDSTREAM_TRY(file);
  std::vector<std::byte> bytes(std::min<std::uint64_t>(size, journalHeadBytes));
  KDSTREAM_TRY(file->Read(0, bytes));
  if (ClaimedJournalBytes(bytes) != size)
  {
    return Error{ ErrorCode::Damaged, "not a build journal of this version" };
  }
  bytes.resize(static_cast<std::size_t>(size));
  KDSTREAM_TRY(file->Read(0, bytes));
  return DecodeJournal(bytes);
}

Status BuildFolder::WriteJournal(const PhaseJournal& journal)
{
  const std::vector<std::byte> bytes = EncodeJournal(journal);
  Result<SpillFile> file = this->Folder.CreateFile("entries of the journal", bytes.size());
  KDSTREAM_TRY(file);
  KDSTREAM_TRY(file->Write(0, bytes));
  KDSTREAM_TRY(file->Sync());
  this->Folder.Ledger->Note(FileOperation::Rename);
  if (rename(file->Path.c_str(), this->JournalPath.c_str()) != 0)
  {
    return SystemError(
      file->Describe() + " cannot be renamed", errno, this->Folder.Path().parent_path());
  }
  file->Kept = true;
  this->Folder.Ledger->onDisk -= bytes.size(); // the journal does not count as a spill file
  this->Folder.Ledger->Note(FileOperation::Sync);
  return SyncBuildFolder(this->Folder.Path());
}

const JournalPhase* BuildFolder::Find(std::string_view phase) const
{
  const auto found = std::find_if(this->Journal.phases.begin(), this->Journal.phases.end(),
    [&](const JournalPhase& other) { return other.name == phase; });
  return found == this->Journal.phases.end() ? nullptr : &*found;
}

bool BuildFolder::Finished(std::string_view phase) const
{
  return this->Find(phase) != nullptr;
}

BlobReader BuildFolder::BlobOf(std::string_view phase) const
{
  return BlobReader(this->Find(phase)->blob);
}

Status BuildFolder::Finish(std::string_view phase, const BlobWriter& blob,
  std::span<PhaseFile> files, std::initializer_list<PhaseFileName> givenUp)
{
  PhaseJournal journal = this->Journal;
  JournalPhase& finished = journal.phases.emplace_back();
  finished.name = phase;
  finished.blob = blob.Bytes();
  for (const PhaseFile& left : files)
  {
    JournalFile& entry = finished.files.emplace_back();
    entry.name = left.name;
    if (!left.file.IsOpen())
    {
      continue;
    }
    entry.number = left.file.Number;
    entry.bytes = left.file.Size();
    KDSTREAM_TRY(left.file.Kept ? Status{} : left.file.Sync());
    struct stat state = {};
    if (fstat(left.file.Descriptor, &state) != 0)
    {
      return SystemError(
        left.file.Describe() + " cannot be examined", errno, this->Folder.Path().parent_path());
    }
    entry.changed = TimeOf(state);
    const Result<std::uint64_t> sum = left.file.Sum();
    KDSTREAM_TRY(sum);
    entry.sum = *sum;
  }
  const std::vector<JournalFile> released = GiveUp(journal, givenUp);
  KDSTREAM_TRY(this->WriteJournal(journal));
  this->Journal = std::move(journal);
  for (PhaseFile& left : files)
  {
    left.file.Kept = left.file.IsOpen();
    left.file.Remove();
  }
  for (const JournalFile& file : released)
  {
    this->Folder.Ledger->Note(FileOperation::Remove);
    unlink(this->PathOf(file.number).c_str());
    this->Folder.Ledger->onDisk -= file.bytes;
  }
  return {};
}

std::vector<JournalFile> BuildFolder::GiveUp(
  PhaseJournal& journal, std::initializer_list<PhaseFileName> files)
{
  const auto isGivenUp = [&](const JournalPhase& phase, const JournalFile& file)
  {
    return std::any_of(files.begin(), files.end(),
      [&](const PhaseFileName& name)
      { return name.phase == phase.name && (name.file.empty() || name.file == file.name); });
  };
  std::set<std::uint64_t> needed;
  std::map<std::uint64_t, JournalFile> released; // by number
  for (JournalPhase& phase : journal.phases)
  {
    for (JournalFile& file : phase.files)
    {
      if (file.releasedAfter > 0 || file.number == JournalFile::noNumber)
      {
        continue;
      }
      if (isGivenUp(phase, file))
      {
        file.releasedAfter = journal.phases.size();
        released.emplace(file.number, file);
      }
      else
      {
        needed.insert(file.number);
      }
    }
  }
  std::vector<JournalFile> removed;
  for (const auto& [number, file] : released)
  {
    if (!needed.count(number))
    {
      removed.push_back(file);
    }
  }
  return removed;
}

Result<SpillFile> BuildFolder::TakeFile(std::string_view phase, std::string_view file) const
{
  const std::string purpose = std::string(file) + " of phase " + std::string(phase);
  if (const JournalPhase* finished = this->Find(phase))
  {
    for (const JournalFile& left : finished->files)
    {
      if (left.name == file && left.releasedAfter == 0)
      {
        return left.number == JournalFile::noNumber
                 ? Result<SpillFile>(SpillFile())
                 : this->OpenKept(this->PathOf(left.number), purpose, left);
      }
    }
  }
  return Error{ ErrorCode::NotFound, "there is no file of " + purpose };
}

Result<SpillFile> BuildFolder::OpenKept(
  const fs::path& path, std::string_view purpose, const JournalFile& file) const
{
  SpillFile opened;
  opened.Ledger = this->Folder.Ledger;
  opened.Path = path;
  opened.Number = file.number;
  opened.Purpose = purpose;
  opened.Expected = file.bytes;
  opened.Bytes = file.bytes;
  opened.Kept = true;
  opened.KeptSum = file.sum;
  opened.Descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  if (opened.Descriptor < 0)
  {
    return SystemError(
      opened.Describe() + " cannot be opened", errno, path.parent_path().parent_path());
  }
  return opened;
}

}
