// SPDX-License-Identifier: BSD-3-Clause
// A table of records on disk, in a file without a name: for readers of step "read" that must look
// up more data than fits into memory.
#pragma once

#include "filters/core/Result.h"

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

namespace kdstream
{

// The file under the table. It consists of blocks, some of which are in memory. Memory: at most 2
// MiB. The file disappears with the object, however the process ends.
class ScratchFile
{
public:
  // folder: where the file is made; if empty, the system's folder for temporary files. recordSize:
  // in bytes, at most one block.
  ScratchFile(std::filesystem::path folder, std::size_t recordSize);
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;
  ~ScratchFile();

  // The bytes of a record; zeros if it was never changed. `change`: whether the caller will write
  // to these bytes. Valid until the next call. Expected O(1). Errors: InputOutput, naming the
  // folder and what it is for.
  Result<char*> At(std::uint64_t record, bool change)
  {
    const std::uint64_t block = record / this->RecordsPerBlock;
    const std::size_t offset =
      static_cast<std::size_t>(record % this->RecordsPerBlock) * this->RecordSize;
    Slot& slot = this->Slots[block % this->Slots.size()];
    if (!slot.bytes || slot.block != block)
    {
      KDSTREAM_TRY(this->Load(slot, block));
    }
    slot.changed |= change;
    return slot.bytes.get() + offset;
  }

private:
  static constexpr std::size_t blockSize = 4096;
  static constexpr std::size_t slotCount = 512;

  struct Slot
  {
    std::uint64_t block = 0;
    bool changed = false;
    std::unique_ptr<char[]> bytes;
  };

  Status Load(Slot& slot, std::uint64_t block);
  Status Write(const Slot& slot);
  Status Open();
  Error Failure(const char* what) const;

  std::filesystem::path Folder;
  std::size_t RecordSize;
  std::uint64_t RecordsPerBlock;
  int Descriptor = -1;
  std::uint64_t Blocks = 0; // in the file
  std::vector<Slot> Slots;
};

// Records of a plain type, which all begin as zeros.
template <class T>
class ScratchTable
{
  static_assert(std::is_trivially_copyable_v<T>);

public:
  explicit ScratchTable(const std::filesystem::path& folder)
    : File(folder, sizeof(T))
  {
  }

  std::uint64_t Size() const { return this->Count; }
  Status Append(const T& record) { return this->Set(this->Count++, record); }
  Status Set(std::uint64_t index, const T& record)
  {
    const Result<char*> place = this->File.At(index, true);
    KDSTREAM_TRY(place);
    std::memcpy(*place, &record, sizeof(T));
    return {};
  }
  Result<T> Get(std::uint64_t index)
  {
    const Result<char*> place = this->File.At(index, false);
    KDSTREAM_TRY(place);
    T record;
    std::memcpy(&record, *place, sizeof(T));
    return record;
  }

private:
  ScratchFile File;
  std::uint64_t Count = 0;
};

}
