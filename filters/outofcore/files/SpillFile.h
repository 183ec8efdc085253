// SPDX-License-Identifier: BSD-3-Clause
// Files for data that do not fit in memory: a folder that is removed with its owner, and files in
// it that are read and written at any place in large blocks. Step "spill" of building out of core.
#pragma once

#include "filters/core/Result.h"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace kdstream
{

// The minimum size of a block of records. With smaller ones each read or write costs more than the
// transfer of its bytes.
inline constexpr std::size_t spillBlockBytes = std::size_t{ 1 } << 20;

// How many bytes were read and written in one folder so far, and how many are on disk.
struct SpillCounts
{
  std::uint64_t bytesRead = 0;
  std::uint64_t bytesWritten = 0;
  std::uint64_t bytesOnDisk = 0; // in files that exist now
  std::uint64_t peakBytesOnDisk = 0;
};

// The next operation in a folder. Only for tests, which kill a process at that point.
enum class FileOperation
{
  Create,
  Write,
  Sync,
  Rename,
  Remove
};
using FileHook = std::function<void(FileOperation)>;

namespace detail
{
struct SpillLedger
{
  std::filesystem::path folder;
  std::atomic<std::uint64_t> bytesRead{ 0 }, bytesWritten{ 0 }, onDisk{ 0 }, peakOnDisk{ 0 };
  std::atomic<std::uint64_t> files{ 0 };
  bool keepFolder = false;
  // Files may be kept: so checksums are computed while they are written in order.
  bool sums = false;
  FileHook hook;
  std::shared_ptr<void> lock; // the folder's lock, held while a file of it is open

  std::uint64_t expected = 0; // SpillFolder::Expect; 0: unknown

  void Note(FileOperation operation) const;

  // The name for error messages: the user's folder for temporary files, which contains this folder.
  std::string Disk() const;

  void Grow(std::uint64_t bytes);
};

class SumOfWrites;
}

// One file of a folder. The file is removed with this object, unless a finished phase of a build
// left it (BuildFolder.h); a file that was left can only be read. Can be moved, not copied. Any
// number of threads may read and write ranges that do not overlap.
class SpillFile
{
public:
  SpillFile() = default;
  SpillFile(SpillFile&& other) noexcept { *this = std::move(other); }
  SpillFile& operator=(SpillFile&& other) noexcept;
  ~SpillFile() { this->Remove(); }

  bool IsOpen() const { return this->Descriptor >= 0; }
  std::uint64_t Size() const { return this->Bytes.load(); }

  // Reads or writes all of `bytes` at `offset`. Writing past the end makes the file longer. Errors:
  // InputOutput with the system's reason and the place, and for a full disk the bytes that the file
  // needs; also if the file ends before all bytes are read.
  Status Read(std::uint64_t offset, std::span<std::byte> bytes) const;
  Status Write(std::uint64_t offset, std::span<const std::byte> bytes);

  // Closes the file now, and removes it unless a finished phase left it.
  void Remove();

private:
  friend class SpillFolder;
  friend class BuildFolder;

  std::string Describe() const;
  // Waits until everything that was written is on the disk.
  Status Sync() const;
  // The XXH3 of all bytes. It is known already if the bytes were written in order, or if a phase
  // left the file. Otherwise the file is read. Errors: InputOutput.
  Result<std::uint64_t> Sum() const;
  Result<std::uint64_t> ReadSum() const;

  std::shared_ptr<detail::SpillLedger> Ledger;
  std::filesystem::path Path;
  std::uint64_t Number = 0; // the file's name in the folder
  std::string Purpose;
  std::uint64_t Expected = 0;
  std::atomic<std::uint64_t> Bytes{ 0 };
  int Descriptor = -1;
  bool Kept = false;
  std::uint64_t KeptSum = 0;                    // checksum of a kept file
  std::shared_ptr<detail::SumOfWrites> Written; // running checksum of a file that may be kept
};

// A hidden folder with a unique name below a given one. The destructor removes it with all its
// content: at the end, after an error, and after Cancelled (Ctrl-C in the programs). The folder of
// a killed process is removed by the next build (LockedFolder.h).
class SpillFolder
{
public:
  // Errors: InputOutput if no folder can be made in `parent`.
  static Result<SpillFolder> Create(const std::filesystem::path& parent);

  SpillFolder(SpillFolder&&) noexcept = default;
  SpillFolder& operator=(SpillFolder&&) = delete;
  ~SpillFolder();

  const std::filesystem::path& Path() const { return this->Ledger->folder; }

  // Sets the number of bytes that all files together will probably need at most; the error for a
  // full disk reports it.
  void Expect(std::uint64_t bytes) { this->Ledger->expected = bytes; }

  SpillCounts Counts() const;

  // Makes a new empty file that will need `bytes` in all; `purpose` is its name in messages. The
  // bytes are allocated on the disk now, if the file system can do that. Errors: InputOutput; if
  // the disk is full, with the bytes that are needed and those that are free.
  Result<SpillFile> CreateFile(std::string_view purpose, std::uint64_t bytes);

private:
  friend class BuildFolder;

  explicit SpillFolder(std::shared_ptr<detail::SpillLedger> ledger)
    : Ledger(std::move(ledger))
  {
  }

  std::shared_ptr<detail::SpillLedger> Ledger;
};

}
