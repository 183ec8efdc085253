// SPDX-License-Identifier: BSD-3-Clause
// Sorts records into buckets while they are written to a file. This is the pass that brings
// together records that belong together when they do not fit in memory.
#pragma once

#include "filters/outofcore/files/Blob.h"
#include "filters/outofcore/files/RecordFile.h"
#include "filters/outofcore/files/SpillFile.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

namespace kdstream
{

// A file of buckets of records, all of one size. Records of a bucket keep their order. The file is
// a list of blocks, and each block belongs to one bucket. Memory: one block for each bucket while
// writing, one block while reading, and 4 bytes a block.
class BucketFile
{
public:
  // expectedRecords: an upper bound of the number of records. memory: bytes for the blocks of all
  // buckets together; a block has at least one record, and at most 1 MiB. REQUIRES: buckets,
  // recordBytes > 0. Errors: those of SpillFolder.
  static Result<BucketFile> Create(SpillFolder& folder, std::string_view purpose,
    std::size_t recordBytes, std::size_t buckets, std::uint64_t expectedRecords,
    std::uint64_t memory);

  // Adds one record or several. REQUIRES: bucket < BucketCount(), records.size() a multiple of
  // recordBytes. Errors: those of SpillFile.
  Status Add(std::size_t bucket, std::span<const std::byte> records);
  // Writes the records that are still in memory. Nothing can be added afterwards.
  Status Finish();

  std::size_t BucketCount() const { return this->Buckets.size(); }
  std::uint64_t Size(std::size_t bucket) const { return this->Buckets[bucket].records; }

  // Passes the records of a bucket to `visit`, block by block; blocks hold whole records. REQUIRES:
  // Finish() was called. Errors: those of SpillFile and of `visit`.
  Status ForEachBlock(std::size_t bucket,
    const std::function<Status(std::span<const std::byte> records)>& visit) const;

  // For a phase of a build that leaves buckets (BuildFolder.h). Writes what the file does not hold,
  // about 4 bytes a block, into `blob`, and returns the file. REQUIRES: Finish() was called; the
  // object is not used afterwards.
  SpillFile Save(BlobWriter& blob);
  // The inverse of Save. Errors: Damaged if the file and the table in `blob` do not match.
  static Result<BucketFile> Restore(SpillFile file, std::size_t recordBytes, BlobReader& blob);

private:
  struct Bucket
  {
    std::uint64_t records = 0;
    std::vector<std::byte> open;       // the block that is filled now
    std::vector<std::uint32_t> blocks; // numbers of its full blocks; the last one may be short
  };

  Status Flush(Bucket& bucket);

  SpillFile File;
  std::size_t RecordBytes = 0;
  std::size_t BlockBytes = 0; // a multiple of RecordBytes
  std::uint32_t NextBlock = 0;
  std::vector<Bucket> Buckets;
};

// A bucket file of records of one type.
template <SpillRecord Record>
class RecordBuckets
{
public:
  static Result<RecordBuckets> Create(SpillFolder& folder, std::string_view purpose,
    std::size_t buckets, std::uint64_t expectedRecords, std::uint64_t memory)
  {
    Result<BucketFile> file =
      BucketFile::Create(folder, purpose, sizeof(Record), buckets, expectedRecords, memory);
    KDSTREAM_TRY(file);
    return RecordBuckets(std::move(*file));
  }

  Status Add(std::size_t bucket, const Record& record)
  {
    return this->File.Add(bucket, std::as_bytes(std::span(&record, 1)));
  }
  Status Add(std::size_t bucket, std::span<const Record> records)
  {
    return this->File.Add(bucket, std::as_bytes(records));
  }
  Status Finish() { return this->File.Finish(); }
  SpillFile Save(BlobWriter& blob) { return this->File.Save(blob); }
  static Result<RecordBuckets> Restore(SpillFile file, BlobReader& blob)
  {
    Result<BucketFile> restored = BucketFile::Restore(std::move(file), sizeof(Record), blob);
    return restored ? Result<RecordBuckets>(RecordBuckets(std::move(*restored)))
                    : restored.GetError();
  }
  std::size_t BucketCount() const { return this->File.BucketCount(); }
  std::uint64_t Size(std::size_t bucket) const { return this->File.Size(bucket); }

  // All records of a bucket, in the order in which they were added.
  Result<std::vector<Record>> ReadAll(std::size_t bucket) const
  {
    std::vector<Record> all(static_cast<std::size_t>(this->Size(bucket)));
    std::size_t read = 0;
    KDSTREAM_TRY(this->File.ForEachBlock(bucket,
      [&](std::span<const std::byte> records) -> Status
      {
        std::memcpy(all.data() + read, records.data(), records.size());
        read += records.size() / sizeof(Record);
        return {};
      }));
    return all;
  }

  // Calls visit(const Record&) -> Status for each record of the bucket, in the order in which they
  // were added.
  template <class Visit>
  Status ForEach(std::size_t bucket, const Visit& visit) const
  {
    return this->File.ForEachBlock(bucket,
      [&](std::span<const std::byte> records) -> Status
      {
        for (std::size_t at = 0; at < records.size(); at += sizeof(Record))
        {
          Record record;
          std::memcpy(&record, records.data() + at, sizeof(Record));
          KDSTREAM_TRY(visit(record));
        }
        return {};
      });
  }

private:
  explicit RecordBuckets(BucketFile file)
    : File(std::move(file))
  {
  }
  BucketFile File;
};

}
