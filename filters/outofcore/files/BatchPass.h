// SPDX-License-Identifier: BSD-3-Clause
// One pass over the records of a file, many blocks at a time: blocks are read and processed in
// parallel; then their results are taken in order. Every step out of core uses it.
#pragma once

#include "filters/core/Execution.h"
#include "filters/outofcore/files/RecordFile.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

namespace kdstream
{

// How many blocks are processed at once, and how large each is. Both depend only on the memory. So
// sums over slots do not depend on the number of threads.
struct BatchShape
{
  std::size_t slots = 1;
  std::size_t blockRecords = 1;
};

// Buffers for the blocks of one pass.
template <SpillRecord Record>
class BatchPass
{
public:
  BatchPass(const BatchShape& shape, const Execution& execution)
    : Shape(shape)
    , Run(execution)
    , Blocks(shape.slots)
    , Statuses(shape.slots)
  {
  }

  // Reads the records [begin, end) of `file`. For each block, work(slot, records) -> Status or
  // work(slot, records, number of the first record) -> Status is called, on any thread. Slot i
  // works on the blocks i, i + slots, …; `work` may change the records. After each batch,
  // after(used, last) -> Status is called on the calling thread: the slots [0, used) hold results,
  // and `last` is the number of the record after the batch.
  template <class Work, class After>
  Status Over(const SpillFile& file, std::uint64_t begin, std::uint64_t end, const Work& work,
    const After& after)
  {
    while (begin < end)
    {
      const std::uint64_t block = this->Shape.blockRecords;
      const std::uint64_t last = std::min(end, begin + block * this->Shape.slots);
      const auto used = static_cast<std::size_t>((last - begin + block - 1) / block);
      this->Run.parallelFor(used, 1,
        [&](std::size_t firstSlot, std::size_t lastSlot)
        {
          for (std::size_t slot = firstSlot; slot < lastSlot; ++slot)
          {
            const std::uint64_t from = begin + slot * block;
            std::vector<Record>& records = this->Blocks[slot];
            records.resize(static_cast<std::size_t>(std::min(last, from + block) - from));
            this->Statuses[slot] = ReadRecords<Record>(file, from, std::span<Record>(records));
            if (this->Statuses[slot])
            {
              if constexpr (std::is_invocable_v<Work, std::size_t, std::span<Record>,
                              std::uint64_t>)
              {
                this->Statuses[slot] = work(slot, std::span<Record>(records), from);
              }
              else
              {
                this->Statuses[slot] = work(slot, std::span<Record>(records));
              }
            }
          }
        });
      KDSTREAM_TRY(this->FirstError(used));
      KDSTREAM_TRY(after(used, last));
      begin = last;
    }
    return {};
  }

  // The first error, by slot; for other code that runs over the slots, too.
  Status FirstError(std::size_t used) const
  {
    for (std::size_t slot = 0; slot < used; ++slot)
    {
      if (!this->Statuses[slot])
      {
        return this->Statuses[slot];
      }
    }
    return {};
  }

  Status& StatusOf(std::size_t slot) { return this->Statuses[slot]; }

private:
  BatchShape Shape;
  const Execution& Run;
  std::vector<std::vector<Record>> Blocks;
  std::vector<Status> Statuses;
};

}
