// SPDX-License-Identifier: BSD-3-Clause
// The median by external merge sort (Baselines.h). Steps:
//   a. In one pass sort as many keys as fit in memory at a time, and write them as a run.
//   b. While there are more runs than can be merged at the same time, merge groups of runs.
//   c. The last merge writes nothing, and ends at the wanted rank.
#include "filters/baselines/stores/Baselines.h"

#include "filters/outofcore/files/RecordFile.h"

#include <algorithm>
#include <vector>

namespace kdstream
{
namespace
{

// The keys [begin, end) of a file, sorted.
struct Run
{
  std::uint64_t begin = 0, end = 0;
};

// Merges runs of a file: gives the smallest remaining key again and again.
class Merge
{
public:
  Merge(const SpillFile& file, std::span<const Run> runs, std::size_t blockBytes)
  {
    for (const Run& run : runs)
    {
      this->Sources.push_back(
        Source{ RecordReader<OrderKey>(file, run.begin, run.end, blockBytes), {}, 0 });
    }
  }

  Status Start()
  {
    for (std::size_t i = 0; i < this->Sources.size(); ++i)
    {
      KDSTREAM_TRY(this->Push(i));
    }
    return {};
  }

  // The next key. REQUIRES: keys are left.
  Result<OrderKey> Next()
  {
    std::pop_heap(this->Heads.begin(), this->Heads.end());
    const Head head = this->Heads.back();
    this->Heads.pop_back();
    KDSTREAM_TRY(this->Push(head.source));
    return head.key;
  }

private:
  struct Source
  {
    RecordReader<OrderKey> reader;
    std::span<const OrderKey> block;
    std::size_t next = 0;
  };
  struct Head
  {
    OrderKey key;
    std::size_t source = 0;
    bool operator<(const Head& other) const { return other.key < this->key; } // the least on top
  };

  Status Push(std::size_t index)
  {
    Source& source = this->Sources[index];
    if (source.next == source.block.size())
    {
      Result<std::span<const OrderKey>> block = source.reader.Next();
      KDSTREAM_TRY(block);
      source.block = *block;
      source.next = 0;
    }
    if (source.next < source.block.size())
    {
      this->Heads.push_back({ source.block[source.next++], index });
      std::push_heap(this->Heads.begin(), this->Heads.end());
    }
    return {};
  }

  std::vector<Source> Sources;
  std::vector<Head> Heads;
};

// Step a. The runs are written one after the other.
Result<std::vector<Run>> WriteRuns(KeySource& keys, std::size_t most, SpillFile& file)
{
  std::vector<Run> runs;
  std::vector<OrderKey> buffer;
  buffer.reserve(most);
  const auto flush = [&]() -> Status
  {
    if (buffer.empty())
    {
      return {};
    }
    std::sort(buffer.begin(), buffer.end());
    const std::uint64_t begin = runs.empty() ? 0 : runs.back().end;
    runs.push_back({ begin, begin + buffer.size() });
    KDSTREAM_TRY(WriteRecords<OrderKey>(file, begin, std::span<const OrderKey>(buffer)));
    buffer.clear();
    return {};
  };
  KDSTREAM_TRY(keys.Pass([](std::size_t, std::span<OrderKey> block) { return block.size(); },
    [&](std::span<const OrderKey> block) -> Status
    {
      while (!block.empty())
      {
        const std::size_t count = std::min(block.size(), most - buffer.size());
        buffer.insert(buffer.end(), block.begin(), block.begin() + std::ptrdiff_t(count));
        block = block.subspan(count);
        if (buffer.size() == most)
        {
          KDSTREAM_TRY(flush());
        }
      }
      return {};
    }));
  KDSTREAM_TRY(flush());
  return runs;
}

// Step b: merges some runs into one, at the same place in another file.
Result<Run> MergeRuns(KeySource& keys, const SpillFile& from, SpillFile& to,
  std::span<const Run> runs, std::size_t blockBytes)
{
  const Run merged{ runs.front().begin, runs.back().end };
  Merge merge(from, runs, blockBytes);
  KDSTREAM_TRY(merge.Start());
  RecordWriter<OrderKey> writer(to, merged.begin, blockBytes);
  constexpr std::uint64_t betweenLooks = 1 << 20;
  for (std::uint64_t i = merged.begin; i < merged.end; ++i)
  {
    const Result<OrderKey> key = merge.Next();
    KDSTREAM_TRY(key);
    writer.Append(*key);
    if (i % betweenLooks == 0)
    {
      KDSTREAM_TRY(keys.GoOn());
    }
  }
  KDSTREAM_TRY(writer.Finish());
  return merged;
}

// Step c: the last merge.
Result<OrderKey> KeyOfRank(
  const SpillFile& file, std::span<const Run> runs, std::uint64_t rank, std::size_t blockBytes)
{
  Merge merge(file, runs, blockBytes);
  KDSTREAM_TRY(merge.Start());
  for (std::uint64_t i = 0; i < rank; ++i)
  {
    if (Result<OrderKey> key = merge.Next(); !key)
    {
      return key.GetError();
    }
  }
  return merge.Next();
}

}

Result<KeyRange> FindMedianBySort(KeySource& keys, const MedianSearch& search, SpillFolder& folder)
{
  const std::uint64_t bytes = search.known.inside * sizeof(OrderKey);
  Result<SpillFile> file = folder.CreateFile("sorted keys", bytes);
  KDSTREAM_TRY(file);
  const auto most =
    static_cast<std::size_t>(std::max<std::uint64_t>(2, search.memory / sizeof(OrderKey)));
  Result<std::vector<Run>> runs = WriteRuns(keys, most, *file);
  KDSTREAM_TRY(runs);
  // One block for reading each run, and one for writing.
  const auto blockBytes = static_cast<std::size_t>(
    std::clamp<std::uint64_t>(search.memory / 8, sizeof(OrderKey), spillBlockBytes));
  const std::size_t fanIn =
    static_cast<std::size_t>(std::max<std::uint64_t>(2, search.memory / blockBytes - 1));
  while (runs->size() > fanIn)
  {
    Result<SpillFile> merged = folder.CreateFile("merged keys", bytes);
    KDSTREAM_TRY(merged);
    std::vector<Run> fewer;
    for (std::size_t i = 0; i < runs->size(); i += fanIn)
    {
      const std::span<const Run> group =
        std::span<const Run>(*runs).subspan(i, std::min(fanIn, runs->size() - i));
      const Result<Run> run = MergeRuns(keys, *file, *merged, group, blockBytes);
      KDSTREAM_TRY(run);
      fewer.push_back(*run);
    }
    *runs = std::move(fewer);
    *file = std::move(*merged);
    KDSTREAM_TRY(keys.OwnPass());
  }
  KDSTREAM_TRY(keys.OwnPass());
  const Result<OrderKey> key = KeyOfRank(*file, *runs, search.rank, blockBytes);
  KDSTREAM_TRY(key);
  return KeyRange{ *key, *key, search.rank, 1 };
}

}
