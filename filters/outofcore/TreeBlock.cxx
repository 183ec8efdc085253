#include "filters/outofcore/TreeBlock.h"

#include "filters/core/PointRecord.h"

#include <algorithm>

namespace kdstream
{
namespace
{

// A vertex on its way into a block.
template <class Scalar>
struct RankedRecord
{
  PointRecord<Scalar> record;
  VertexId rank;
};

template <class Scalar>
class BlockLoader
{
public:
  BlockLoader(const SpillFile& records, std::uint32_t vertices, unsigned depth, std::size_t cell)
    : Records(records)
    , Range(RangeOfCell(vertices, depth, cell))
  {
    this->Block.cell = cell;
    this->Block.firstRank = static_cast<VertexId>(this->Range.begin);
  }

  Result<TreeBlock> Load(const RecordBuckets<NumberedTriangle>& triangles)
  {
    Status status = this->LoadTriangles(triangles);
    if (status)
    {
      status = this->LoadOwn();
    }
    if (status)
    {
      status = this->LoadGhosts();
    }
    if (!status)
    {
      return status.GetError();
    }
    this->NumberVertices();
    return std::move(this->Block);
  }

private:
  bool IsOwn(VertexId rank) const
  {
    return rank >= this->Range.begin && rank - this->Range.begin < this->Range.size;
  }

  Status LoadTriangles(const RecordBuckets<NumberedTriangle>& triangles)
  {
    this->Triangles.reserve(static_cast<std::size_t>(triangles.Size(this->Block.cell)));
    const Status status = triangles.ForEach(this->Block.cell,
      [&](const NumberedTriangle& t) -> Status
      {
        this->Triangles.push_back(t);
        return {};
      });
    std::sort(this->Triangles.begin(), this->Triangles.end(),
      [](const NumberedTriangle& a, const NumberedTriangle& b) { return a.number < b.number; });
    return status;
  }

  Status LoadOwn()
  {
    std::vector<PointRecord<Scalar>> own(static_cast<std::size_t>(this->Range.size));
    const Status status = ReadRecords<PointRecord<Scalar>>(
      this->Records, this->Range.begin, std::span<PointRecord<Scalar>>(own));
    for (std::size_t i = 0; i < own.size(); ++i)
    {
      this->Vertices.push_back({ own[i], static_cast<VertexId>(this->Range.begin + i) });
    }
    return status;
  }

  Status LoadGhosts()
  {
    std::vector<VertexId> ghosts;
    for (const NumberedTriangle& t : this->Triangles)
    {
      std::copy_if(t.corners.begin(), t.corners.end(), std::back_inserter(ghosts),
        [&](VertexId rank) { return !this->IsOwn(rank); });
    }
    std::sort(ghosts.begin(), ghosts.end());
    ghosts.erase(std::unique(ghosts.begin(), ghosts.end()), ghosts.end());
    constexpr std::uint64_t pageRecords = (std::uint64_t{ 1 } << 16) / sizeof(PointRecord<Scalar>);
    const std::uint64_t count = this->Records.Size() / sizeof(PointRecord<Scalar>);
    std::vector<PointRecord<Scalar>> page;
    std::uint64_t pageBegin = 0;
    for (const VertexId rank : ghosts)
    {
      if (page.empty() || rank >= pageBegin + page.size())
      {
        pageBegin = rank / pageRecords * pageRecords;
        page.resize(static_cast<std::size_t>(std::min(pageRecords, count - pageBegin)));
        if (Status status = ReadRecords<PointRecord<Scalar>>(
              this->Records, pageBegin, std::span<PointRecord<Scalar>>(page));
            !status)
        {
          return status;
        }
      }
      this->Vertices.push_back({ page[rank - pageBegin], rank });
    }
    return {};
  }

  // By ascending id; triangles follow.
  void NumberVertices()
  {
    TreeBlock& block = this->Block;
    std::sort(this->Vertices.begin(), this->Vertices.end(),
      [](const RankedRecord<Scalar>& a, const RankedRecord<Scalar>& b)
      { return a.record.id < b.record.id; });
    block.order.resize(static_cast<std::size_t>(this->Range.size));
    std::vector<std::pair<VertexId, VertexId>> ghosts; // rank, number in the block
    for (const RankedRecord<Scalar>& vertex : this->Vertices)
    {
      const auto number = static_cast<VertexId>(block.ids.size());
      block.ids.push_back(vertex.record.id);
      block.ranks.push_back(vertex.rank);
      block.mesh.points.push_back({ vertex.record.p[0], vertex.record.p[1], vertex.record.p[2] });
      if (this->IsOwn(vertex.rank))
      {
        block.order[vertex.rank - block.firstRank] = number;
      }
      else
      {
        ghosts.emplace_back(vertex.rank, number);
      }
    }
    std::sort(ghosts.begin(), ghosts.end());
    const auto numberOf = [&](VertexId rank)
    {
      return this->IsOwn(rank) ? block.order[rank - block.firstRank]
                               : std::lower_bound(ghosts.begin(), ghosts.end(),
                                   std::pair<VertexId, VertexId>(rank, 0))
                                   ->second;
    };
    for (const NumberedTriangle& t : this->Triangles)
    {
      block.numbers.push_back(t.number);
      block.mesh.triangles.push_back(
        { numberOf(t.corners[0]), numberOf(t.corners[1]), numberOf(t.corners[2]) });
    }
  }

  const SpillFile& Records;
  CellRange Range;
  TreeBlock Block;
  std::vector<NumberedTriangle> Triangles; // corners are ranks
  std::vector<RankedRecord<Scalar>> Vertices;
};

}

template <class Scalar>
Result<TreeBlock> LoadBlock(const SpillFile& records, std::uint32_t vertices,
  const RecordBuckets<NumberedTriangle>& triangles, unsigned depth, std::size_t cell)
{
  return BlockLoader<Scalar>(records, vertices, depth, cell).Load(triangles);
}

template Result<TreeBlock> LoadBlock<float>(
  const SpillFile&, std::uint32_t, const RecordBuckets<NumberedTriangle>&, unsigned, std::size_t);
template Result<TreeBlock> LoadBlock<double>(
  const SpillFile&, std::uint32_t, const RecordBuckets<NumberedTriangle>&, unsigned, std::size_t);

}
