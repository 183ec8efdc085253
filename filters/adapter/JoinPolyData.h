// SPDX-License-Identifier: BSD-3-Clause
// Turns the input of a filter into one vtkPolyData without ghosts: the input itself, or the joined
// blocks of a composite data set.
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

// When the input was last changed. The time of a composite data set does not include its blocks, so
// these are checked too.
vtkMTimeType TimeOf(vtkDataObject& input);

struct JoinedPolyData
{
  vtkSmartPointer<vtkPolyData> mesh; // may share arrays with the input
  std::vector<std::string> leftOut;  // e.g. `point array "A": not all parts have it`
};

// Takes a vtkPolyData, or a vtkPartitionedDataSet, vtkPartitionedDataSetCollection or
// vtkMultiBlockDataSet of them, nested in any way. Null or empty blocks are ignored.
//
// - Dropped cells: those that vtkGhostType marks as duplicate, hidden or refined.
// - Dropped points: those that vtkGhostType marks as duplicate or hidden; if a part marks no
//   points, those of dropped cells. In both cases a point is dropped only if no remaining cell uses
//   it. A duplicate point that a cell uses is replaced by the point that it is a copy of
//   (MergePoints).
// - Shared points become one: by global ids if all parts have them, or by place if `weldByPlace` is
//   set; otherwise they stay separate. If points in different places share an id, ids are not used,
//   and this is listed.
//
// Points have the type of the points of all parts, or are doubles if types differ. Points and cells
// are in the order of the parts, or of their global ids; among cells first vertices, then lines,
// polygons, strips. The result has the arrays that all parts have (SharedArrays); an array is
// active if it is active in all parts.
//
// A vtkPolyData without ghosts stays as it is, except arrays of a wrong length. A vtkGhostType of a
// wrong length or type marks nothing, and is listed.
//
// O(n log n) for n points, of which only those that may be shared are sorted. Memory: that of the
// output, 60 bytes a point, 8 a corner. Errors: InvalidInput, naming the part, for data that is not
// a vtkPolyData, a coordinate that is not finite, or a cell that uses a missing point;
// LimitExceeded.
Result<JoinedPolyData> JoinPolyData(
  vtkDataObject& input, bool weldByPlace, const Execution& execution);

}
