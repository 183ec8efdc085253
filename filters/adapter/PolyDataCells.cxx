// SPDX-License-Identifier: BSD-3-Clause
#include "filters/adapter/PolyDataCells.h"

namespace kdstream
{

Status CheckOffsets(vtkCellArray& cells, vtkIdType firstCell)
{
  if (cells.GetNumberOfCells() < 0)
  {
    return Error{ ErrorCode::InvalidInput, "a cell array has no offsets; it needs at least one" };
  }
  Status status;
  cells.Visit(
    [&](auto& storage)
    {
      const auto* const offsets = storage.GetOffsets()->GetPointer(0);
      const auto corners = storage.GetConnectivity()->GetNumberOfValues();
      for (vtkIdType i = 0; i < storage.GetNumberOfCells(); ++i)
      {
        if (offsets[i] < 0 || offsets[i] > offsets[i + 1] || offsets[i + 1] > corners)
        {
          status = Error{ ErrorCode::InvalidInput, "cell " + std::to_string(firstCell + i) +
                                                     " uses corners " + std::to_string(offsets[i]) +
                                                     " to " + std::to_string(offsets[i + 1]) +
                                                     " of a list of " + std::to_string(corners) };
          return;
        }
      }
    });
  return status;
}

}
