// SPDX-License-Identifier: BSD-3-Clause
#include "filters/outofcore/mesh/TreeBlock.h"

#include "filters/core/RadixSort.h"
#include "filters/core/tree/PointRecord.h"

#include <algorithm>

namespace kdstream
{
namespace
{

template <class Scalar>
class BlockLoader
{
public:
  using Record = PointRecord<Scalar>;

  BlockLoader(const SpillFile& records, const CellRange& range, std::size_t cell)
    : Records(records)
    , Range(range)
  {
    this->Block.cell = cell;
    this->Block.firstRank = static_cast<VertexId>(this->Range.begin);
  }

  Result<TreeBlock> Load(const RecordBuckets<NumberedTriangle>& triangles, BlockOrder order)
  {
    KDSTREAM_TRY(this->LoadTriangles(triangles));
    this->FindGhosts();
    this->Vertices.resize(static_cast<std::size_t>(this->Range.size) + this->Ghosts.size());
    const std::span<Record> vertices(this->Vertices);
    const auto own = static_cast<std::size_t>(this->Range.size);
    KDSTREAM_TRY(ReadRecords<Record>(this->Records, this->Range.begin, vertices.first(own)));
    KDSTREAM_TRY(this->LoadGhosts(vertices.subspan(own)));
    this->NumberTriangles(this->NumberVertices(order));
    return std::move(this->Block);
  }

private:
  bool IsOwn(VertexId rank) const
  {
    return rank >= this->Range.begin && rank - this->Range.begin < this->Range.size;
  }

  Status LoadTriangles(const RecordBuckets<NumberedTriangle>& triangles)
  {
    Result<std::vector<NumberedTriangle>> read = triangles.ReadAll(this->Block.cell);
    KDSTREAM_TRY(read);
    this->Triangles = std::move(*read);
    const auto earlier = [](const NumberedTriangle& a, const NumberedTriangle& b)
    { return a.number < b.number; };
    if (!std::is_sorted(this->Triangles.begin(), this->Triangles.end(), earlier))
    {
      std::sort(this->Triangles.begin(), this->Triangles.end(), earlier);
    }
    return {};
  }

  void FindGhosts()
  {
    for (const NumberedTriangle& t : this->Triangles)
    {
      std::copy_if(t.corners.begin(), t.corners.end(), std::back_inserter(this->Ghosts),
        [&](VertexId rank) { return !this->IsOwn(rank); });
    }
    std::sort(this->Ghosts.begin(), this->Ghosts.end());
    this->Ghosts.erase(std::unique(this->Ghosts.begin(), this->Ghosts.end()), this->Ghosts.end());
  }

  Status LoadGhosts(std::span<Record> vertices) const
  {
    constexpr std::uint64_t pageRecords = (std::uint64_t{ 1 } << 14) / sizeof(Record);
    const std::uint64_t count = this->Records.Size() / sizeof(Record);
    std::vector<Record> page;
    std::uint64_t pageBegin = 0;
    for (std::size_t i = 0; i < vertices.size(); ++i)
    {
      const VertexId rank = this->Ghosts[i];
      if (page.empty() || rank >= pageBegin + page.size())
      {
        pageBegin = rank / pageRecords * pageRecords;
        page.resize(static_cast<std::size_t>(std::min(pageRecords, count - pageBegin)));
        KDSTREAM_TRY(ReadRecords<Record>(this->Records, pageBegin, std::span<Record>(page)));
      }
      vertices[i] = page[rank - pageBegin];
    }
    return {};
  }

  // Returns for each loaded vertex its number in the block.
  std::vector<VertexId> NumberVertices(BlockOrder order)
  {
    std::vector<std::uint64_t> entries(this->Vertices.size()); // id, index
    for (std::size_t i = 0; i < entries.size(); ++i)
    {
      entries[i] = std::uint64_t{ this->Vertices[i].id } << 32 | i;
    }
    if (order == BlockOrder::ById)
    {
      SortByUpperHalf(entries);
    }
    TreeBlock& block = this->Block;
    const auto own = static_cast<std::size_t>(this->Range.size);
    std::vector<VertexId> numberOf(entries.size());
    block.ids.reserve(entries.size());
    block.ranks.reserve(entries.size());
    block.mesh.points.reserve(entries.size());
    for (const std::uint64_t entry : entries)
    {
      const auto i = static_cast<VertexId>(entry);
      const Record& record = this->Vertices[i];
      numberOf[i] = static_cast<VertexId>(block.ids.size());
      block.ids.push_back(record.id);
      block.ranks.push_back(i < own ? block.firstRank + i : this->Ghosts[i - own]);
      block.mesh.points.push_back({ record.p[0], record.p[1], record.p[2] });
    }
    block.order.assign(numberOf.begin(), numberOf.begin() + static_cast<std::ptrdiff_t>(own));
    return numberOf;
  }

  void NumberTriangles(std::span<const VertexId> numbers)
  {
    const std::span<const VertexId> ofGhosts =
      numbers.subspan(static_cast<std::size_t>(this->Range.size));
    const auto numberOf = [&](VertexId rank)
    {
      return this->IsOwn(rank)
               ? numbers[rank - this->Block.firstRank]
               : ofGhosts[static_cast<std::size_t>(
                   std::lower_bound(this->Ghosts.begin(), this->Ghosts.end(), rank) -
                   this->Ghosts.begin())];
    };
    this->Block.numbers.reserve(this->Triangles.size());
    this->Block.mesh.triangles.reserve(this->Triangles.size());
    for (const NumberedTriangle& t : this->Triangles)
    {
      this->Block.numbers.push_back(t.number);
      this->Block.mesh.triangles.push_back(
        { numberOf(t.corners[0]), numberOf(t.corners[1]), numberOf(t.corners[2]) });
    }
  }

  const SpillFile& Records;
  CellRange Range;
  TreeBlock Block;
  std::vector<NumberedTriangle> Triangles; // corners are ranks
  std::vector<VertexId> Ghosts;            // ranks, ascending
  std::vector<Record> Vertices;            // by rank, the own ones first
};

}

template <class Scalar>
Result<TreeBlock> LoadBlock(const SpillFile& records, const CellRange& range,
  const RecordBuckets<NumberedTriangle>& triangles, std::size_t cell, BlockOrder order)
{
  return BlockLoader<Scalar>(records, range, cell).Load(triangles, order);
}

template Result<TreeBlock> LoadBlock<float>(const SpillFile&, const CellRange&,
  const RecordBuckets<NumberedTriangle>&, std::size_t, BlockOrder);
template Result<TreeBlock> LoadBlock<double>(const SpillFile&, const CellRange&,
  const RecordBuckets<NumberedTriangle>&, std::size_t, BlockOrder);

}
