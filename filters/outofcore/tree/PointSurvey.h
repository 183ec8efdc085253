// SPDX-License-Identifier: BSD-3-Clause
// The first pass over all points: checks that their coordinates are numbers, and finds their box
// and mean.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Extent.h"
#include "filters/outofcore/files/BatchPass.h"
#include "filters/outofcore/tree/CellStatistics.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace kdstream
{

// Errors: InvalidInput, naming the vertex and the axis.
template <class Scalar>
Status CheckNumbers(std::span<const PointRecord<Scalar>> records)
{
  for (const PointRecord<Scalar>& record : records)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      if (!std::isfinite(record.p[k]))
      {
        return Error{ ErrorCode::InvalidInput,
          "vertex " + std::to_string(record.id) + ": " + "xyz"[k] + " is not finite" };
      }
    }
  }
  return {};
}

// One pass over a file of records; reports the step "survey".
template <class Scalar>
Status SurveyPoints(
  const SpillFile& points, const BatchShape& shape, const Execution& execution, CellStatistics& all)
{
  using Record = PointRecord<Scalar>;
  const std::uint64_t count = points.Size() / sizeof(Record);
  std::vector<CellStatistics> ofSlot(shape.slots);
  BatchPass<Record> batches(shape, execution);
  KDSTREAM_TRY(batches.Over(
    points, 0, count,
    [&](std::size_t slot, std::span<Record> records) -> Status
    {
      KDSTREAM_TRY(CheckNumbers<Scalar>(records));
      ofSlot[slot].template Add<Scalar>(std::span<const Record>(records));
      return {};
    },
    [&](std::size_t, std::uint64_t last)
    { return execution.Report("survey", double(last) / double(count)); }));
  for (const CellStatistics& some : ofSlot)
  {
    all.Add(some);
  }
  return CheckExtent(all.box);
}

}
