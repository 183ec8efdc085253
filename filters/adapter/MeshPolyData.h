// SPDX-License-Identifier: BSD-3-Clause
// A mesh of core's as vtkPolyData: the way back from PolyDataMesh.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"

#include <vtkPolyData.h>

#include <cstddef>
#include <functional>
#include <string>

namespace kdstream
{

// Fills an empty vtkPolyData with points (float or double, like the mesh's), triangles, and the
// arrays that `isWanted` takes (WriteAttributes). A cloud gets a vertex cell for each of its first
// `cloudCells` points. O(size); "fill" is reported every 2^18 points and triangles.
// Errors: Cancelled; those of WriteAttributes, with only points and cells filled in.
Status FillPolyData(const Mesh& mesh, std::size_t cloudCells,
  const std::function<bool(const AttributeInfo&)>& isWanted, vtkPolyData& output,
  const Execution& execution = {});

}
