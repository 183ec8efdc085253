// SPDX-License-Identifier: BSD-3-Clause
#include "filters/Parallel/DistributedTree.h"

#include "filters/core/Extent.h"
#include "filters/core/TakeResult.h"
#include "filters/core/tree/OrderKey.h"
#include "filters/core/tree/PointRecord.h"
#include "filters/core/tree/RadixMedians.h"
#include "filters/core/tree/RecordTree.h"
#include "filters/outofcore/files/BucketFile.h"
#include "filters/outofcore/files/RecordFile.h"

#include <algorithm>

namespace kdstream
{
namespace
{

template <class Scalar>
class DistributedTreeBuilder
{
public:
  using Record = PointRecord<Scalar>;

  DistributedTreeBuilder(MpiGroup& group, SpillFolder& folder, std::uint64_t memory,
    MeshBlocks& mesh, const Execution& execution)
    : Group(group)
    , Folder(folder)
    , Memory(memory)
    , Mesh(mesh)
    , Exec(execution)
    , Boxes(std::size_t{ 2 } << mesh.depths.partition)
    , SplitDepth(group.Shares().DividedDepth())
  {
    // Continues until a node fits in the memory of one rank.
    while (this->SplitDepth < mesh.depths.partition &&
           (mesh.vertexCount >> this->SplitDepth) > memory / 2 / sizeof(Record))
    {
      ++this->SplitDepth;
    }
  }

  Result<std::vector<Box>> Build(const VertexFiles& vertices, VertexId firstId)
  {
    Box box;
    KDSTREAM_TRY(this->WriteRecordsOf(vertices, firstId, box));
    KDSTREAM_TRY(this->Group.JoinBoxes(std::span(&box, 1)));
    KDSTREAM_TRY(CheckExtent(box));
    for (unsigned depth = 0; depth < this->SplitDepth; ++depth)
    {
      KDSTREAM_TRY(this->Split(depth));
    }
    const Result<RecordBuckets<Record>> own = this->TakeOwn();
    KDSTREAM_TRY(own);
    this->Records = {};
    this->NodeOf = {};
    KDSTREAM_TRY(this->BuildBelow(*own));
    KDSTREAM_TRY(this->Group.JoinBoxes(this->Boxes));
    this->Mesh.box = this->Boxes[1];
    return std::move(this->Boxes);
  }

private:
  struct NodeRecord
  {
    Record record;
    std::uint32_t node;
  };
  static constexpr std::size_t recordsAtOnce = spillBlockBytes / sizeof(Record);

  std::size_t Nodes(unsigned depth) const { return std::size_t{ 1 } << depth; }

  // Writes the records of the vertices, and adds the vertices to `box`.
  Status WriteRecordsOf(const VertexFiles& vertices, VertexId firstId, Box& box)
  {
    this->Count = vertices.count;
    KDSTREAM_TRY(Take(this->Folder.CreateFile("vertices", 0), this->Records));
    KDSTREAM_TRY(Take(this->Folder.CreateFile("nodes of vertices", 0), this->NodeOf));
    RecordWriter<Record> writer(this->Records);
    RecordWriter<std::uint32_t> nodes(this->NodeOf);
    KDSTREAM_TRY(ForEachBlockOf<Vec3>(vertices.points, 0, this->Count,
      [&](std::span<const Vec3> points)
      {
        for (const Vec3& p : points)
        {
          box.Add(p);
          writer.Append({ { Scalar(p[0]), Scalar(p[1]), Scalar(p[2]) }, firstId++ });
          nodes.Append(0);
        }
      }));
    KDSTREAM_TRY(writer.Finish());
    return nodes.Finish();
  }

  // Calls visit(records, nodes, first) -> Status for blocks of this rank's records; `first` is the
  // number of the first record.
  template <class Visit>
  Status ForEachBlock(const Visit& visit) const
  {
    RecordReader<Record> records(this->Records, 0, this->Count, recordsAtOnce * sizeof(Record));
    RecordReader<std::uint32_t> nodes(
      this->NodeOf, 0, this->Count, recordsAtOnce * sizeof(std::uint32_t));
    for (std::uint64_t first = 0; first < this->Count;)
    {
      const Result<std::span<const Record>> some = records.Next();
      KDSTREAM_TRY(some);
      const Result<std::span<const std::uint32_t>> theirs = nodes.Next();
      KDSTREAM_TRY(theirs);
      KDSTREAM_TRY(visit(*some, *theirs, first));
      first += some->size();
    }
    return {};
  }

  // Determines in which half of its node each vertex is.
  Status Split(unsigned depth)
  {
    const std::size_t nodes = this->Nodes(depth);
    const std::span<Box> boxes = std::span(this->Boxes).subspan(nodes, nodes);
    KDSTREAM_TRY(this->ForEachBlock(
      [&](std::span<const Record> records, std::span<const std::uint32_t> nodeOf,
        std::uint64_t) -> Status
      {
        for (std::size_t i = 0; i < records.size(); ++i)
        {
          const std::array<Scalar, 3>& p = records[i].p;
          boxes[nodeOf[i]].Add(Vec3{ p[0], p[1], p[2] });
        }
        return {};
      }));
    KDSTREAM_TRY(this->Group.JoinBoxes(boxes));
    std::vector<std::size_t> axes;
    std::transform(boxes.begin(), boxes.end(), std::back_inserter(axes), LongestAxis);
    const Result<std::vector<OrderKey>> medians = this->FindMedians(depth, axes);
    KDSTREAM_TRY(medians);
    std::vector<std::uint32_t> halves;
    KDSTREAM_TRY(this->ForEachBlock(
      [&](
        std::span<const Record> records, std::span<const std::uint32_t> nodeOf, std::uint64_t first)
      {
        halves.clear();
        for (std::size_t i = 0; i < records.size(); ++i)
        {
          const std::uint32_t node = nodeOf[i];
          const bool lower = KeyOf(records[i], axes[node]) < (*medians)[node];
          halves.push_back(2 * node + (lower ? 0 : 1));
        }
        return WriteRecords<std::uint32_t>(
          this->NodeOf, first, std::span<const std::uint32_t>(halves));
      }));
    return this->Exec.Report("tree", 0.5 * (depth + 1) / this->SplitDepth);
  }

  static OrderKey KeyOf(const Record& record, std::size_t axis)
  {
    return { OrderedBits(record.p[axis]), record.id };
  }

  Result<std::vector<OrderKey>> FindMedians(unsigned depth, const std::vector<std::size_t>& axes)
  {
    return RadixMedians::Find(
      this->Mesh.vertexCount, depth,
      [&](const auto& visit)
      {
        return this->ForEachBlock(
          [&](std::span<const Record> records, std::span<const std::uint32_t> nodeOf,
            std::uint64_t) -> Status
          {
            for (std::size_t i = 0; i < records.size(); ++i)
            {
              visit(nodeOf[i], KeyOf(records[i], axes[nodeOf[i]]));
            }
            return {};
          });
      },
      [&](std::span<std::uint64_t> bins) { return this->Group.Sum(bins); });
  }

  // Sends every rank the records of its nodes.
  Result<RecordBuckets<Record>> TakeOwn()
  {
    const BlockRange here = this->Group.Here(this->SplitDepth);
    Result<RecordBuckets<Record>> own = RecordBuckets<Record>::Create(this->Folder,
      "vertices of nodes", std::max<std::size_t>(1, here.end - here.begin), 0, this->Memory / 4);
    KDSTREAM_TRY(own);
    constexpr std::size_t ofRound = ElementsOfRound(sizeof(NodeRecord));
    const auto make = [&](std::uint64_t round, RankLists<NodeRecord>& out) -> Status
    {
      const std::uint64_t from = round * ofRound;
      std::vector<Record> records(std::min<std::uint64_t>(ofRound, this->Count - from));
      std::vector<std::uint32_t> nodes(records.size());
      KDSTREAM_TRY(ReadRecords<Record>(this->Records, from, std::span<Record>(records)));
      KDSTREAM_TRY(ReadRecords<std::uint32_t>(this->NodeOf, from, std::span<std::uint32_t>(nodes)));
      for (std::size_t i = 0; i < records.size(); ++i)
      {
        out[this->Group.OwnerOf(nodes[i], this->SplitDepth)].push_back({ records[i], nodes[i] });
      }
      return {};
    };
    const auto take = [&](std::size_t, std::span<const NodeRecord> records) -> Status
    {
      for (const NodeRecord& entry : records)
      {
        KDSTREAM_TRY(own->Add(entry.node - here.begin, entry.record));
      }
      return {};
    };
    KDSTREAM_TRY(this->Group.template ExchangeInRounds<NodeRecord>(
      RoundsOf(this->Count, ofRound), make, take));
    KDSTREAM_TRY(own->Finish());
    return own;
  }

  // own: the records of this rank's nodes, with a bucket for each node.
  Status BuildBelow(const RecordBuckets<Record>& own)
  {
    KDSTREAM_TRY(Take(this->Folder.CreateFile("vertices", 0), this->Mesh.records));
    const BlockRange here = this->Group.Here(this->SplitDepth);
    Execution quiet = this->Exec;
    quiet.progress = [this](std::string_view, double)
    { return bool(this->Exec.Report("tree", 0.5)); };
    for (std::size_t node = here.begin; node < here.end; ++node)
    {
      const CellRange range = RangeOfCell(this->Mesh.vertexCount, this->SplitDepth, node);
      Result<std::vector<Record>> records = own.ReadAll(node - here.begin);
      KDSTREAM_TRY(records);
      KDSTREAM_TRY(BuildRecordTree<Scalar>(
        *records, this->SplitDepth, node, this->Mesh.depths, this->Boxes, quiet));
      KDSTREAM_TRY(
        WriteRecords<Record>(this->Mesh.records, range.begin, std::span<const Record>(*records)));
    }
    return {};
  }

  MpiGroup& Group;
  SpillFolder& Folder;
  const std::uint64_t Memory;
  MeshBlocks& Mesh;
  const Execution& Exec;
  std::vector<Box> Boxes;
  unsigned SplitDepth;
  std::uint32_t Count = 0; // vertices that are numbered on this rank
  SpillFile Records;       // of these vertices
  SpillFile NodeOf;        // std::uint32_t: node of each, at the depth being split
};

}

unsigned DepthOfGroup(std::size_t ranks, const TreeDepths& depths)
{
  unsigned depth = 0;
  while (std::size_t{ 1 } << depth < ranks)
  {
    ++depth;
  }
  const bool even = std::size_t{ 1 } << depth == ranks;
  return std::min(depth + (even ? 0 : 2), depths.partition);
}

Result<std::vector<Box>> BuildTreeCollectively(MpiGroup& group, SpillFolder& folder,
  const VertexFiles& vertices, VertexId firstId, std::uint64_t memory, MeshBlocks& mesh,
  const Execution& execution)
{
  return mesh.floats ? DistributedTreeBuilder<float>(group, folder, memory, mesh, execution)
                         .Build(vertices, firstId)
                     : DistributedTreeBuilder<double>(group, folder, memory, mesh, execution)
                         .Build(vertices, firstId);
}

}
