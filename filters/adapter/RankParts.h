// SPDX-License-Identifier: BSD-3-Clause
// What the ranks of a group have of a mesh, in one place.
#pragma once

#include "filters/adapter/RankGroup.h"
#include "filters/core/Result.h"

#include <vtkDataObject.h>
#include <vtkPartitionedDataSet.h>
#include <vtkSmartPointer.h>

#include <string>
#include <vector>

namespace kdstream
{

struct GatheredParts
{
  vtkSmartPointer<vtkPartitionedDataSet> parts;
  bool areSame = false; // at rank 0: whether all ranks have the same, and any
};

// At rank 0 the vtkPolyData of all ranks, one rank's after the other's, as they are: each rank's
// own or, of a composite data set, its blocks in their order. At other ranks nothing. Arrays that
// are no numbers stay behind, and are listed. ready: what is wrong with this rank otherwise.
// O(size). Errors, of all ranks: that of a rank that is not ready; InvalidInput for a block that is
// no vtkPolyData, unless it has no points; InputOutput.
Result<GatheredParts> GatherParts(const RankGroup& ranks, const Status& ready, vtkDataObject& input,
  std::vector<std::string>& leftOut);

}
