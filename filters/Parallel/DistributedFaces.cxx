// SPDX-License-Identifier: BSD-3-Clause
#include "filters/Parallel/DistributedFaces.h"

#include "filters/Parallel/DistributedFiles.h"
#include "filters/Parallel/NumberTable.h"
#include "filters/core/TakeResult.h"
#include "filters/core/tree/PointRecord.h"
#include "filters/outofcore/files/BucketFile.h"
#include "filters/outofcore/files/NumberSet.h"
#include "filters/outofcore/files/RecordFile.h"
#include "filters/outofcore/mesh/CellTriangles.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <optional>

namespace kdstream
{
namespace
{

constexpr std::size_t trianglesAtOnce = std::size_t{ 1 } << 18; // triangles
// Bytes for each triangle while its corners are looked up, without its tuples: on this rank, and on
// a rank that answers.
constexpr std::uint64_t bytesOfTriangle = 160;
constexpr std::uint64_t bytesOfQuestion = 36;

class FaceScatterer
{
public:
  FaceScatterer(MpiGroup& group, SpillFolder& folder, const SpilledMesh& share,
    DistributedVertices& vertices, std::uint64_t memory, MeshBlocks& mesh,
    const Execution& execution)
    : Group(group)
    , Folder(folder)
    , Share(share)
    , Vertices(vertices)
    , Memory(memory)
    , Mesh(mesh)
    , Exec(execution)
    , BlockOf(mesh.vertexCount, mesh.blockDepth)
    , Renumbered(vertices.numberOf.IsOpen())
  {
  }

  Status Scatter()
  {
    KDSTREAM_TRY(this->FindPlaces());
    KDSTREAM_TRY(this->ScatterTuples());
    KDSTREAM_TRY(this->CountTriangles());
    KDSTREAM_TRY(this->ScatterTriangles());
    return this->FetchForeign();
  }

private:
  std::size_t OwnerOfRank(VertexId rank) const
  {
    return this->Group.OwnerOf(this->BlockOf(rank), this->Mesh.blockDepth);
  }

  // Finds leaf positions in the tree: first of the vertices that are numbered on this rank, then of
  // those that it has read.
  Status FindPlaces()
  {
    KDSTREAM_TRY(this->Mesh.floats ? this->SendPlaces<float>() : this->SendPlaces<double>());
    SpillFile ranks;
    KDSTREAM_TRY(this->RanksOfSections(ranks));
    this->Places.reset();
    KDSTREAM_TRY(
      Take(NumberTable::Open(std::move(ranks), this->Vertices.kept.count, this->Memory / 4),
        this->Ranks));
    return this->Renumbered ? this->FindRanksOfRead() : Status{};
  }

  struct Place
  {
    VertexId vertex, rank;
  };

  // Sends the leaf positions of vertices to the ranks on which the vertices are numbered.
  template <class Scalar>
  Status SendPlaces()
  {
    using Record = PointRecord<Scalar>;
    this->Sections =
      MapSections::Over(this->Vertices.kept.count, this->Memory / 4, sizeof(VertexId));
    Result<RecordBuckets<Place>> buckets = RecordBuckets<Place>::Create(this->Folder,
      "places of vertices", std::max<std::size_t>(1, this->Sections.Number()), 0, this->Memory / 4);
    KDSTREAM_TRY(buckets);
    this->Places.emplace(std::move(*buckets));
    const std::vector<VertexId>& begin = this->Vertices.begin;
    const VertexId own = begin[this->Group.Rank()];
    const CellRange here = this->RanksHere();
    constexpr std::size_t ofRound = ElementsOfRound(sizeof(Record));
    const auto make = [&](std::uint64_t round, RankLists<Place>& out) -> Status
    {
      const std::uint64_t from = here.begin + round * ofRound;
      std::vector<Record> records(std::min<std::uint64_t>(ofRound, here.begin + here.size - from));
      KDSTREAM_TRY(ReadRecords<Record>(this->Mesh.records, from, std::span<Record>(records)));
      for (std::size_t i = 0; i < records.size(); ++i)
      {
        out[RankOfEntry(begin, records[i].id)].push_back(
          { records[i].id, static_cast<VertexId>(from + i) });
      }
      return {};
    };
    const auto take = [&](std::size_t, std::span<const Place> places) -> Status
    {
      for (const Place& place : places)
      {
        const VertexId vertex = place.vertex - own;
        KDSTREAM_TRY(this->Places->Add(this->Sections.Of(vertex), { vertex, place.rank }));
      }
      return {};
    };
    KDSTREAM_TRY(this->Group.ExchangeInRounds<Place>(RoundsOf(here.size, ofRound), make, take));
    return this->Places->Finish();
  }

  Status RanksOfSections(SpillFile& ranks)
  {
    KDSTREAM_TRY(Take(this->Folder.CreateFile("ranks of vertices", 0), ranks));
    for (std::size_t section = 0; section < this->Sections.Number(); ++section)
    {
      const VertexId begin = this->Sections.Begin(section);
      std::vector<VertexId> some(this->Sections.End(section) - begin);
      KDSTREAM_TRY(this->Places->ForEach(section,
        [&](const Place& place) -> Status
        {
          some[place.vertex - begin] = place.rank;
          return {};
        }));
      KDSTREAM_TRY(WriteRecords<VertexId>(ranks, begin, std::span<const VertexId>(some)));
    }
    return {};
  }

  Status FindRanksOfRead()
  {
    const std::vector<VertexId>& readBegin = this->Vertices.readBegin;
    const std::uint64_t count = readBegin[this->Group.Rank() + 1] - readBegin[this->Group.Rank()];
    constexpr std::size_t ofRound = ElementsOfRound(4 * sizeof(VertexId));
    SpillFile ranks;
    KDSTREAM_TRY(Take(this->Folder.CreateFile("ranks of vertices", 0), ranks));
    const Result<std::uint64_t> rounds = this->Group.Most(RoundsOf(count, ofRound));
    KDSTREAM_TRY(rounds);
    for (std::uint64_t round = 0; round < *rounds; ++round)
    {
      const std::uint64_t from = std::min(round * ofRound, count);
      std::vector<VertexId> numbers(std::min<std::uint64_t>(ofRound, count - from));
      KDSTREAM_TRY(
        ReadRecords<VertexId>(this->Vertices.numberOf, from, std::span<VertexId>(numbers)));
      const Result<std::vector<VertexId>> found =
        LookUpEntries(this->Group, this->Vertices.begin, this->Ranks, numbers);
      KDSTREAM_TRY(found);
      KDSTREAM_TRY(WriteRecords<VertexId>(ranks, from, std::span<const VertexId>(*found)));
    }
    this->Vertices.numberOf = {};
    return Take(NumberTable::Open(std::move(ranks), count, this->Memory / 4), this->RanksOfRead);
  }

  // The leaf positions of this rank's blocks.
  CellRange RanksHere() const
  {
    const BlockRange here = this->Group.Here(this->Mesh.blockDepth);
    const std::vector<VertexId> begins = this->Mesh.BlockBegins();
    return { begins[here.begin], begins[here.end] - begins[here.begin] };
  }

  // Sends the tuples of vertices to the ranks that have their leaf positions. There they are
  // collected in sections, each of which is then written in order.
  Status ScatterTuples()
  {
    const std::size_t bytes = this->Vertices.kept.tupleBytes;
    if (bytes == 0)
    {
      return {};
    }
    const CellRange here = this->RanksHere();
    const MapSections sections =
      MapSections::Over(static_cast<std::uint32_t>(here.size), this->Memory / 4, bytes);
    const std::size_t entryBytes = sizeof(VertexId) + bytes;
    Result<BucketFile> entries = BucketFile::Create(this->Folder, "attributes of vertices",
      entryBytes, std::max<std::size_t>(1, sections.Number()), 0, this->Memory / 4);
    KDSTREAM_TRY(entries);
    const std::size_t ofRound = ElementsOfRound(entryBytes);
    const auto make = [&](std::uint64_t round, RankLists<std::byte>& out)
    { return this->ReadTuples(round * ofRound, ofRound, out); };
    const auto take = [&](std::size_t, std::span<const std::byte> tuples) -> Status
    {
      for (std::size_t at = 0; at < tuples.size(); at += entryBytes)
      {
        const auto place = static_cast<VertexId>(RankAt(tuples, at) - here.begin);
        KDSTREAM_TRY(entries->Add(sections.Of(place), tuples.subspan(at, entryBytes)));
      }
      return {};
    };
    KDSTREAM_TRY(this->Group.ExchangeInRounds<std::byte>(
      RoundsOf(this->Vertices.kept.count, ofRound), make, take));
    this->Vertices.kept.tuples = {};
    KDSTREAM_TRY(entries->Finish());
    KDSTREAM_TRY(
      Take(this->Folder.CreateFile("attributes of vertices", 0), this->Mesh.pointTuples));
    for (std::size_t section = 0; section < sections.Number(); ++section)
    {
      KDSTREAM_TRY(this->WriteTuples(*entries, section, here.begin + sections.Begin(section),
        sections.End(section) - sections.Begin(section)));
    }
    return {};
  }

  // Writes the tuples of the leaf positions [first, first + count), which are in one bucket.
  Status WriteTuples(
    const BucketFile& entries, std::size_t bucket, std::uint64_t first, std::size_t count)
  {
    const std::size_t bytes = this->Vertices.kept.tupleBytes;
    std::vector<std::byte> sorted(count * bytes);
    KDSTREAM_TRY(entries.ForEachBlock(bucket,
      [&](std::span<const std::byte> tuples) -> Status
      {
        for (std::size_t at = 0; at < tuples.size(); at += sizeof(VertexId) + bytes)
        {
          std::memcpy(sorted.data() + (RankAt(tuples, at) - first) * bytes,
            tuples.data() + at + sizeof(VertexId), bytes);
        }
        return {};
      }));
    return this->Mesh.pointTuples.Write(first * bytes, sorted);
  }

  static VertexId RankAt(std::span<const std::byte> entries, std::size_t at)
  {
    VertexId rank = 0;
    std::memcpy(&rank, entries.data() + at, sizeof(rank));
    return rank;
  }

  // Reads the tuples of at most `count` vertices, beginning with vertex `first`. Each tuple follows
  // the leaf position of its vertex.
  Status ReadTuples(std::uint64_t first, std::size_t count, RankLists<std::byte>& out) const
  {
    const VertexFiles& kept = this->Vertices.kept;
    count = std::min<std::size_t>(count, kept.count - first);
    std::vector<VertexId> ranks(count);
    std::iota(ranks.begin(), ranks.end(), static_cast<VertexId>(first));
    std::vector<std::byte> tuples(count * kept.tupleBytes);
    KDSTREAM_TRY(this->Ranks.Look(ranks));
    KDSTREAM_TRY(kept.tuples.Read(first * kept.tupleBytes, tuples));
    for (std::size_t i = 0; i < count; ++i)
    {
      std::vector<std::byte>& list = out[this->OwnerOfRank(ranks[i])];
      const auto rank = std::as_bytes(std::span(ranks).subspan(i, 1));
      const auto tuple = std::span(tuples).subspan(i * kept.tupleBytes, kept.tupleBytes);
      list.insert(list.end(), rank.begin(), rank.end());
      list.insert(list.end(), tuple.begin(), tuple.end());
    }
    return {};
  }

  Status CountTriangles()
  {
    const Result<std::vector<std::uint64_t>> counts = this->Group.Gather(this->Share.triangleCount);
    KDSTREAM_TRY(counts);
    std::uint64_t all = 0, most = 0;
    for (std::size_t rank = 0; rank < counts->size(); ++rank)
    {
      this->FirstNumber += rank < this->Group.Rank() ? (*counts)[rank] : 0;
      all += (*counts)[rank];
      most = std::max(most, (*counts)[rank]);
    }
    if (all >= noVertex)
    {
      return Error{ ErrorCode::LimitExceeded,
        std::to_string(all) + " triangles; the maximum is 4294967294" };
    }
    this->Mesh.triangleCount = static_cast<std::uint32_t>(all);
    const std::uint64_t bytes = bytesOfTriangle + bytesOfQuestion * this->Group.Count() +
                                4 * std::uint64_t{ this->Share.cellTupleBytes };
    this->Batch = static_cast<std::size_t>(
      std::clamp<std::uint64_t>(this->Memory / 4 / bytes, 1, trianglesAtOnce));
    this->Batches = static_cast<std::size_t>(RoundsOf(most, this->Batch));
    return {};
  }

  Status ScatterTriangles()
  {
    Result<RecordBuckets<NumberedTriangle>> buckets = RecordBuckets<NumberedTriangle>::Create(
      this->Folder, "triangles of cells", this->Mesh.BlockCount(), 0, this->Memory / 4);
    KDSTREAM_TRY(buckets);
    if (this->Share.cellTupleBytes > 0)
    {
      Result<SpillFile> file = this->Folder.CreateFile("attributes of triangles", 0);
      KDSTREAM_TRY(file);
      this->Mesh.cellTuples = std::move(*file);
    }
    for (std::size_t i = 0; i < this->Batches; ++i)
    {
      KDSTREAM_TRY(this->ScatterBatch(i, *buckets));
      KDSTREAM_TRY(this->Exec.Report("faces", double(i + 1) / double(this->Batches)));
    }
    KDSTREAM_TRY(buckets->Finish());
    this->Mesh.triangles.emplace(std::move(*buckets));
    return {};
  }

  Status ScatterBatch(std::size_t index, RecordBuckets<NumberedTriangle>& buckets)
  {
    const std::size_t bytes = this->Share.cellTupleBytes;
    const std::size_t first = std::min<std::size_t>(index * this->Batch, this->Share.triangleCount);
    std::vector<NumberedTriangle> triangles(
      std::min<std::size_t>(this->Batch, this->Share.triangleCount - first));
    std::vector<std::byte> tuples(triangles.size() * bytes);
    KDSTREAM_TRY(ReadRecords<NumberedTriangle>(
      this->Share.triangles, first, std::span<NumberedTriangle>(triangles)));
    if (bytes > 0)
    {
      KDSTREAM_TRY(this->Share.cellTuples.Read(first * bytes, tuples));
    }
    KDSTREAM_TRY(this->RankCorners(triangles));
    RankLists<NumberedTriangle> out(this->Group.Count());
    RankLists<std::byte> outTuples(this->Group.Count());
    this->ListByOwner(triangles, tuples, out, outTuples);
    const Result<RankLists<NumberedTriangle>> in = this->Group.Exchange(out);
    KDSTREAM_TRY(in);
    const Result<RankLists<std::byte>> inTuples =
      bytes > 0 ? this->Group.Exchange(outTuples) : RankLists<std::byte>(this->Group.Count());
    KDSTREAM_TRY(inTuples);
    for (std::size_t rank = 0; rank < this->Group.Count(); ++rank)
    {
      KDSTREAM_TRY(this->AddTriangles((*in)[rank], (*inTuples)[rank], buckets));
    }
    return {};
  }

  // Numbers the triangles over all ranks, and adds each to the lists of the ranks whose blocks it
  // touches.
  void ListByOwner(std::span<NumberedTriangle> triangles, std::span<const std::byte> tuples,
    RankLists<NumberedTriangle>& out, RankLists<std::byte>& outTuples) const
  {
    const std::size_t bytes = this->Share.cellTupleBytes;
    for (std::size_t i = 0; i < triangles.size(); ++i)
    {
      NumberedTriangle& t = triangles[i];
      t.number += static_cast<std::uint32_t>(this->FirstNumber);
      std::array<std::size_t, 3> owners;
      std::transform(t.corners.begin(), t.corners.end(), owners.begin(),
        [&](VertexId corner) { return this->OwnerOfRank(corner); });
      std::sort(owners.begin(), owners.end());
      const auto end = std::unique(owners.begin(), owners.end());
      for (auto owner = owners.begin(); owner != end; ++owner)
      {
        out[*owner].push_back(t);
        const auto tuple = tuples.begin() + std::ptrdiff_t(i * bytes);
        outTuples[*owner].insert(outTuples[*owner].end(), tuple, tuple + std::ptrdiff_t(bytes));
      }
    }
  }

  Status RankCorners(std::vector<NumberedTriangle>& triangles)
  {
    std::vector<VertexId> corners;
    corners.reserve(3 * triangles.size());
    for (const NumberedTriangle& t : triangles)
    {
      corners.insert(corners.end(), t.corners.begin(), t.corners.end());
    }
    const Result<std::vector<VertexId>> ranks = LookUpEntries(this->Group, this->Vertices.readBegin,
      this->Renumbered ? this->RanksOfRead : this->Ranks, corners);
    KDSTREAM_TRY(ranks);
    for (std::size_t i = 0; i < triangles.size(); ++i)
    {
      std::copy_n(ranks->begin() + std::ptrdiff_t(3 * i), 3, triangles[i].corners.begin());
    }
    return {};
  }

  // Adds received triangles, which touch blocks of this rank.
  Status AddTriangles(std::span<const NumberedTriangle> triangles,
    std::span<const std::byte> tuples, RecordBuckets<NumberedTriangle>& buckets)
  {
    const BlockRange here = this->Group.Here(this->Mesh.blockDepth);
    for (const NumberedTriangle& t : triangles)
    {
      std::array<std::size_t, 3> blocks;
      std::transform(t.corners.begin(), t.corners.end(), blocks.begin(), this->BlockOf);
      for (std::size_t k = 0; k < 3; ++k)
      {
        const std::size_t block = blocks[k];
        if (block < here.begin || block >= here.end)
        {
          this->Foreign.Add(t.corners[k]);
        }
        else if (std::find(blocks.begin(), blocks.begin() + std::ptrdiff_t(k), block) ==
                 blocks.begin() + std::ptrdiff_t(k))
        {
          KDSTREAM_TRY(buckets.Add(block, t));
        }
      }
    }
    const std::size_t bytes = this->Share.cellTupleBytes;
    if (bytes == 0)
    {
      return {};
    }
    std::vector<VertexId> numbers;
    std::transform(triangles.begin(), triangles.end(), std::back_inserter(numbers),
      [](const NumberedTriangle& t) { return t.number; });
    return WriteElementsAt(this->Mesh.cellTuples, bytes, numbers, tuples);
  }

  Status FetchForeign()
  {
    this->Mesh.foreign = this->Foreign.Take();
    const std::vector<VertexId> begins = this->Mesh.BlockBegins();
    KDSTREAM_TRY(this->Group.Fetch(this->Mesh.records,
      this->Mesh.floats ? sizeof(PointRecord<float>) : sizeof(PointRecord<double>), begins,
      this->Mesh.blockDepth, this->Mesh.foreign));
    const std::size_t bytes = this->Vertices.kept.tupleBytes;
    return bytes == 0 ? Status{}
                      : this->Group.Fetch(this->Mesh.pointTuples, bytes, begins,
                          this->Mesh.blockDepth, this->Mesh.foreign);
  }

  MpiGroup& Group;
  SpillFolder& Folder;
  const SpilledMesh& Share;
  DistributedVertices& Vertices;
  std::uint64_t Memory;
  MeshBlocks& Mesh;
  const Execution& Exec;
  const CellOfRank BlockOf;
  const bool Renumbered; // whether vertices have other numbers than in the file
  MapSections Sections;  // of the vertices that are numbered here
  std::optional<RecordBuckets<Place>> Places;
  NumberTable Ranks; // leaf positions of these vertices
  // Leaf positions of the vertices that this rank read; empty unless renumbered.
  NumberTable RanksOfRead;
  NumberSet<VertexId> Foreign;         // leaf positions on other processes
  std::size_t Batch = trianglesAtOnce; // triangles in a batch
  std::uint64_t FirstNumber = 0;       // number of this rank's first triangle
  std::size_t Batches = 0;
};

}

Status ScatterFaces(MpiGroup& group, SpillFolder& folder, const SpilledMesh& share,
  DistributedVertices& vertices, std::uint64_t memory, MeshBlocks& mesh, const Execution& execution)
{
  return FaceScatterer(group, folder, share, vertices, memory, mesh, execution).Scatter();
}

}
