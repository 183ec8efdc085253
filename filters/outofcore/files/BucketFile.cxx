// SPDX-License-Identifier: BSD-3-Clause
#include "filters/outofcore/files/BucketFile.h"

#include <algorithm>

namespace kdstream
{

Result<BucketFile> BucketFile::Create(SpillFolder& folder, std::string_view purpose,
  std::size_t recordBytes, std::size_t buckets, std::uint64_t expectedRecords, std::uint64_t memory)
{
  // The last block of every bucket may be short; so each bucket needs a block of its own.
  const std::uint64_t share = std::min<std::uint64_t>(memory / buckets, spillBlockBytes);
  BucketFile result;
  result.RecordBytes = recordBytes;
  result.BlockBytes =
    static_cast<std::size_t>(std::max<std::uint64_t>(1, share / recordBytes)) * recordBytes;
  result.Buckets.resize(buckets);
  const std::uint64_t bytes = expectedRecords * recordBytes;
  Result<SpillFile> file = folder.CreateFile(purpose, bytes);
  KDSTREAM_TRY(file);
  result.File = std::move(*file);
  return result;
}

Status BucketFile::Add(std::size_t bucket, std::span<const std::byte> records)
{
  Bucket& target = this->Buckets[bucket];
  if (target.open.capacity() == 0)
  {
    target.open.reserve(this->BlockBytes);
  }
  target.records += records.size() / this->RecordBytes;
  while (!records.empty())
  {
    const auto some =
      records.first(std::min(records.size(), this->BlockBytes - target.open.size()));
    target.open.insert(target.open.end(), some.begin(), some.end());
    records = records.subspan(some.size());
    if (target.open.size() == this->BlockBytes)
    {
      KDSTREAM_TRY(this->Flush(target));
    }
  }
  return {};
}

Status BucketFile::Finish()
{
  for (Bucket& bucket : this->Buckets)
  {
    if (!bucket.open.empty())
    {
      KDSTREAM_TRY(this->Flush(bucket));
    }
    bucket.open = {};
  }
  return {};
}

Status BucketFile::Flush(Bucket& bucket)
{
  const Status written = this->File.Write(
    std::uint64_t{ this->NextBlock } * this->BlockBytes, std::span<const std::byte>(bucket.open));
  bucket.blocks.push_back(this->NextBlock++);
  bucket.open.clear();
  return written;
}

Status BucketFile::ForEachBlock(
  std::size_t bucket, const std::function<Status(std::span<const std::byte> records)>& visit) const
{
  const Bucket& source = this->Buckets[bucket];
  std::vector<std::byte> block;
  std::uint64_t left = source.records * this->RecordBytes;
  for (const std::uint32_t place : source.blocks)
  {
    block.resize(static_cast<std::size_t>(std::min<std::uint64_t>(left, this->BlockBytes)));
    left -= block.size();
    KDSTREAM_TRY(
      this->File.Read(std::uint64_t{ place } * this->BlockBytes, std::span<std::byte>(block)));
    KDSTREAM_TRY(visit(block));
  }
  return {};
}

SpillFile BucketFile::Save(BlobWriter& blob)
{
  blob.Add(static_cast<std::uint64_t>(this->BlockBytes));
  blob.Add(static_cast<std::uint64_t>(this->Buckets.size()));
  for (const Bucket& bucket : this->Buckets)
  {
    blob.Add(bucket.records);
    blob.AddList(bucket.blocks);
  }
  return std::move(this->File);
}

Result<BucketFile> BucketFile::Restore(SpillFile file, std::size_t recordBytes, BlobReader& blob)
{
  const Error damaged{ ErrorCode::Damaged,
    "the buckets of a finished phase do not match their file" };
  BucketFile result;
  result.RecordBytes = recordBytes;
  result.BlockBytes = static_cast<std::size_t>(blob.Read<std::uint64_t>());
  const auto buckets = blob.Read<std::uint64_t>();
  if (result.BlockBytes == 0 || result.BlockBytes % recordBytes != 0)
  {
    return damaged;
  }
  const std::uint64_t most = file.Size() / recordBytes, perBlock = result.BlockBytes / recordBytes;
  for (std::uint64_t b = 0; b < buckets && blob.Good(); ++b)
  {
    Bucket& bucket = result.Buckets.emplace_back();
    bucket.records = blob.Read<std::uint64_t>();
    bucket.blocks = blob.ReadList<std::uint32_t>();
    if (bucket.records > most ||
        bucket.blocks.size() != bucket.records / perBlock + (bucket.records % perBlock != 0))
    {
      return damaged;
    }
  }
  if (!blob.Good() || result.Buckets.size() != buckets)
  {
    return damaged;
  }
  result.File = std::move(file);
  return result;
}

}
