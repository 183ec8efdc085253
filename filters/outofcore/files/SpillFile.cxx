// SPDX-License-Identifier: BSD-3-Clause
// Files for data that do not fit in memory: see SpillFile.h.
#include "filters/outofcore/files/SpillFile.h"

#include "filters/core/SystemReason.h"
#include "filters/files/Folders.h"
#include "filters/outofcore/files/LockedFolder.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <cerrno>
#include <mutex>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <sys/statvfs.h>
#include <unistd.h>

namespace kdstream
{
namespace
{

// The kernel transfers at most 2 GiB in one call.
constexpr std::size_t bytesAtOnce = std::size_t{ 1 } << 30;

// The free bytes of the folder's disk; 0 if the system does not report them.
std::uint64_t FreeBytes(const std::filesystem::path& folder)
{
  struct statvfs state = {};
  if (statvfs(folder.c_str(), &state) != 0)
  {
    return 0;
  }
  return std::uint64_t{ state.f_bavail } * state.f_frsize;
}

// "the build needs about 12 MiB there; ", or empty if the need is unknown.
std::string InAll(std::uint64_t bytes)
{
  return bytes == 0 ? std::string()
                    : "the build needs about " + std::to_string((bytes >> 20) + 1) + " MiB there; ";
}

Error FullDisk(const detail::SpillLedger& ledger, std::string_view purpose, std::uint64_t needed,
  std::uint64_t present, int reason)
{
  return { ErrorCode::DiskFull,
    "the temporary folder is too small: " + InAll(ledger.expected) + std::string(purpose) +
      " need " + std::to_string(needed) + " bytes, of which " + std::to_string(present) +
      " are written; " + std::to_string(FreeBytes(ledger.folder)) +
      " bytes are free on its disk, and other temporary files take " +
      std::to_string(ledger.onDisk.load() - std::min(ledger.onDisk.load(), present)) + " (" +
      SystemReason(reason) + ")",
    ledger.Disk() };
}

}

// The checksum of a file that is written from beginning to end. If a place is skipped or written
// twice, there is none, and the file has to be read afterwards.
class detail::SumOfWrites
{
public:
  SumOfWrites() { XXH3_64bits_reset(&this->State); }

  void Add(std::uint64_t offset, std::span<const std::byte> bytes)
  {
    const std::lock_guard lock(this->Mutex);
    this->InOrder = this->InOrder && offset == this->End;
    if (this->InOrder)
    {
      XXH3_64bits_update(&this->State, bytes.data(), bytes.size());
      this->End += bytes.size();
    }
  }

  // The checksum of a file of `size` bytes; nothing unless all its bytes were written in order.
  std::optional<std::uint64_t> Of(std::uint64_t size) const
  {
    const std::lock_guard lock(this->Mutex);
    return this->InOrder && this->End == size ? std::optional(XXH3_64bits_digest(&this->State))
                                              : std::nullopt;
  }

private:
  mutable std::mutex Mutex;
  XXH3_state_t State;
  std::uint64_t End = 0;
  bool InOrder = true;
};

void detail::SpillLedger::Note(FileOperation operation) const
{
  if (this->hook)
  {
    this->hook(operation);
  }
}

std::string detail::SpillLedger::Disk() const
{
  return this->folder.parent_path().string();
}

void detail::SpillLedger::Grow(std::uint64_t bytes)
{
  const std::uint64_t now = this->onDisk += bytes;
  std::uint64_t peak = this->peakOnDisk.load();
  while (peak < now && !this->peakOnDisk.compare_exchange_weak(peak, now))
  {
  }
}

SpillFile& SpillFile::operator=(SpillFile&& other) noexcept
{
  if (this != &other)
  {
    this->Remove();
    this->Ledger = std::move(other.Ledger);
    this->Path = std::exchange(other.Path, {});
    this->Number = std::exchange(other.Number, 0);
    this->Purpose = std::exchange(other.Purpose, {});
    this->Expected = std::exchange(other.Expected, 0);
    this->Bytes = other.Bytes.exchange(0);
    this->Descriptor = std::exchange(other.Descriptor, -1);
    this->Kept = std::exchange(other.Kept, false);
    this->KeptSum = std::exchange(other.KeptSum, 0);
    this->Written = std::move(other.Written);
  }
  return *this;
}

void SpillFile::Remove()
{
  if (this->Descriptor < 0)
  {
    return;
  }
  close(std::exchange(this->Descriptor, -1));
  const std::uint64_t bytes = this->Bytes.exchange(0);
  this->Written.reset();
  if (!std::exchange(this->Kept, false))
  {
    this->Ledger->Note(FileOperation::Remove);
    unlink(this->Path.c_str());
    this->Ledger->onDisk -= bytes;
  }
  this->Ledger.reset();
}

std::string SpillFile::Describe() const
{
  return "temporary file " + this->Path.string() + " (" + this->Purpose + ")";
}

Status SpillFile::Read(std::uint64_t offset, std::span<std::byte> bytes) const
{
  this->Ledger->bytesRead += bytes.size();
  while (!bytes.empty())
  {
    const ssize_t count = pread(this->Descriptor, bytes.data(), std::min(bytes.size(), bytesAtOnce),
      static_cast<off_t>(offset));
    if (count < 0 && errno == EINTR)
    {
      continue;
    }
    if (count <= 0)
    {
      return Error{ ErrorCode::InputOutput,
        this->Describe() + ": " + std::to_string(bytes.size()) + " bytes at offset " +
          std::to_string(offset) +
          " cannot be read: " + (count < 0 ? SystemReason(errno) : "the file ends before them"),
        this->Ledger->Disk() };
    }
    bytes = bytes.subspan(static_cast<std::size_t>(count));
    offset += static_cast<std::uint64_t>(count);
  }
  return {};
}

Status SpillFile::Write(std::uint64_t offset, std::span<const std::byte> bytes)
{
  if (this->Kept)
  {
    return Error{ ErrorCode::InputOutput,
      this->Describe() + " belongs to a finished phase and cannot be written",
      this->Ledger->Disk() };
  }
  const std::uint64_t first = offset;
  const std::span<const std::byte> all = bytes;
  while (!bytes.empty())
  {
    this->Ledger->Note(FileOperation::Write);
    const ssize_t count = pwrite(this->Descriptor, bytes.data(),
      std::min(bytes.size(), bytesAtOnce), static_cast<off_t>(offset));
    if (count < 0)
    {
      const int reason = errno;
      if (reason == EINTR)
      {
        continue;
      }
      if (IsDiskFull(reason))
      {
        return FullDisk(*this->Ledger, this->Purpose,
          std::max(this->Expected, offset + bytes.size()), this->Size(), reason);
      }
      return Error{ ErrorCode::InputOutput,
        this->Describe() + ": " + std::to_string(bytes.size()) + " bytes at offset " +
          std::to_string(offset) + " cannot be written: " + SystemReason(reason),
        this->Ledger->Disk() };
    }
    bytes = bytes.subspan(static_cast<std::size_t>(count));
    offset += static_cast<std::uint64_t>(count);
    this->Ledger->bytesWritten += static_cast<std::uint64_t>(count);
    std::uint64_t size = this->Bytes.load();
    while (size < offset && !this->Bytes.compare_exchange_weak(size, offset))
    {
    }
    if (size < offset)
    {
      this->Ledger->Grow(offset - size);
    }
  }
  if (this->Written)
  {
    this->Written->Add(first, all);
  }
  return {};
}

Result<std::uint64_t> SpillFile::Sum() const
{
  if (this->Kept)
  {
    return this->KeptSum;
  }
  const auto known = this->Written ? this->Written->Of(this->Size()) : std::nullopt;
  return known ? Result<std::uint64_t>(*known) : this->ReadSum();
}

Result<std::uint64_t> SpillFile::ReadSum() const
{
  XXH3_state_t state;
  XXH3_64bits_reset(&state);
  const std::uint64_t size = this->Size();
  std::vector<std::byte> block(
    static_cast<std::size_t>(std::min<std::uint64_t>(size, spillBlockBytes)));
  for (std::uint64_t at = 0; at < size; at += block.size())
  {
    block.resize(static_cast<std::size_t>(std::min<std::uint64_t>(block.size(), size - at)));
    KDSTREAM_TRY(this->Read(at, block));
    XXH3_64bits_update(&state, block.data(), block.size());
  }
  return static_cast<std::uint64_t>(XXH3_64bits_digest(&state));
}

Status SpillFile::Sync() const
{
  this->Ledger->Note(FileOperation::Sync);
  if (fsync(this->Descriptor) != 0)
  {
    const int reason = errno;
    return IsDiskFull(reason)
             ? FullDisk(*this->Ledger, this->Purpose, this->Expected, this->Size(), reason)
             : Error{ ErrorCode::InputOutput,
                 this->Describe() + " cannot be written: " + SystemReason(reason),
                 this->Ledger->Disk() };
  }
  return {};
}

Result<SpillFolder> SpillFolder::Create(const std::filesystem::path& parent)
{
  Result<LockedFolder> made = MakeLockedFolder(parent);
  KDSTREAM_TRY(made);
  auto ledger = std::make_shared<detail::SpillLedger>();
  ledger->folder = std::move(made->path);
  ledger->lock = std::move(made->lock);
  return SpillFolder(std::move(ledger));
}

SpillFolder::~SpillFolder()
{
  if (this->Ledger && !this->Ledger->keepFolder)
  {
    this->Ledger->Note(FileOperation::Remove);
    RemoveTree(this->Ledger->folder);
  }
}

SpillCounts SpillFolder::Counts() const
{
  return { this->Ledger->bytesRead.load(), this->Ledger->bytesWritten.load(),
    this->Ledger->onDisk.load(), this->Ledger->peakOnDisk.load() };
}

Result<SpillFile> SpillFolder::CreateFile(std::string_view purpose, std::uint64_t bytes)
{
  SpillFile file;
  file.Ledger = this->Ledger;
  file.Purpose = purpose;
  file.Expected = bytes;
  file.Number = this->Ledger->files++;
  file.Path = this->Ledger->folder / std::to_string(file.Number);
  this->Ledger->Note(FileOperation::Create);
  file.Descriptor = open(file.Path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (file.Descriptor < 0)
  {
    return Error{ ErrorCode::InputOutput,
      file.Describe() + " cannot be created: " + SystemReason(errno), this->Ledger->Disk() };
  }
  int reason = 0;
  if (bytes > 0 &&
      fallocate(file.Descriptor, FALLOC_FL_KEEP_SIZE, 0, static_cast<off_t>(bytes)) != 0)
  {
    reason = errno;
    if (!IsDiskFull(reason))
    {
      // The file system cannot allocate in advance. Then the free bytes that it reports must do.
      reason = FreeBytes(this->Ledger->folder) < bytes ? ENOSPC : 0;
    }
  }
  if (reason != 0)
  {
    return FullDisk(*this->Ledger, purpose, bytes, 0, reason);
  }
  file.Written = this->Ledger->sums ? std::make_shared<detail::SumOfWrites>() : nullptr;
  return file;
}

}
