#include "filters/outofcore/BucketFile.h"

#include <algorithm>

namespace kdstream
{

Result<BucketFile> BucketFile::Create(SpillFolder& folder, std::string_view purpose,
  std::size_t recordBytes, std::size_t buckets, std::uint64_t expectedRecords, std::uint64_t memory)
{
  // Every bucket may leave its last block short.
  const std::uint64_t share = std::min<std::uint64_t>(memory / buckets, spillBlockBytes);
  BucketFile result;
  result.RecordBytes = recordBytes;
  result.BlockBytes =
    static_cast<std::size_t>(std::max<std::uint64_t>(1, share / recordBytes)) * recordBytes;
  result.Buckets.resize(buckets);
  const std::uint64_t bytes = expectedRecords * recordBytes;
  Result<SpillFile> file = folder.CreateFile(purpose, bytes);
  if (!file)
  {
    return file.GetError();
  }
  result.File = std::move(*file);
  return result;
}

Status BucketFile::Add(std::size_t bucket, std::span<const std::byte> record)
{
  Bucket& target = this->Buckets[bucket];
  if (target.open.capacity() == 0)
  {
    target.open.reserve(this->BlockBytes);
  }
  target.open.insert(target.open.end(), record.begin(), record.end());
  ++target.records;
  return target.open.size() == this->BlockBytes ? this->Flush(target) : Status{};
}

Status BucketFile::Finish()
{
  for (Bucket& bucket : this->Buckets)
  {
    if (!bucket.open.empty())
    {
      if (Status status = this->Flush(bucket); !status)
      {
        return status;
      }
    }
    bucket.open = {};
  }
  return {};
}

Status BucketFile::Flush(Bucket& bucket)
{
  const Status status = this->File.Write(
    std::uint64_t{ this->NextBlock } * this->BlockBytes, std::span<const std::byte>(bucket.open));
  bucket.blocks.push_back(this->NextBlock++);
  bucket.open.clear();
  return status;
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
    Status status =
      this->File.Read(std::uint64_t{ place } * this->BlockBytes, std::span<std::byte>(block));
    if (status)
    {
      status = visit(block);
    }
    if (!status)
    {
      return status;
    }
  }
  return {};
}

}
