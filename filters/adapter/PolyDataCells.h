// SPDX-License-Identifier: BSD-3-Clause
// Visits the cells of a vtkPolyData one after the other. Checks the offsets of cells and the
// numbers of points, which may have any values.
#pragma once

#include "filters/core/Result.h"

#include <vtkCellArray.h>
#include <vtkCellArrayIterator.h>
#include <vtkSmartPointer.h>

#include <cstddef>
#include <span>
#include <string>

namespace kdstream
{

// Checks that the corners of each cell are within the connectivity of the array. VTK does not check
// this: a file or vtkCellArray::SetData may contain any values. firstCell: the id of the array's
// first cell in the vtkPolyData. O(cells). Errors: InvalidInput, naming the cell.
Status CheckOffsets(vtkCellArray& cells, vtkIdType firstCell);

// Calls visit(cell, points) for each cell of one array; null is an array without cells. firstCell:
// as above. O(corners). Errors: those of CheckOffsets; InvalidInput, naming cell and point, if a
// cell uses a missing point.
template <class Visit>
Status ForEachCell(vtkCellArray* cells, vtkIdType firstCell, vtkIdType pointCount, Visit&& visit)
{
  if (!cells)
  {
    return {};
  }
  KDSTREAM_TRY(CheckOffsets(*cells, firstCell));
  const auto iterator = vtk::TakeSmartPointer(cells->NewIterator());
  for (iterator->GoToFirstCell(); !iterator->IsDoneWithTraversal(); iterator->GoToNextCell())
  {
    vtkIdType size = 0;
    const vtkIdType* points = nullptr;
    iterator->GetCurrentCell(size, points);
    const vtkIdType cell = firstCell + iterator->GetCurrentCellId();
    const std::span<const vtkIdType> corners(points, static_cast<std::size_t>(size));
    for (const vtkIdType point : corners)
    {
      if (point < 0 || point >= pointCount)
      {
        return Error{ ErrorCode::InvalidInput, "cell " + std::to_string(cell) + " uses point " +
                                                 std::to_string(point) + ", but there are " +
                                                 std::to_string(pointCount) };
      }
    }
    visit(cell, corners);
  }
  return {};
}

}
