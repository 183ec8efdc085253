// SPDX-License-Identifier: BSD-3-Clause
// What a writer is given as one mesh of core's: a vtkPolyData, or the partitions of one.
#pragma once

#include "filters/adapter/RankGroup.h"
#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"

#include <vtkDataObject.h>

#include <string>
#include <vector>

namespace kdstream
{

struct WriterInput
{
  Mesh mesh;
  std::vector<std::string> skipped; // arrays: PolyDataAttributes, or those that some parts lack
};

// Triangles with the points that they use, or, where there are no polygons and strips at all, all
// points. Of a vtkPartitionedDataSet its parts one after the other, without the cells that
// vtkGhostType marks as duplicates; their points fall together again where they are welded. Arrays
// that all parts have. Errors: InvalidInput for another kind of data, naming it, and those of
// PolyDataMesh, naming the part.
Result<WriterInput> ReadWriterInput(vtkDataObject& input, const Execution& execution);

// What all ranks have, one after the other, at rank 0: its arrays are those that all have. Others
// have nothing left. Called by all together. Errors: LimitExceeded, at rank 0; InputOutput.
Result<WriterInput> GatherWriterInput(const RankGroup& ranks, WriterInput own);

}
