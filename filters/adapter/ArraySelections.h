// SPDX-License-Identifier: BSD-3-Clause
// The arrays that a reader offers: which of a file's are read.
#pragma once

#include "filters/core/Attribute.h"

#include <vtkDataArraySelection.h>

#include <span>

namespace kdstream
{

// One selection for arrays of points, one for arrays of cells. They outlive this.
class ArraySelections
{
public:
  ArraySelections(vtkDataArraySelection& points, vtkDataArraySelection& cells)
    : Points(points)
    , Cells(cells)
  {
  }

  // Names the arrays of the file and no others. What has been chosen of them stays; new ones are
  // enabled.
  void Follow(std::span<const AttributeInfo> arrays) const;
  bool IsWanted(const AttributeInfo& array) const
  {
    return this->Of(array.association).ArrayIsEnabled(array.name.c_str()) != 0;
  }

private:
  vtkDataArraySelection& Of(AttributeAssociation association) const
  {
    return association == AttributeAssociation::Point ? this->Points : this->Cells;
  }

  vtkDataArraySelection& Points;
  vtkDataArraySelection& Cells;
};

}
