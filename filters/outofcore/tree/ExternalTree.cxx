// SPDX-License-Identifier: BSD-3-Clause
// The k-d tree out of core: see ExternalTree.h. There are two files, each as large as all records.
// Every cell is stored in one of them, at its place in the order of the tree. A cell moves to the
// other file when it is split, and to the first work file when it is finished.
#include "filters/outofcore/tree/ExternalTree.h"

#include "filters/core/tree/RecordSelection.h"
#include "filters/core/tree/RecordTree.h"
#include "filters/outofcore/files/BatchPass.h"
#include "filters/outofcore/files/MemoryPlan.h"
#include "filters/outofcore/files/ReturnFreeMemory.h"
#include "filters/outofcore/tree/PointSurvey.h"

#include <algorithm>
#include <optional>
#include <string>

namespace kdstream
{
namespace
{

// A cell in one of the files.
struct FileCell
{
  unsigned depth = 0;
  std::uint64_t index = 0;
  CellRange range;
  SpillFile* file = nullptr;
  CellStatistics statistics;

  std::uint64_t End() const { return this->range.begin + this->range.size; }
};

// Reads the keys of a cell along an axis (MedianSearch.h).
template <class Scalar>
class CellKeys : public KeySource
{
public:
  CellKeys(const FileCell& cell, std::size_t axis, const BatchShape& shape,
    const Execution& execution, double progress)
    : Cell(cell)
    , Axis(axis)
    , Run(execution)
    , Progress(progress)
    , Batches(shape, execution)
    , Keys(shape.slots)
    , Wanted(shape.slots)
  {
  }

  std::size_t Slots() const override { return this->Keys.size(); }

  Status Pass(const Filter& filter, const Take& take) override
  {
    ++this->Passes;
    return this->Batches.Over(
      *this->Cell.file, this->Cell.range.begin, this->Cell.End(),
      [&](std::size_t slot, std::span<PointRecord<Scalar>> records) -> Status
      {
        std::vector<OrderKey>& keys = this->Keys[slot];
        keys.resize(records.size());
        for (std::size_t i = 0; i < records.size(); ++i)
        {
          keys[i] = { OrderedBits(double(records[i].p[this->Axis])), records[i].id };
        }
        this->Wanted[slot] = filter(slot, keys);
        return {};
      },
      [&](std::size_t used, std::uint64_t) -> Status
      {
        for (std::size_t slot = 0; slot < used; ++slot)
        {
          const std::span<const OrderKey> keys = this->Keys[slot];
          KDSTREAM_TRY(take(keys.first(this->Wanted[slot])));
        }
        return this->GoOn();
      });
  }

  Status OwnPass() override
  {
    ++this->Passes;
    return this->GoOn();
  }

  Status GoOn() const override { return this->Run.Report("tree", this->Progress); }

  std::uint64_t Passes = 0;

private:
  const FileCell& Cell;
  std::size_t Axis;
  const Execution& Run;
  double Progress;
  BatchPass<PointRecord<Scalar>> Batches;
  std::vector<std::vector<OrderKey>> Keys;
  std::vector<std::size_t> Wanted;
};

// Writes the halves of a cell around its median to another file, and gathers their statistics.
// Records around the median that the method left undecided are kept until the end.
template <class Scalar, std::size_t Axis>
class Partition
{
public:
  using Record = PointRecord<Scalar>;

  // The lower half gets the first `rank` keys of the cell.
  Partition(const FileCell& cell, const KeyRange& median, std::uint64_t rank, SpillFile& to,
    const MemoryPlan& plan, bool wantBins)
    : Cell(cell)
    , Median(median)
    , Rank(rank)
    , To(to)
    , Shape(plan.shape)
    , Slots(plan.shape.slots)
  {
    this->Kept.reserve(static_cast<std::size_t>(median.inside));
    for (Slot& slot : this->Slots)
    {
      slot.divided.resize(plan.shape.blockRecords);
      if (wantBins)
      {
        slot.statistics[0].WantBins(cell.statistics.box, plan.bits);
        slot.statistics[1].WantBins(cell.statistics.box, plan.bits);
      }
    }
    if (wantBins)
    {
      this->Halves[0].WantBins(cell.statistics.box, plan.bits);
      this->Halves[1].WantBins(cell.statistics.box, plan.bits);
    }
  }

  // report(records written) -> Status is called after each batch.
  template <class Report>
  Status Run(const Execution& execution, const Report& report)
  {
    BatchPass<Record> batches(this->Shape, execution);
    std::uint64_t lower = this->Cell.range.begin;
    std::uint64_t upper = lower + this->Median.below + this->Median.inside;
    KDSTREAM_TRY(batches.Over(
      *this->Cell.file, this->Cell.range.begin, this->Cell.End(),
      [&](std::size_t slot, std::span<Record> records) -> Status
      {
        this->Divide(this->Slots[slot], records);
        return {};
      },
      [&](std::size_t used, std::uint64_t last) -> Status
      {
        this->Place(used, lower, upper);
        execution.parallelFor(used, 1,
          [&](std::size_t first, std::size_t end)
          {
            for (std::size_t slot = first; slot < end; ++slot)
            {
              batches.StatusOf(slot) = this->Write(this->Slots[slot]);
            }
          });
        KDSTREAM_TRY(batches.FirstError(used));
        return report(last - this->Cell.range.begin);
      }));
    for (const Slot& slot : this->Slots)
    {
      this->Halves[0].Add(slot.statistics[0]);
      this->Halves[1].Add(slot.statistics[1]);
    }
    return this->WriteKept();
  }

  std::array<CellStatistics, 2> Halves;

private:
  struct Slot
  {
    std::vector<Record> divided; // the lower half at the front, the upper half at the back
    std::size_t lower = 0, upper = 0;
    std::span<const Record> undecided; // at the front of the block itself
    std::uint64_t lowerAt = 0, upperAt = 0;
    std::array<CellStatistics, 2> statistics;

    std::span<const Record> Lower() const
    {
      return std::span<const Record>(this->divided).first(this->lower);
    }
    std::span<const Record> Upper() const
    {
      return std::span<const Record>(this->divided).last(this->upper);
    }
  };

  // Writes every record to all three places, but advances only one of them: this is cheaper than
  // branching.
  void Divide(Slot& slot, std::span<Record> records) const
  {
    Record* const divided = slot.divided.data();
    const std::size_t size = slot.divided.size();
    std::size_t lower = 0, upper = 0, undecided = 0;
    const std::uint64_t first = this->Median.first.coordinate, firstId = this->Median.first.id;
    const std::uint64_t last = this->Median.last.coordinate, lastId = this->Median.last.id;
    for (const Record record : records)
    {
      const std::uint64_t coordinate = OrderedBits(double(record.p[Axis]));
      const unsigned isLower = unsigned(coordinate < first) |
                               (unsigned(coordinate == first) & unsigned(record.id < firstId));
      const unsigned isUpper =
        unsigned(coordinate > last) | (unsigned(coordinate == last) & unsigned(record.id > lastId));
      divided[lower] = record;
      divided[size - 1 - upper] = record;
      records[undecided] = record;
      lower += isLower;
      upper += isUpper;
      undecided += 1 - isLower - isUpper;
    }
    slot.lower = lower;
    slot.upper = upper;
    slot.undecided = records.first(undecided);
    slot.statistics[0].template Add<Scalar>(slot.Lower());
    slot.statistics[1].template Add<Scalar>(slot.Upper());
  }

  // Determines where the records of each slot go in the output.
  void Place(std::size_t used, std::uint64_t& lower, std::uint64_t& upper)
  {
    for (std::size_t i = 0; i < used; ++i)
    {
      Slot& slot = this->Slots[i];
      slot.lowerAt = lower;
      slot.upperAt = upper;
      lower += slot.lower;
      upper += slot.upper;
      this->Kept.insert(this->Kept.end(), slot.undecided.begin(), slot.undecided.end());
    }
  }

  Status Write(const Slot& slot)
  {
    KDSTREAM_TRY(WriteRecords<Record>(this->To, slot.lowerAt, slot.Lower()));
    return WriteRecords<Record>(this->To, slot.upperAt, slot.Upper());
  }

  // Writes the undecided records into the gap between the halves.
  Status WriteKept()
  {
    const auto lower = static_cast<std::size_t>(this->Rank - this->Median.below);
    Record* const first = this->Kept.data();
    RecordSelection<Scalar, Axis>::Select(first, first + lower, first + this->Kept.size());
    const std::span<const Record> kept = this->Kept;
    this->Halves[0].template Add<Scalar>(kept.first(lower));
    this->Halves[1].template Add<Scalar>(kept.subspan(lower));
    return WriteRecords<Record>(this->To, this->Cell.range.begin + this->Median.below, kept);
  }

  const FileCell& Cell;
  KeyRange Median;
  std::uint64_t Rank;
  SpillFile& To;
  BatchShape Shape;
  std::vector<Slot> Slots;
  std::vector<Record> Kept;
};

template <class Scalar>
class ExternalTreeBuilder
{
public:
  using Record = PointRecord<Scalar>;

  ExternalTreeBuilder(SpillFolder& folder, SpillFile& points, ExternalTree& tree,
    const ExternalTreeOptions& options, const MemoryPlan& plan, const Execution& execution)
    : Folder(folder)
    , Points(points)
    , Tree(tree)
    , Options(options)
    , Plan(plan)
    , Run(execution)
    , Count(points.Size() / sizeof(Record))
  {
    // The sizes of cells of one depth differ by at most one vertex.
    while (((this->Count - 1) >> this->ExternalDepths) + 1 > plan.cellRecords)
    {
      ++this->ExternalDepths;
    }
  }

  Status Build()
  {
    const bool fits = this->ExternalDepths == 0;
    if (!fits || this->Options.keepPoints)
    {
      KDSTREAM_TRY(this->CreateWorkFile(this->Work));
    }
    FileCell root{ 0, 0, { 0, this->Count }, &this->Points, {} };
    KDSTREAM_TRY(
      fits ? Status{}
           : SurveyPoints<Scalar>(this->Points, this->Plan.shape, this->Run, root.statistics));
    KDSTREAM_TRY(this->Descend(root));
    this->Tree.records = this->Work.IsOpen() ? std::move(this->Work) : std::move(this->Points);
    if (!this->Options.keepPoints)
    {
      this->Points.Remove();
    }
    return {};
  }

private:
  Status CreateWorkFile(SpillFile& file)
  {
    Result<SpillFile> created =
      this->Folder.CreateFile("points of the tree", this->Count * sizeof(Record));
    KDSTREAM_TRY(created);
    file = std::move(*created);
    return {};
  }

  // Builds the tree below a cell.
  Status Descend(FileCell& cell)
  {
    if (cell.range.size <= this->Plan.cellRecords)
    {
      return this->FinishInMemory(cell);
    }
    std::array<FileCell, 2> halves;
    KDSTREAM_TRY(this->Split(cell, halves));
    cell.statistics = {}; // frees memory for the halves
    for (FileCell& half : halves)
    {
      KDSTREAM_TRY(this->Descend(half));
      half.statistics = {};
    }
    return {};
  }

  Status Split(const FileCell& cell, std::array<FileCell, 2>& halves)
  {
    if (cell.depth <= this->Tree.depths.partition)
    {
      this->Tree.boxes[(std::size_t{ 1 } << cell.depth) + cell.index] = cell.statistics.box;
    }
    SpillFile* to = &this->Work;
    if (cell.file == to)
    {
      to = this->Options.keepPoints ? &this->SecondWork : &this->Points;
      if (!to->IsOpen())
      {
        KDSTREAM_TRY(this->CreateWorkFile(*to));
      }
    }
    const std::uint64_t lower = cell.range.size / 2;
    const std::size_t axis = LongestAxis(cell.statistics.box);
    const Result<KeyRange> median = this->Median(cell, axis, lower);
    KDSTREAM_TRY(median);
    halves[0] = { cell.depth + 1, 2 * cell.index, { cell.range.begin, lower }, to, {} };
    halves[1] = { cell.depth + 1, 2 * cell.index + 1,
      { cell.range.begin + lower, cell.range.size - lower }, to, {} };
    if (axis == 0)
    {
      return this->Divide<0>(cell, *median, *to, halves);
    }
    return axis == 1 ? this->Divide<1>(cell, *median, *to, halves)
                     : this->Divide<2>(cell, *median, *to, halves);
  }

  Result<KeyRange> Median(const FileCell& cell, std::size_t axis, std::uint64_t rank)
  {
    MedianSearch search;
    search.rank = rank;
    search.keepable = this->Plan.keepable;
    search.memory = this->Plan.method;
    search.heapShare = this->Options.heapShare;
    search.mean = cell.statistics.sum[axis] / double(cell.range.size);
    const Box& box = cell.statistics.box;
    search.known = { { OrderedBits(box.lo[axis]), 0 }, { OrderedBits(box.hi[axis]), greatestId }, 0,
      cell.range.size };
    if (this->WantBins() && !cell.statistics.bins[axis].Empty())
    {
      const CoordinateBins::Bin bin = cell.statistics.bins[axis].BinOfRank(rank);
      search.known = { { bin.first, 0 }, { bin.last, greatestId }, bin.below, bin.inside };
    }
    CellKeys<Scalar> keys(cell, axis, this->Plan.shape, this->Run, this->Fraction(0));
    Result<KeyRange> median = this->Method()(keys, search, this->Folder);
    ReturnFreeMemory(); // the method's memory, before the halves are written
    std::vector<ExternalDepthStatistics>& depths = this->Tree.statistics.depths;
    depths.resize(std::max<std::size_t>(depths.size(), cell.depth + 1));
    ExternalDepthStatistics& depth = depths[cell.depth];
    ++depth.cells;
    depth.records += cell.range.size;
    depth.medianPasses += keys.Passes;
    depth.mostMedianPasses = std::max(depth.mostMedianPasses, keys.Passes);
    depth.medianRecords += keys.Passes * cell.range.size;
    return median;
  }

  MedianMethod Method() const
  {
    return this->Options.median ? this->Options.median : FindMedianByHistogram;
  }

  bool WantBins() const { return this->Method() == FindMedianByHistogram; }

  template <std::size_t Axis>
  Status Divide(
    const FileCell& cell, const KeyRange& median, SpillFile& to, std::array<FileCell, 2>& halves)
  {
    const bool wantBins =
      this->WantBins() && cell.range.size - cell.range.size / 2 > this->Plan.cellRecords;
    Partition<Scalar, Axis> partition(cell, median, cell.range.size / 2, to, this->Plan, wantBins);
    KDSTREAM_TRY(partition.Run(this->Run,
      [&](std::uint64_t written) { return this->Run.Report("tree", this->Fraction(written)); }));
    this->Done += cell.range.size;
    halves[0].statistics = std::move(partition.Halves[0]);
    halves[1].statistics = std::move(partition.Halves[1]);
    return {};
  }

  Status FinishInMemory(const FileCell& cell)
  {
    ReturnFreeMemory();
    std::vector<Record> records(static_cast<std::size_t>(cell.range.size));
    KDSTREAM_TRY(this->InBlocks(records,
      [&](std::uint64_t first, std::span<Record> block) -> Status
      {
        KDSTREAM_TRY(ReadRecords<Record>(*cell.file, cell.range.begin + first, block));
        return this->ExternalDepths == 0 ? CheckNumbers<Scalar>(block) : Status{};
      }));
    if (this->ExternalDepths == 0)
    {
      KDSTREAM_TRY(CheckExtent(BoxOfRecords<Scalar>(std::span<const Record>(records))));
    }
    Execution part = this->Run;
    part.progress = [&](std::string_view step, double fraction)
    {
      const auto finished = static_cast<std::uint64_t>(fraction * double(cell.range.size));
      return this->Run.progress(step, this->Fraction(finished));
    };
    KDSTREAM_TRY(BuildRecordTree<Scalar>(records, cell.depth, static_cast<std::size_t>(cell.index),
      this->Tree.depths, this->Tree.boxes, part));
    SpillFile& to = this->Work.IsOpen() ? this->Work : this->Points;
    KDSTREAM_TRY(this->InBlocks(records,
      [&](std::uint64_t first, std::span<Record> block) {
        return WriteRecords<Record>(to, cell.range.begin + first, std::span<const Record>(block));
      }));
    this->Done += cell.range.size;
    ++this->Tree.statistics.cellsInMemory;
    return {};
  }

  // Calls work(first, block) -> Status for every block of the records, on any thread.
  template <class Work>
  Status InBlocks(std::vector<Record>& records, const Work& work)
  {
    const std::size_t most = RecordsOfBlock<Record>(4 * spillBlockBytes);
    const std::size_t blocks = (records.size() + most - 1) / most;
    std::vector<Status> statuses(blocks);
    this->Run.parallelFor(blocks, 1,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t i = begin; i < end; ++i)
        {
          const std::size_t count = std::min(most, records.size() - i * most);
          statuses[i] = work(i * most, std::span<Record>(records).subspan(i * most, count));
        }
      });
    for (const Status& status : statuses)
    {
      KDSTREAM_TRY(status);
    }
    return {};
  }

  // The share of the tree that is done, including `now` records of the current step. Every record
  // is moved once for each depth that does not fit in memory, and once in memory.
  double Fraction(std::uint64_t now) const
  {
    const double all = double(this->Count) * double(this->ExternalDepths + 1);
    return std::min(1.0, double(this->Done + now) / all);
  }

  SpillFolder& Folder;
  SpillFile& Points;
  ExternalTree& Tree;
  const ExternalTreeOptions& Options;
  MemoryPlan Plan;
  const Execution& Run;
  std::uint64_t Count;
  unsigned ExternalDepths = 0; // depths whose cells do not fit in memory
  std::uint64_t Done = 0;      // records moved
  SpillFile Work, SecondWork;
};

}

template <class Scalar>
Result<ExternalTree> BuildExternalTree(SpillFolder& folder, SpillFile& points,
  const TreeDepths& depths, const ExternalTreeOptions& options, const Execution& execution)
{
  constexpr std::size_t recordBytes = sizeof(PointRecord<Scalar>);
  const std::uint64_t count = points.Size() / recordBytes;
  if (count == 0)
  {
    return Error{ ErrorCode::InvalidArgument, "the mesh has no vertices" };
  }
  const std::uint64_t boxBytes = (std::uint64_t{ 2 } << depths.partition) * sizeof(Box);
  const std::uint64_t finestCell = ((count - 1) >> depths.finest) + 1;
  const std::uint64_t least =
    std::max(finestCell * recordBytes, MemoryPlan::Least(recordBytes)) + boxBytes;
  if (options.memory < least)
  {
    return Error{ ErrorCode::LimitExceeded,
      "the tree needs at least " + std::to_string(least) + " bytes of memory; the limit is " +
        std::to_string(options.memory) + ": its finest cells have " + std::to_string(finestCell) +
        " vertices" };
  }
  const SpillCounts before = folder.Counts();
  ExternalTree tree;
  tree.depths = depths;
  tree.boxes.resize(std::size_t{ 2 } << depths.partition);
  ExternalTreeBuilder<Scalar> builder(
    folder, points, tree, options, MemoryPlan(options.memory - boxBytes, recordBytes), execution);
  KDSTREAM_TRY(builder.Build());
  const SpillCounts after = folder.Counts();
  tree.statistics.bytesRead = after.bytesRead - before.bytesRead;
  tree.statistics.bytesWritten = after.bytesWritten - before.bytesWritten;
  tree.statistics.peakBytesOnDisk = after.peakBytesOnDisk;
  return tree;
}

template Result<ExternalTree> BuildExternalTree<float>(
  SpillFolder&, SpillFile&, const TreeDepths&, const ExternalTreeOptions&, const Execution&);
template Result<ExternalTree> BuildExternalTree<double>(
  SpillFolder&, SpillFile&, const TreeDepths&, const ExternalTreeOptions&, const Execution&);

}
