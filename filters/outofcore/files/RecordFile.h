// SPDX-License-Identifier: BSD-3-Clause
// Records of a fixed size in spill files: read and written at any place, or one after the other in
// large blocks.
#pragma once

#include "filters/outofcore/files/SpillFile.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

namespace kdstream
{

// Records are written as they are in memory, and read by the process that wrote them.
template <class Record>
concept SpillRecord = std::is_trivially_copyable_v<Record>;

// Reads or writes records, beginning with number `first`. Errors: those of SpillFile.
template <SpillRecord Record>
Status ReadRecords(const SpillFile& file, std::uint64_t first, std::span<Record> records)
{
  return file.Read(first * sizeof(Record), std::as_writable_bytes(records));
}

template <SpillRecord Record>
Status WriteRecords(SpillFile& file, std::uint64_t first, std::span<const Record> records)
{
  return file.Write(first * sizeof(Record), std::as_bytes(records));
}

// How many records fit in a block of about `bytes`; at least 1.
template <SpillRecord Record>
constexpr std::size_t RecordsOfBlock(std::size_t bytes)
{
  return std::max<std::size_t>(1, bytes / sizeof(Record));
}

// Writes records one after the other, beginning with number `first`. After the first error Append
// does nothing, and Finish returns the error.
template <SpillRecord Record>
class RecordWriter
{
public:
  explicit RecordWriter(
    SpillFile& file, std::uint64_t first = 0, std::size_t blockBytes = spillBlockBytes)
    : File(file)
    , Next(first)
    , Most(RecordsOfBlock<Record>(blockBytes))
  {
    this->Block.reserve(this->Most);
  }

  void Append(const Record& record)
  {
    if (this->Block.size() == this->Most)
    {
      this->Flush();
    }
    this->Block.push_back(record);
  }

  Status Finish()
  {
    this->Flush();
    return this->FirstError;
  }

  // The number of the record that is appended next.
  std::uint64_t Position() const { return this->Next + this->Block.size(); }

private:
  void Flush()
  {
    if (this->FirstError)
    {
      this->FirstError =
        WriteRecords<Record>(this->File, this->Next, std::span<const Record>(this->Block));
    }
    this->Next += this->Block.size();
    this->Block.clear();
  }

  SpillFile& File;
  std::uint64_t Next;
  std::size_t Most;
  std::vector<Record> Block;
  Status FirstError;
};

// Reads the records [first, last) block by block.
template <SpillRecord Record>
class RecordReader
{
public:
  RecordReader(const SpillFile& file, std::uint64_t first, std::uint64_t last,
    std::size_t blockBytes = spillBlockBytes)
    : File(file)
    , First(first)
    , Last(last)
    , Most(RecordsOfBlock<Record>(blockBytes))
  {
  }

  // The next block of records, valid until the next call; empty at the end.
  Result<std::span<const Record>> Next()
  {
    this->Block.resize(
      static_cast<std::size_t>(std::min<std::uint64_t>(this->Most, this->Last - this->First)));
    KDSTREAM_TRY(ReadRecords<Record>(this->File, this->First, std::span<Record>(this->Block)));
    this->First += this->Block.size();
    return std::span<const Record>(this->Block);
  }

private:
  const SpillFile& File;
  std::uint64_t First, Last;
  std::size_t Most;
  std::vector<Record> Block;
};

// Calls use(records) for the records [first, last), block after block. Errors: those of SpillFile.
template <SpillRecord Record, class Use>
Status ForEachBlockOf(
  const SpillFile& file, std::uint64_t first, std::uint64_t last, const Use& use)
{
  RecordReader<Record> reader(file, first, last);
  for (;;)
  {
    const Result<std::span<const Record>> records = reader.Next();
    KDSTREAM_TRY(records);
    if (records->empty())
    {
      return {};
    }
    use(*records);
  }
}

}
