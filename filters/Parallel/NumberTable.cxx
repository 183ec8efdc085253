// SPDX-License-Identifier: BSD-3-Clause
#include "filters/Parallel/NumberTable.h"

#include "filters/outofcore/files/RecordFile.h"
#include "filters/outofcore/files/ScatteredRead.h"

#include <algorithm>
#include <numeric>

namespace kdstream
{

Result<NumberTable> NumberTable::Open(SpillFile file, std::uint64_t count, std::uint64_t memory)
{
  NumberTable table;
  table.Numbers = std::move(file);
  if (count <= memory / sizeof(VertexId))
  {
    table.Held.resize(static_cast<std::size_t>(count));
    KDSTREAM_TRY(ReadRecords<VertexId>(table.Numbers, 0, std::span<VertexId>(table.Held)));
  }
  return table;
}

Status NumberTable::Look(std::span<VertexId> places) const
{
  if (!this->Held.empty() || places.empty())
  {
    std::transform(places.begin(), places.end(), places.begin(),
      [&](VertexId place) { return this->Held[place]; });
    return {};
  }
  std::vector<std::uint32_t> order(places.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(),
    [&](std::uint32_t a, std::uint32_t b) { return places[a] < places[b]; });
  std::vector<VertexId> sorted(places.size());
  std::transform(
    order.begin(), order.end(), sorted.begin(), [&](std::uint32_t i) { return places[i]; });
  std::vector<VertexId> numbers(places.size());
  KDSTREAM_TRY(ReadRecordsAt<VertexId>(this->Numbers, sorted, std::span(numbers)));
  for (std::size_t i = 0; i < order.size(); ++i)
  {
    places[order[i]] = numbers[i];
  }
  return {};
}

}
