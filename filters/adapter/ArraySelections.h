// SPDX-License-Identifier: BSD-3-Clause
// The arrays that a reader offers: which of them are read, and their entries in the output
// information.
#pragma once

#include "filters/core/Attribute.h"

#include <vtkDataArraySelection.h>
#include <vtkInformation.h>
#include <vtkType.h>

#include <functional>
#include <optional>
#include <span>
#include <utility>

namespace kdstream
{

// Facts about the arrays of an output that are known before it is read.
struct ArrayFacts
{
  std::optional<vtkIdType> points, cells; // numbers of tuples
  // The smallest and the largest value of an array; nothing if not known.
  std::function<std::optional<std::pair<double, double>>(const AttributeInfo&)> rangeOf;
};

// One selection for point arrays, one for cell arrays. The selections must outlive this object.
class ArraySelections
{
public:
  ArraySelections(vtkDataArraySelection& points, vtkDataArraySelection& cells)
    : Points(points)
    , Cells(cells)
  {
  }

  // Lists exactly the arrays of the file. An array that was already listed keeps its setting; new
  // arrays are enabled.
  void Follow(std::span<const AttributeInfo> arrays) const;
  bool IsWanted(const AttributeInfo& array) const
  {
    return this->Of(array.association).ArrayIsEnabled(array.name.c_str()) != 0;
  }
  // Sets POINT_DATA_VECTOR and CELL_DATA_VECTOR of vtkDataObject: an entry for each enabled array.
  void Tell(
    std::span<const AttributeInfo> arrays, const ArrayFacts& facts, vtkInformation& output) const;

private:
  vtkDataArraySelection& Of(AttributeAssociation association) const
  {
    return association == AttributeAssociation::Point ? this->Points : this->Cells;
  }

  vtkDataArraySelection& Points;
  vtkDataArraySelection& Cells;
};

}
