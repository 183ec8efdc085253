// SPDX-License-Identifier: BSD-3-Clause
// Converts a vtkPolyData to core's types: the first step of every VTK filter here.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"

#include <vtkDataArray.h>
#include <vtkPolyData.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// The cells of a vtkPolyData, split into single vertices, line segments and triangles, in this
// order. Polygons are cut as in core/CutPolygon.h. Strips become triangles of alternating
// orientation; degenerate triangles stay. Cells with too few points give no elements.
struct PolyDataElements
{
  std::vector<Triangle> corners; // a vertex is {a, a, a}, a segment {a, b, b}
  std::vector<vtkIdType> cells;  // the input cell that each element is part of
  std::size_t vertices = 0;      // how many of the elements are vertices
  std::size_t segments = 0;      // how many are segments

  std::span<const Triangle> Triangles() const
  {
    return std::span(this->corners).subspan(this->vertices + this->segments);
  }
};

// The points as doubles. All must be finite, unless `any` is set. O(n), 24 bytes a point. Errors:
// InvalidInput, naming the point that is not finite; LimitExceeded.
Result<std::vector<Vec3>> ReadPoints(
  vtkPolyData& input, const Execution& execution, bool any = false);

// Reads and splits the cells. O(cells), 20 bytes an element. Errors: InvalidInput, naming the cell,
// if its corners are not in its array; naming cell and point if it uses a missing point;
// LimitExceeded.
Result<PolyDataElements> ReadElements(vtkPolyData& input);

// Finds the errors about cells that ReadElements would report, without reading the cells. O(cells).
Status CheckCells(vtkPolyData& input);

// Reads labels: a whole number for each of `points` points, exactly, whatever the array's type.
// O(n). Errors: InvalidInput, naming the array, and the point whose value is not a whole number
// (or, in floats and doubles, is beyond 2^53).
Result<std::vector<std::int64_t>> ReadLabels(vtkDataArray& array, vtkIdType points);

// Makes a mesh of core: points and triangles; vertex and line cells are omitted. Errors: those of
// ReadPoints and ReadElements.
Result<Mesh> ReadMesh(vtkPolyData& input, const Execution& execution, bool any = false);

}
