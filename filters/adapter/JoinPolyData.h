// SPDX-License-Identifier: BSD-3-Clause
// What a filter is given as one vtkPolyData without ghosts: itself, or the blocks of a composite
// data set joined.
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

// When the input was changed last: a composite data set's own time does not tell of its blocks.
vtkMTimeType TimeOf(vtkDataObject& input);

struct JoinedPolyData
{
  vtkSmartPointer<vtkPolyData> mesh; // its arrays may be the input's
  std::vector<std::string> leftOut;  // e.g. `point array "A": not all parts have it`
};

// Takes a vtkPolyData, or a vtkPartitionedDataSet, vtkPartitionedDataSetCollection or
// vtkMultiBlockDataSet of them, however nested; blocks that are null or empty do not count.
//
// Dropped are cells that vtkGhostType marks as duplicate, hidden or refined; points that it marks
// as duplicate or hidden, and, where a part marks no points, points of dropped cells, if no cell
// that stays uses them. A duplicate point that a cell uses becomes the point that it is a copy of
// (MergePoints). Points that parts share become one by global ids, where all parts have them, or by
// place, where `weldByPlace` says so; else they stay apart.
//
// Points have the type of all parts' points, or are doubles. Points and cells are in the order of
// the parts, or of their global ids; of cells first vertices, then lines, polygons, strips. There
// are the arrays that all parts have (SharedArrays); those are active that are in all parts.
//
// A vtkPolyData without ghosts is as it was, but for arrays of a wrong length. A vtkGhostType of a
// wrong length or type marks nothing, and is listed.
//
// O(n log n) for n points of which what may be shared is sorted; memory: that of the output, 60
// bytes a point, 8 a corner. Errors: InvalidInput for data that is no vtkPolyData, a coordinate
// that is not finite, or a cell that uses a point that is not there, naming the part;
// LimitExceeded.
Result<JoinedPolyData> JoinPolyData(
  vtkDataObject& input, bool weldByPlace, const Execution& execution);

}
