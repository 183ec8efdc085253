// SPDX-License-Identifier: BSD-3-Clause
// Makes one vtkPolyData without ghosts of a filter's input: the input itself, or the joined blocks
// of a composite data set.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"

#include <vtkDataObject.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <string>
#include <vector>

namespace kdstream
{

// When the input was last changed: a composite data set's own time does not include its blocks.
vtkMTimeType TimeOf(vtkDataObject& input);

struct JoinedPolyData
{
  vtkSmartPointer<vtkPolyData> mesh; // its arrays may be the input's
  std::vector<std::string> leftOut;  // e.g. `point array "A": not all parts have it`
};

// Takes a vtkPolyData, or a vtkPartitionedDataSet, vtkPartitionedDataSetCollection or
// vtkMultiBlockDataSet of them, nested in any way; null or empty blocks do not count.
//
// - Dropped cells: those that vtkGhostType marks as duplicate, hidden or refined.
// - Dropped points: those that it marks as duplicate or hidden, and, where a part marks no points,
//   points of dropped cells; in both cases only if no remaining cell uses them. A duplicate point
//   that a cell uses becomes the point that it is a copy of (MergePoints).
// - Shared points become one by global ids, where all parts have them, or by place, if
//   `weldByPlace` is set; else they stay separate. Ids that points in different places share are
//   not used, and listed.
//
// Points have the type of all parts' points, or are doubles. Points and cells are in the order of
// the parts, or of their global ids; of cells first vertices, then lines, polygons, strips. The
// result has the arrays that all parts have (SharedArrays); an array is active if it is in all
// parts.
//
// A vtkPolyData without ghosts stays as it is, except arrays of a wrong length. A vtkGhostType of a
// wrong length or type marks nothing, and is listed.
//
// O(n log n) for n points, of which those that may be shared are sorted; memory: that of the
// output, 60 bytes a point, 8 a corner. Errors: InvalidInput for data that is not a vtkPolyData, a
// coordinate that is not finite, or a cell that uses a missing point, naming the part;
// LimitExceeded.
Result<JoinedPolyData> JoinPolyData(
  vtkDataObject& input, bool weldByPlace, const Execution& execution);

}
