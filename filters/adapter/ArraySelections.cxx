// SPDX-License-Identifier: BSD-3-Clause
#include "filters/adapter/ArraySelections.h"

#include "filters/adapter/PolyDataAttributes.h"

#include <vtkDataObject.h>
#include <vtkInformationDoubleVectorKey.h>
#include <vtkInformationInformationVectorKey.h>
#include <vtkInformationIntegerKey.h>
#include <vtkInformationStringKey.h>
#include <vtkInformationVector.h>
#include <vtkNew.h>

#include <algorithm>
#include <string>

namespace kdstream
{

void ArraySelections::Follow(std::span<const AttributeInfo> arrays) const
{
  for (const auto association : { AttributeAssociation::Point, AttributeAssociation::Cell })
  {
    vtkDataArraySelection& selection = this->Of(association);
    for (int i = selection.GetNumberOfArrays(); i-- > 0;)
    {
      const std::string name = selection.GetArrayName(i);
      const auto isIt = [&](const AttributeInfo& array)
      { return array.association == association && array.name == name; };
      if (std::none_of(arrays.begin(), arrays.end(), isIt))
      {
        selection.RemoveArrayByName(name.c_str());
      }
    }
  }
  for (const AttributeInfo& array : arrays)
  {
    // The array is then enabled. If it is listed already, this does nothing.
    this->Of(array.association).AddArray(array.name.c_str());
  }
}

void ArraySelections::Tell(
  std::span<const AttributeInfo> arrays, const ArrayFacts& facts, vtkInformation& output) const
{
  vtkNew<vtkInformationVector> ofPoints, ofCells;
  for (const AttributeInfo& array : arrays)
  {
    if (!this->IsWanted(array))
    {
      continue;
    }
    const bool isPoint = array.association == AttributeAssociation::Point;
    vtkNew<vtkInformation> reported;
    reported->Set(vtkDataObject::FIELD_NAME(), array.name.c_str());
    reported->Set(vtkDataObject::FIELD_ARRAY_TYPE(), VtkTypeOf(array));
    reported->Set(vtkDataObject::FIELD_NUMBER_OF_COMPONENTS(), array.components);
    const std::optional<vtkIdType> tuples = isPoint ? facts.points : facts.cells;
    if (tuples && *tuples <= VTK_INT_MAX)
    {
      reported->Set(vtkDataObject::FIELD_NUMBER_OF_TUPLES(), static_cast<int>(*tuples));
    }
    if (const auto range = facts.rangeOf ? facts.rangeOf(array) : std::nullopt)
    {
      const double ends[] = { range->first, range->second };
      reported->Set(vtkDataObject::FIELD_RANGE(), ends, 2);
    }
    (isPoint ? ofPoints : ofCells)->Append(reported);
  }
  output.Set(vtkDataObject::POINT_DATA_VECTOR(), ofPoints);
  output.Set(vtkDataObject::CELL_DATA_VECTOR(), ofCells);
}

}
