// SPDX-License-Identifier: BSD-3-Clause
// Joins the parts of a mesh on all ranks of a group into shares of one mesh. No rank gets much more
// than it had.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/ranks/RankGroup.h"

#include <vtkDataObject.h>

#include <string>
#include <vector>

namespace kdstream
{

struct MeshShare
{
  Mesh mesh;                        // corners are numbers in the mesh of all ranks
  std::vector<std::string> leftOut; // e.g. `point array "A": not all parts have it`
  bool areSame = false;             // whether all ranks have the same input, and it is not empty
};

// Called by all ranks. input: as for JoinPolyData. The shares of rank 0, rank 1, … together are the
// mesh that one process would get by JoinPolyData, ReadMesh and ReadAttributes of all parts: the
// same points (merged by global ids, as copies or by place), order and arrays. All shares have the
// same arrays and the same scalar type. Without ids a share consists of the rank's own data. With
// ids it is an interval of ids, with at most 5 / 4 of the average for any ids. ready: an earlier
// error of this rank, or success. Exceptions are not caught: RankGroup::Run reports them.
//
// O(n log n) for the n points and corners of a rank. Each point is sent to another rank once (56
// bytes), and once more if there are ids. Memory: 250 bytes for each point that the rank has or
// receives, and its arrays twice. Errors, the same on all ranks: that of a rank that is not ready;
// those of JoinPolyData and ReadElements; InputOutput.
Result<MeshShare> ShareMesh(RankGroup& ranks, const Status& ready, vtkDataObject& input,
  bool weldByPlace, const Execution& execution);

}
