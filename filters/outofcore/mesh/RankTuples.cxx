// SPDX-License-Identifier: BSD-3-Clause
// Tuples in the order of the tree: see RankTuples.h.
//   1. Put the tuples with their ranks into buckets, by sections of the ranks.
//   2. For each section, put each tuple into its place in memory, then write the section to the
//      file.
#include "filters/outofcore/mesh/RankTuples.h"

#include "filters/outofcore/files/BucketFile.h"

#include <algorithm>
#include <cstring>
#include <vector>

namespace kdstream
{
namespace
{

constexpr std::string_view tupleStep = "faces";

class TupleSorter
{
public:
  TupleSorter(SpillFolder& folder, const SpillFile& tuples, std::size_t tupleBytes,
    const VertexMap& ranks, std::uint64_t memory, const Execution& execution)
    : Folder(folder)
    , Tuples(tuples)
    , TupleBytes(tupleBytes)
    , Ranks(ranks)
    , Memory(memory)
    , Exec(execution)
    , Sections(MapSections::Over(ranks.count, memory / 2, tupleBytes))
  {
  }

  Result<SpillFile> Sort()
  {
    Result<SpillFile> sorted = this->Folder.CreateFile(
      "attributes of vertices", std::uint64_t{ this->Ranks.count } * this->TupleBytes);
    KDSTREAM_TRY(sorted);
    KDSTREAM_TRY(
      this->Sections.Number() <= 1 ? this->SortAtOnce(*sorted) : this->SortBySections(*sorted));
    return sorted;
  }

private:
  using Bytes = std::span<const std::byte>;

  Status Report(double begin, double end, std::uint64_t done) const
  {
    return this->Exec.Report(
      tupleStep, begin + (end - begin) * double(done) / double(std::max(1U, this->Ranks.count)));
  }

  // Calls visit(rank, tuple) for each vertex, by ascending id.
  template <class Visit>
  Status ForEachTuple(double end, const Visit& visit) const
  {
    const std::size_t most = std::max<std::size_t>(1, spillBlockBytes / this->TupleBytes);
    std::vector<VertexId> ranks;
    std::vector<std::byte> tuples;
    for (std::uint64_t first = 0; first < this->Ranks.count; first += ranks.size())
    {
      ranks.resize(
        static_cast<std::size_t>(std::min<std::uint64_t>(most, this->Ranks.count - first)));
      tuples.resize(ranks.size() * this->TupleBytes);
      KDSTREAM_TRY(ReadRecords<VertexId>(this->Ranks.file, first, std::span<VertexId>(ranks)));
      KDSTREAM_TRY(this->Tuples.Read(first * this->TupleBytes, std::span<std::byte>(tuples)));
      for (std::size_t i = 0; i < ranks.size(); ++i)
      {
        KDSTREAM_TRY(
          visit(ranks[i], Bytes(tuples).subspan(i * this->TupleBytes, this->TupleBytes)));
      }
      KDSTREAM_TRY(this->Report(0, end, first + ranks.size()));
    }
    return {};
  }

  // Where the tuple of a rank goes in the section that is being filled. first: the first rank of
  // the section.
  std::byte* PlaceOf(VertexId rank, VertexId first)
  {
    return this->Section.data() + std::size_t{ rank - first } * this->TupleBytes;
  }

  Status SortAtOnce(SpillFile& sorted)
  {
    this->Section.resize(std::size_t{ this->Ranks.count } * this->TupleBytes);
    KDSTREAM_TRY(this->ForEachTuple(1,
      [&](VertexId rank, Bytes tuple) -> Status
      {
        std::copy(tuple.begin(), tuple.end(), this->PlaceOf(rank, 0));
        return {};
      }));
    return sorted.Write(0, this->Section);
  }

  Status SortBySections(SpillFile& sorted)
  {
    const std::size_t stride = this->TupleBytes + sizeof(VertexId);
    Result<BucketFile> buckets =
      BucketFile::Create(this->Folder, "attributes of vertices with their ranks", stride,
        this->Sections.Number(), this->Ranks.count, this->Memory / 4);
    KDSTREAM_TRY(buckets);
    std::vector<std::byte> record(stride);
    KDSTREAM_TRY(this->ForEachTuple(0.5,
      [&](VertexId rank, Bytes tuple)
      {
        std::memcpy(record.data(), &rank, sizeof(rank));
        std::copy(tuple.begin(), tuple.end(), record.begin() + sizeof(rank));
        return buckets->Add(this->Sections.Of(rank), record);
      }));
    KDSTREAM_TRY(buckets->Finish());
    for (std::size_t section = 0; section < this->Sections.Number(); ++section)
    {
      KDSTREAM_TRY(this->WriteSection(*buckets, section, sorted));
    }
    return {};
  }

  // Step 2.
  Status WriteSection(const BucketFile& buckets, std::size_t section, SpillFile& sorted)
  {
    const std::size_t stride = this->TupleBytes + sizeof(VertexId);
    const VertexId first = this->Sections.Begin(section), last = this->Sections.End(section);
    this->Section.resize(std::size_t{ last - first } * this->TupleBytes);
    KDSTREAM_TRY(buckets.ForEachBlock(section,
      [&](Bytes records) -> Status
      {
        for (; !records.empty(); records = records.subspan(stride))
        {
          VertexId rank = 0;
          std::memcpy(&rank, records.data(), sizeof(rank));
          const Bytes tuple = records.subspan(sizeof(rank), this->TupleBytes);
          std::copy(tuple.begin(), tuple.end(), this->PlaceOf(rank, first));
        }
        return {};
      }));
    KDSTREAM_TRY(sorted.Write(std::uint64_t{ first } * this->TupleBytes, this->Section));
    return this->Report(0.5, 1, last);
  }

  SpillFolder& Folder;
  const SpillFile& Tuples;
  std::size_t TupleBytes;
  const VertexMap& Ranks;
  std::uint64_t Memory;
  const Execution& Exec;
  MapSections Sections; // of the ranks
  std::vector<std::byte> Section;
};

}

Result<SpillFile> SortTuplesByRank(SpillFolder& folder, const SpillFile& tuples,
  std::size_t tupleBytes, const VertexMap& ranks, std::uint64_t memory, const Execution& execution)
{
  return TupleSorter(folder, tuples, tupleBytes, ranks, memory, execution).Sort();
}

}
