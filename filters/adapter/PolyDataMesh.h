// SPDX-License-Identifier: BSD-3-Clause
// A vtkPolyData in core's types: the first step of every VTK filter here.
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

// The cells of a vtkPolyData, cut into single vertices, line segments and triangles, in this order.
// Polygons are cut as core/CutPolygon.h says, strips become triangles of alternating orientation;
// degenerate triangles stay. Cells with too few points give no elements.
struct PolyDataElements
{
  std::vector<Triangle> corners; // a vertex is {a, a, a}, a segment {a, b, b}
  std::vector<vtkIdType> cells;  // for each element the input's cell that it is part of
  std::size_t vertices = 0;      // how many of the elements are vertices,
  std::size_t segments = 0;      // and segments

  std::span<const Triangle> Triangles() const
  {
    return std::span(this->corners).subspan(this->vertices + this->segments);
  }
};

// The points as doubles. All must be finite, unless `any` is set. O(n), 24 bytes a point. Errors:
// InvalidInput naming the point that is not finite; LimitExceeded.
Result<std::vector<Vec3>> ReadPoints(
  vtkPolyData& input, const Execution& execution, bool any = false);

// O(cells), 20 bytes an element. Errors: InvalidInput naming the cell whose corners are not in its
// array, or the cell and point where a cell uses a point that is not there; LimitExceeded.
Result<PolyDataElements> ReadElements(vtkPolyData& input);

// The errors of ReadElements about cells, without reading them. O(cells).
Status CheckCells(vtkPolyData& input);

// Labels: one whole number for each of `points` points, exact whatever the array's type. O(n).
// Errors: InvalidInput naming the array, and the point whose value is not a whole number (floats
// and doubles: beyond 2^53 too).
Result<std::vector<std::int64_t>> ReadLabels(vtkDataArray& array, vtkIdType points);

// Makes core's mesh: points and triangles; vertex and line cells are left out. Errors: those of
// ReadPoints and ReadElements.
Result<Mesh> ReadMesh(vtkPolyData& input, const Execution& execution, bool any = false);

}
