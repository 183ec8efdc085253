// SPDX-License-Identifier: BSD-3-Clause
// Reads the parts of a mesh, as VTK has them, without ghosts: the first step of JoinPolyData and
// ShareMesh.
#pragma once

#include "filters/adapter/MergePoints.h"
#include "filters/adapter/SharedArrays.h"
#include "filters/core/Execution.h"
#include "filters/core/Result.h"

#include <vtkDataObject.h>
#include <vtkPolyData.h>

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace kdstream
{

// A vtkPolyData that is input, or a block of it.
struct InputPart
{
  vtkPolyData* mesh;
  std::string name; // for errors: "partition 3", "block 7"; empty: the input itself
};

// A vtkPolyData, or those of a composite data set that have points. Other blocks must be null or
// without points. Errors: InvalidInput, naming the block that is not a vtkPolyData, or has cells of
// points that are not there.
Result<std::vector<InputPart>> PartsOf(vtkDataObject& input);

// Whether vtkGhostType marks a point or a cell as not the part's own.
bool HasGhosts(vtkPolyData& part);

// The cells of one kind that stay.
struct KeptCells
{
  std::vector<TupleOfPart> from;
  std::vector<std::size_t> begin{ 0 }; // of each cell in `corners`, and the end
  std::vector<VertexId> corners;       // points of all parts, one after the other
};

struct PartsRead
{
  PartPoints points;                         // ids and hashOfArrays are left to the caller
  std::array<KeptCells, 4> cells;            // vertices, lines, polygons, strips
  std::vector<PartData> pointData, cellData; // of each part; of cells that counts where any stay
  bool areFloats = true;                     // whether all parts' points are

  TupleOfPart TupleOf(VertexId point) const;
};

// Drops the cells and points that JoinPolyData.h lists. Errors: InvalidInput for a coordinate that
// is not finite, or a cell that uses a point that is not there, naming the part; LimitExceeded.
Result<PartsRead> ReadParts(const std::vector<InputPart>& parts, const Execution& execution);

}
