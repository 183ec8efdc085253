// SPDX-License-Identifier: BSD-3-Clause
// Reads the parts of a mesh from VTK, without ghosts: the first step of JoinPolyData and ShareMesh.
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

// A vtkPolyData that is the input, or a block of it.
struct InputPart
{
  vtkPolyData* mesh;
  std::string name; // for errors: "partition 3", "block 7"; empty: the input itself
};

// The input itself if it is a vtkPolyData; of a composite data set, the blocks that have points.
// Other blocks must be null or without points. Errors: InvalidInput, naming the block, if it is not
// a vtkPolyData, or has cells that use missing points.
Result<std::vector<InputPart>> PartsOf(vtkDataObject& input);

// Whether vtkGhostType marks any point or cell as not belonging to the part.
bool HasGhosts(vtkPolyData& part);

// The cells of one kind that stay.
struct KeptCells
{
  std::vector<TupleOfPart> from;
  std::vector<std::size_t> begin{ 0 }; // index in `corners` where each cell begins, and the end
  std::vector<VertexId> corners;       // numbers count the points of all parts, one part after the
                                       // other
};

struct PartsRead
{
  PartPoints points;                         // the caller fills in ids and hashOfArrays
  std::array<KeptCells, 4> cells;            // vertices, lines, polygons, strips
  std::vector<PartData> pointData, cellData; // of each part; parts without remaining cells do not
                                             // count for cells
  bool areFloats = true;                     // whether the points of all parts are floats

  TupleOfPart TupleOf(VertexId point) const;
};

// Drops the cells and points that JoinPolyData.h lists. Errors: InvalidInput, naming the part, for
// a coordinate that is not finite, or a cell that uses a missing point; LimitExceeded.
Result<PartsRead> ReadParts(const std::vector<InputPart>& parts, const Execution& execution);

}
