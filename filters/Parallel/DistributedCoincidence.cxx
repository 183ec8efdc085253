// SPDX-License-Identifier: BSD-3-Clause
// Vertices in the same place: see DistributedCoincidence.h.
//   1. Send each place with its rank in the tree to a process, which puts it into a bucket, by the
//      hash of the place.
//   2. Go through each bucket, ranks ascending, and remember the last rank at each place.
//   3. Send the resulting pairs to the processes that have their lower ends.
#include "filters/Parallel/DistributedCoincidence.h"

#include "filters/core/levels/ClusterRound.h"
#include "filters/core/tree/PointRecord.h"
#include "filters/outofcore/files/NumberSet.h"
#include "filters/outofcore/mesh/CellTriangles.h"
#include "filters/outofcore/mesh/LastRanks.h"

#include <algorithm>

namespace kdstream
{
namespace
{

struct Pair
{
  VertexId low, high;
};

template <class Scalar>
class CoincidenceLinker
{
public:
  using Record = PointRecord<Scalar>;

  CoincidenceLinker(
    MpiGroup& group, SpillFolder& folder, const MeshBlocks& mesh, std::uint64_t memory)
    : Group(group)
    , Folder(folder)
    , Mesh(mesh)
    , Memory(memory)
    , BlockOf(mesh.vertexCount, mesh.blockDepth)
  {
  }

  Result<DistributedCoincidence> Link()
  {
    KDSTREAM_TRY(this->SendPlaces());
    KDSTREAM_TRY(this->FindPairs());
    this->Places.reset();
    KDSTREAM_TRY(this->SendPairs());
    return std::move(this->Output);
  }

private:
  // Sends places to processes, which put them into buckets. For each group of hashes there is one
  // bucket for each sending process: read one after the other, these buckets have ascending ranks.
  Status SendPlaces()
  {
    const std::size_t processes = this->Group.Count();
    const std::uint64_t most =
      std::max<std::uint64_t>(1, this->Memory / 4 / LastRanks<Scalar>::bytesPerPlace);
    this->Hashes = this->Mesh.vertexCount / processes / most + 1;
    Result<RecordBuckets<Record>> buckets = RecordBuckets<Record>::Create(this->Folder, "places",
      static_cast<std::size_t>(this->Hashes) * processes, 0, this->Memory / 4);
    KDSTREAM_TRY(buckets);
    this->Places.emplace(std::move(*buckets));
    const BlockRange here = this->Group.Here(this->Mesh.blockDepth);
    const std::vector<VertexId> begins = this->Mesh.BlockBegins();
    const VertexId first = begins[here.begin], end = begins[here.end];
    constexpr std::size_t ofRound = ElementsOfRound(sizeof(Record));
    const auto make = [&](std::uint64_t round, RankLists<Record>& out) -> Status
    {
      const auto from = static_cast<VertexId>(first + round * ofRound);
      std::vector<Record> records(std::min<std::size_t>(ofRound, end - from));
      KDSTREAM_TRY(ReadRecords<Record>(this->Mesh.records, from, std::span<Record>(records)));
      for (std::size_t i = 0; i < records.size(); ++i)
      {
        const Record place = RankedPlace(records[i], static_cast<VertexId>(from + i));
        out[HashOfPlace(place.p, agreedSeed) % processes].push_back(place);
      }
      return {};
    };
    const auto take = [&](std::size_t from, std::span<const Record> places) -> Status
    {
      for (const Record& place : places)
      {
        const std::uint64_t hash = HashOfPlace(place.p, agreedSeed) / processes % this->Hashes;
        KDSTREAM_TRY(this->Places->Add(static_cast<std::size_t>(hash) * processes + from, place));
      }
      return {};
    };
    KDSTREAM_TRY(
      this->Group.template ExchangeInRounds<Record>(RoundsOf(end - first, ofRound), make, take));
    return this->Places->Finish();
  }

  Status FindPairs()
  {
    Result<SpillFile> file = this->Folder.CreateFile("coincident vertices", 0);
    KDSTREAM_TRY(file);
    this->Pairs = std::move(*file);
    RecordWriter<Pair> writer(this->Pairs);
    const std::function<Status(VertexId, VertexId)> visit = [&](VertexId a, VertexId b) -> Status
    {
      writer.Append({ a, b });
      return {};
    };
    LastRanks<Scalar> last(visit);
    for (std::size_t bucket = 0; bucket < this->Places->BucketCount(); ++bucket)
    {
      if (bucket % this->Group.Count() == 0)
      {
        last.Clear();
      }
      KDSTREAM_TRY(
        this->Places->ForEach(bucket, [&](const Record& place) { return last.Add(place); }));
    }
    this->PairCount = writer.Position();
    return writer.Finish();
  }

  Status SendPairs()
  {
    Result<RecordBuckets<Triangle>> links = RecordBuckets<Triangle>::Create(
      this->Folder, "coincident vertices", this->Mesh.BlockCount(), 0, this->Memory / 4);
    KDSTREAM_TRY(links);
    NumberSet<VertexId> foreign;
    constexpr std::size_t ofRound = ElementsOfRound(sizeof(Pair));
    const BlockRange here = this->Group.Here(this->Mesh.blockDepth);
    const auto make = [&](std::uint64_t round, RankLists<Pair>& out) -> Status
    {
      const std::uint64_t from = round * ofRound;
      std::vector<Pair> pairs(std::min<std::uint64_t>(ofRound, this->PairCount - from));
      KDSTREAM_TRY(ReadRecords<Pair>(this->Pairs, from, std::span<Pair>(pairs)));
      for (const Pair& pair : pairs)
      {
        out[this->Group.OwnerOf(this->BlockOf(pair.low), this->Mesh.blockDepth)].push_back(pair);
      }
      return {};
    };
    const auto take = [&](std::size_t, std::span<const Pair> pairs) -> Status
    {
      for (const auto& [low, high] : pairs)
      {
        const std::size_t block = this->BlockOf(high);
        if (block < here.begin || block >= here.end)
        {
          foreign.Add(high);
        }
        KDSTREAM_TRY(links->Add(this->BlockOf(low), CollapsedTriangleOf({ low, high })));
      }
      return {};
    };
    KDSTREAM_TRY(
      this->Group.template ExchangeInRounds<Pair>(RoundsOf(this->PairCount, ofRound), make, take));
    KDSTREAM_TRY(links->Finish());
    this->Output.foreign = foreign.Take();
    this->Output.links.emplace(std::move(*links));
    return {};
  }

  MpiGroup& Group;
  SpillFolder& Folder;
  const MeshBlocks& Mesh;
  const std::uint64_t Memory;
  const CellOfRank BlockOf;
  std::uint64_t Hashes = 1;
  std::optional<RecordBuckets<Record>> Places;
  SpillFile Pairs;
  std::uint64_t PairCount = 0;
  DistributedCoincidence Output;
};

}

Status DistributedCoincidence::Load(std::size_t block, std::vector<Triangle>& triangles) const
{
  return this->links ? this->links->ForEach(block,
                         [&](const Triangle& link) -> Status
                         {
                           triangles.push_back(link);
                           return {};
                         })
                     : Status{};
}

Result<DistributedCoincidence> LinkCoincidentCollectively(
  MpiGroup& group, SpillFolder& folder, const MeshBlocks& mesh, std::uint64_t memory)
{
  return mesh.floats ? CoincidenceLinker<float>(group, folder, mesh, memory).Link()
                     : CoincidenceLinker<double>(group, folder, mesh, memory).Link();
}

}
