// SPDX-License-Identifier: BSD-3-Clause
#include "filters/adapter/ArraySelections.h"

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
    this->Of(array.association).AddArray(array.name.c_str()); // none twice; enabled
  }
}

}
