// SPDX-License-Identifier: BSD-3-Clause
// Converts a mesh of core to vtkPolyData: the inverse of PolyDataMesh.
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

// Fills an empty vtkPolyData with points (float or double, as in the mesh), triangles, and the
// arrays that `isWanted` accepts (WriteAttributes). For a cloud, each of its first `cloudCells`
// points gets a vertex cell. O(size); reports "fill" every 2^18 points and triangles. Errors:
// Cancelled; those of WriteAttributes, after which only points and cells are filled in.
Status FillPolyData(const Mesh& mesh, std::size_t cloudCells,
  const std::function<bool(const AttributeInfo&)>& isWanted, vtkPolyData& output,
  const Execution& execution = {});

}
