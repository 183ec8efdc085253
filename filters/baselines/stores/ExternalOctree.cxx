// SPDX-License-Identifier: BSD-3-Clause
// Octree clustering out of core: see ExternalOctree.h. As in the k-d tree, every cell is stored at
// its place in the order of the leaves, in one of two files of the same size, and moves between
// them. Every pass keeps the order of the records of a cell, so ids stay ascending.
#include "filters/baselines/stores/ExternalOctree.h"

#include "filters/baselines/OctreeKey.h"
#include "filters/outofcore/files/BatchPass.h"
#include "filters/outofcore/files/MemoryPlan.h"
#include "filters/outofcore/files/ReturnFreeMemory.h"
#include "filters/outofcore/tree/PointSurvey.h"

#include <algorithm>
#include <array>
#include <functional>
#include <numeric>
#include <string>

namespace kdstream
{
namespace
{

// A cell of the octree: the records [begin, begin + size) of one of the files.
struct OctreeCell
{
  unsigned depth = 0;
  std::uint64_t begin = 0, size = 0;
  bool isLeaf = false;
};

// Consecutive cells.
struct Group
{
  std::vector<OctreeCell> cells;
  std::uint64_t begin = 0, size = 0;
  std::uint32_t firstCell = 0; // number in CountedCells of its first cell
};

// The leaves and the deepest counted cells below one cell, numbered in Morton order.
struct CountedCells
{
  unsigned deepest = 0;   // the depth at which vertices were counted
  std::uint64_t mask = 0; // the bits of a key that give the index at that depth
  std::vector<std::uint32_t>
    table; // of each place: its count at first, then the number of its cell
  std::vector<std::uint32_t> groupOf; // for each cell

  std::size_t PlaceOf(std::uint64_t key) const
  {
    return static_cast<std::size_t>(key >> 3 * (octreeDeepest - this->deepest) & this->mask);
  }
  std::uint32_t CellOf(std::uint64_t key) const { return this->table[this->PlaceOf(key)]; }
};

template <class Scalar>
class ExternalOctreeBuilder
{
public:
  using Record = PointRecord<Scalar>;

  ExternalOctreeBuilder(SpillFolder& folder, SpillFile& points, ExternalOctree& octree,
    const ExternalOctreeOptions& options, const Execution& execution)
    : Folder(folder)
    , Points(points)
    , Octree(octree)
    , Options(options)
    , Plan(options.memory, sizeof(Record))
    , Run(execution)
    , Count(points.Size() / sizeof(Record))
    // A group in memory takes its records, the same records in order, and their keys twice; the
    // leaves may take the rest.
    , GroupRecords(options.memory / 8 * 7 / (2 * sizeof(Record) + 2 * sizeof(Item)))
  {
  }

  Status Build()
  {
    CellStatistics all;
    KDSTREAM_TRY(SurveyPoints<Scalar>(this->Points, this->Plan.shape, this->Run, all));
    KDSTREAM_TRY(this->CreateWorkFile(this->Work));
    this->Cube = OctreeCube(all.box);
    const bool isLeaf = this->Count <= this->Options.verticesPerPartition;
    KDSTREAM_TRY(this->Descend({ 0, 0, this->Count, isLeaf }, this->Points));
    this->Octree.clusterBegin.push_back(this->Count);
    this->Octree.records = std::move(this->Work);
    if (!this->Options.keepPoints)
    {
      this->Points.Remove();
    }
    return {};
  }

private:
  // The key of a record, and the record's position.
  struct Item
  {
    std::uint64_t key;
    std::uint32_t position; // in the group
  };

  Status CreateWorkFile(SpillFile& file)
  {
    Result<SpillFile> created =
      this->Folder.CreateFile("points of the octree", this->Count * sizeof(Record));
    KDSTREAM_TRY(created);
    file = std::move(*created);
    return {};
  }

  std::uint64_t KeyOf(const Record& record) const
  {
    return this->Cube.KeyOf({ double(record.p[0]), double(record.p[1]), double(record.p[2]) });
  }

  Status Report() const
  {
    return this->Run.Report("octree", double(this->Done) / double(this->Count));
  }

  // Makes all leaves of a cell.
  Status Descend(const OctreeCell& cell, SpillFile& file)
  {
    if (cell.isLeaf)
    {
      return this->CopyLeaf(cell, file);
    }
    if (cell.size <= this->GroupRecords)
    {
      return this->FinishInMemory({ { cell }, cell.begin, cell.size, 0 }, {}, file);
    }
    SpillFile* to = &this->Work;
    if (&file == to)
    {
      to = this->Options.keepPoints ? &this->SecondWork : &this->Points;
      if (!to->IsOpen())
      {
        KDSTREAM_TRY(this->CreateWorkFile(*to));
      }
    }
    CountedCells counted;
    std::vector<Group> groups;
    KDSTREAM_TRY(this->Distribute(cell, file, *to, counted, groups));
    for (const Group& group : groups)
    {
      const bool fits = group.size <= this->GroupRecords;
      KDSTREAM_TRY(
        fits ? this->FinishInMemory(group, counted, *to) : this->Descend(group.cells.front(), *to));
    }
    return {};
  }

  // Copies a leaf that may not fit in memory.
  Status CopyLeaf(const OctreeCell& leaf, SpillFile& file)
  {
    this->AddLeaf(leaf.begin, leaf.depth);
    if (&file == &this->Work)
    {
      this->Done += leaf.size;
      return this->Report();
    }
    RecordReader<Record> reader(
      file, leaf.begin, leaf.begin + leaf.size, this->Plan.shape.blockRecords * sizeof(Record));
    for (std::uint64_t at = leaf.begin; at < leaf.begin + leaf.size;)
    {
      const Result<std::span<const Record>> block = reader.Next();
      KDSTREAM_TRY(block);
      KDSTREAM_TRY(WriteRecords<Record>(this->Work, at, *block));
      at += block->size();
      this->Done += block->size();
      KDSTREAM_TRY(this->Report());
    }
    return {};
  }

  void AddLeaf(std::uint64_t begin, unsigned depth)
  {
    this->Octree.clusterBegin.push_back(begin);
    this->Octree.depth = std::max(this->Octree.depth, depth);
  }

  // How many depths below a cell are counted at the same time: each slot needs a table with 4 bytes
  // a cell.
  unsigned DepthsAtOnce(unsigned depth) const
  {
    unsigned depths = 1;
    while (
      depths < 7 && depth + depths < octreeDeepest &&
      (std::uint64_t{ 4 } << 3 * (depths + 1)) * this->Plan.shape.slots <= this->Options.memory / 8)
    {
      ++depths;
    }
    return depths;
  }

  // Counts the vertices in a cell's descendants, divides the descendants into groups, and writes
  // the groups to another file.
  Status Distribute(const OctreeCell& cell, SpillFile& file, SpillFile& to, CountedCells& counted,
    std::vector<Group>& groups)
  {
    const unsigned depths = this->DepthsAtOnce(cell.depth);
    counted.deepest = cell.depth + depths;
    counted.mask = (std::uint64_t{ 1 } << 3 * depths) - 1;
    std::vector<std::uint32_t>& countOf = counted.table;
    countOf.assign(static_cast<std::size_t>(counted.mask) + 1, 0);
    {
      std::vector<std::vector<std::uint32_t>> ofSlot(this->Plan.shape.slots, countOf);
      BatchPass<Record> batches(this->Plan.shape, this->Run);
      KDSTREAM_TRY(batches.Over(
        file, cell.begin, cell.begin + cell.size,
        [&](std::size_t slot, std::span<Record> records) -> Status
        {
          for (const Record& record : records)
          {
            ++ofSlot[slot][counted.PlaceOf(this->KeyOf(record))];
          }
          return {};
        },
        [&](std::size_t, std::uint64_t) { return this->Report(); }));
      for (const std::vector<std::uint32_t>& counts : ofSlot)
      {
        std::transform(
          counts.begin(), counts.end(), countOf.begin(), countOf.begin(), std::plus<>());
      }
    }
    ++this->Octree.statistics.distributions;
    this->Octree.statistics.distributedRecords += cell.size;

    std::uint64_t begin = cell.begin;
    this->Gather({ cell.depth, 0, 0, false }, 0, counted, begin, groups);
    return this->WriteGroups(cell, file, to, groups, counted);
  }

  // Divides the leaves and the deepest counted cells below `cell` into groups. In the table, their
  // entries are [place, place + 8^(deepest - depth)); each count there is replaced by the number of
  // its cell.
  void Gather(OctreeCell cell, std::size_t place, CountedCells& counted, std::uint64_t& begin,
    std::vector<Group>& groups) const
  {
    const std::size_t places = std::size_t{ 1 } << 3 * (counted.deepest - cell.depth);
    const std::span<std::uint32_t> counts = std::span(counted.table).subspan(place, places);
    cell.size = std::accumulate(counts.begin(), counts.end(), std::uint64_t{ 0 });
    if (cell.size == 0)
    {
      return;
    }
    cell.isLeaf = cell.size <= this->Options.verticesPerPartition || cell.depth == octreeDeepest;
    if (!cell.isLeaf && cell.depth < counted.deepest)
    {
      for (std::size_t child = 0; child < 8; ++child)
      {
        this->Gather(
          { cell.depth + 1, 0, 0, false }, place + child * (places / 8), counted, begin, groups);
      }
      return;
    }
    cell.begin = begin;
    begin += cell.size;
    if (groups.empty() || groups.back().size + cell.size > this->GroupRecords)
    {
      groups.push_back({ {}, cell.begin, 0, static_cast<std::uint32_t>(counted.groupOf.size()) });
    }
    groups.back().cells.push_back(cell);
    groups.back().size += cell.size;
    std::fill(counts.begin(), counts.end(), static_cast<std::uint32_t>(counted.groupOf.size()));
    counted.groupOf.push_back(static_cast<std::uint32_t>(groups.size() - 1));
  }

  Status WriteGroups(const OctreeCell& cell, SpillFile& file, SpillFile& to,
    const std::vector<Group>& groups, const CountedCells& counted)
  {
    struct Slot
    {
      std::vector<Record> inOrder;    // group by group
      std::vector<std::size_t> begin; // where each group begins, and the end
      std::vector<std::uint64_t> to;
    };
    const auto groupOf = [&](const Record& record)
    { return counted.groupOf[counted.CellOf(this->KeyOf(record))]; };
    std::vector<Slot> slots(this->Plan.shape.slots);
    for (Slot& slot : slots)
    {
      slot.inOrder.resize(this->Plan.shape.blockRecords);
      slot.to.resize(groups.size());
    }
    std::vector<std::uint64_t> next;
    next.reserve(groups.size());
    for (const Group& group : groups)
    {
      next.push_back(group.begin);
    }
    BatchPass<Record> batches(this->Plan.shape, this->Run);
    return batches.Over(
      file, cell.begin, cell.begin + cell.size,
      [&](std::size_t index, std::span<Record> records) -> Status
      {
        Slot& slot = slots[index];
        slot.begin.assign(groups.size() + 1, 0);
        for (const Record& record : records)
        {
          ++slot.begin[groupOf(record) + 1];
        }
        std::partial_sum(slot.begin.begin(), slot.begin.end(), slot.begin.begin());
        std::vector<std::size_t> at(slot.begin.begin(), slot.begin.end() - 1);
        for (const Record& record : records)
        {
          slot.inOrder[at[groupOf(record)]++] = record;
        }
        return {};
      },
      [&](std::size_t used, std::uint64_t) -> Status
      {
        for (std::size_t i = 0; i < used; ++i)
        {
          slots[i].to = next;
          for (std::size_t group = 0; group < groups.size(); ++group)
          {
            next[group] += slots[i].begin[group + 1] - slots[i].begin[group];
          }
        }
        this->Run.parallelFor(used, 1,
          [&](std::size_t firstSlot, std::size_t lastSlot)
          {
            for (std::size_t i = firstSlot; i < lastSlot; ++i)
            {
              const Slot& slot = slots[i];
              for (std::size_t group = 0; group < groups.size() && batches.StatusOf(i); ++group)
              {
                batches.StatusOf(i) = WriteRecords<Record>(to, slot.to[group],
                  std::span<const Record>(slot.inOrder)
                    .subspan(slot.begin[group], slot.begin[group + 1] - slot.begin[group]));
              }
            }
          });
        KDSTREAM_TRY(batches.FirstError(used));
        return this->Report();
      });
  }

  // Reads a group, splits its cells, and writes the leaves in order.
  Status FinishInMemory(const Group& group, const CountedCells& counted, SpillFile& file)
  {
    ReturnFreeMemory();
    const auto size = static_cast<std::size_t>(group.size);
    std::vector<Record> records(size);
    KDSTREAM_TRY(ReadRecords<Record>(file, group.begin, std::span<Record>(records)));
    std::vector<Item> items = this->ItemsOf(records, group, counted);
    std::vector<OctreeCell> leaves = this->LeavesOf(group, items);
    for (const OctreeCell& leaf : leaves)
    {
      this->AddLeaf(group.begin + leaf.begin, leaf.depth);
    }
    std::vector<Record> inOrder(size);
    this->Run.parallelFor(size, 1 << 14,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t i = begin; i < end; ++i)
        {
          inOrder[i] = records[items[i].position];
        }
      });
    ++this->Octree.statistics.groupsInMemory;
    this->Done += group.size;
    KDSTREAM_TRY(WriteRecords<Record>(this->Work, group.begin, std::span<const Record>(inOrder)));
    return this->Report();
  }

  // The items of a group, cell by cell.
  std::vector<Item> ItemsOf(
    const std::vector<Record>& records, const Group& group, const CountedCells& counted) const
  {
    std::vector<Item> items(records.size());
    this->Run.parallelFor(records.size(), 1 << 14,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t i = begin; i < end; ++i)
        {
          items[i] = { this->KeyOf(records[i]), static_cast<std::uint32_t>(i) };
        }
      });
    if (group.cells.size() == 1)
    {
      return items;
    }
    std::vector<std::uint64_t> next;
    next.reserve(group.cells.size());
    for (const OctreeCell& cell : group.cells)
    {
      next.push_back(cell.begin - group.begin);
    }
    std::vector<Item> inOrder(items.size());
    for (const Item& item : items)
    {
      inOrder[next[counted.CellOf(item.key) - group.firstCell]++] = item;
    }
    return inOrder;
  }

  // Orders the items leaf by leaf, and returns the leaves; `begin` of a leaf is relative to the
  // group.
  std::vector<OctreeCell> LeavesOf(const Group& group, std::vector<Item>& items) const
  {
    std::vector<Item> scratch(items.size());
    std::vector<OctreeCell> cells = group.cells;
    for (OctreeCell& cell : cells)
    {
      cell.begin -= group.begin;
    }
    // Splits large cells first, until there are enough for all threads; then each is finished
    // separately.
    constexpr std::size_t enough = 64;
    for (bool isSplit = true; isSplit && cells.size() < enough;)
    {
      isSplit = false;
      std::vector<OctreeCell> next;
      for (const OctreeCell& cell : cells)
      {
        isSplit = isSplit || !cell.isLeaf;
        cell.isLeaf ? next.push_back(cell) : this->Split(cell, items, scratch, next);
      }
      cells = std::move(next);
    }
    std::vector<std::vector<OctreeCell>> leavesOf(cells.size());
    this->Run.parallelFor(cells.size(), 1,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t i = begin; i < end; ++i)
        {
          this->Finish(cells[i], items, scratch, leavesOf[i]);
        }
      });
    std::vector<OctreeCell> leaves;
    for (const std::vector<OctreeCell>& some : leavesOf)
    {
      leaves.insert(leaves.end(), some.begin(), some.end());
    }
    return leaves;
  }

  void Finish(const OctreeCell& cell, std::vector<Item>& items, std::vector<Item>& scratch,
    std::vector<OctreeCell>& leaves) const
  {
    if (cell.isLeaf)
    {
      leaves.push_back(cell);
      return;
    }
    std::vector<OctreeCell> children;
    this->Split(cell, items, scratch, children);
    for (const OctreeCell& child : children)
    {
      this->Finish(child, items, scratch, leaves);
    }
  }

  // Sorts the items of a cell into its children, and adds those children that have any.
  void Split(const OctreeCell& cell, std::vector<Item>& items, std::vector<Item>& scratch,
    std::vector<OctreeCell>& children) const
  {
    const unsigned shift = 3 * (octreeDeepest - 1 - cell.depth);
    const std::span<Item> own = std::span(items).subspan(cell.begin, cell.size);
    std::array<std::size_t, 9> begin{};
    for (const Item& item : own)
    {
      ++begin[(item.key >> shift & 7) + 1];
    }
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::array<std::size_t, 9> next = begin;
    for (const Item& item : own)
    {
      scratch[cell.begin + next[item.key >> shift & 7]++] = item;
    }
    std::copy_n(scratch.begin() + std::ptrdiff_t(cell.begin), cell.size, own.begin());
    for (std::size_t child = 0; child < 8; ++child)
    {
      const std::uint64_t size = begin[child + 1] - begin[child];
      const bool isLeaf =
        size <= this->Options.verticesPerPartition || cell.depth + 1 == octreeDeepest;
      if (size > 0)
      {
        children.push_back({ cell.depth + 1, cell.begin + begin[child], size, isLeaf });
      }
    }
  }

  SpillFolder& Folder;
  SpillFile& Points;
  ExternalOctree& Octree;
  const ExternalOctreeOptions& Options;
  MemoryPlan Plan;
  const Execution& Run;
  std::uint64_t Count;
  std::uint64_t GroupRecords;
  std::uint64_t Done = 0; // records that are in their leaves
  OctreeCube Cube{ Box{ {}, {} } };
  SpillFile Work, SecondWork;
};

}

template <class Scalar>
Result<ExternalOctree> ClusterByExternalOctree(SpillFolder& folder, SpillFile& points,
  const ExternalOctreeOptions& options, const Execution& execution)
{
  constexpr std::size_t recordBytes = sizeof(PointRecord<Scalar>);
  if (points.Size() < recordBytes)
  {
    return Error{ ErrorCode::InvalidArgument, "the mesh has no vertices" };
  }
  if (options.verticesPerPartition == 0)
  {
    return Error{ ErrorCode::InvalidArgument,
      "the number of vertices per partition must be at least 1, not 0" };
  }
  constexpr std::uint64_t least = 4 * MemoryPlan::Least(recordBytes);
  if (options.memory < least)
  {
    return Error{ ErrorCode::LimitExceeded, "the octree needs at least " + std::to_string(least) +
                                              " bytes of memory; the limit is " +
                                              std::to_string(options.memory) + "" };
  }
  const SpillCounts before = folder.Counts();
  ExternalOctree octree;
  ExternalOctreeBuilder<Scalar> builder(folder, points, octree, options, execution);
  KDSTREAM_TRY(builder.Build());
  const SpillCounts after = folder.Counts();
  octree.statistics.bytesRead = after.bytesRead - before.bytesRead;
  octree.statistics.bytesWritten = after.bytesWritten - before.bytesWritten;
  octree.statistics.peakBytesOnDisk = after.peakBytesOnDisk;
  return octree;
}

template Result<ExternalOctree> ClusterByExternalOctree<float>(
  SpillFolder&, SpillFile&, const ExternalOctreeOptions&, const Execution&);
template Result<ExternalOctree> ClusterByExternalOctree<double>(
  SpillFolder&, SpillFile&, const ExternalOctreeOptions&, const Execution&);

}
