// SPDX-License-Identifier: BSD-3-Clause
// Setters of numbers that have a range, for the source of a class.
#pragma once

#include <vtkObject.h>

#include <algorithm>
#include <type_traits>

namespace kdstream
{

// Clamps as vtkSetClampMacro does; but refuses what is not a number, and what is negative where the
// range begins at 0 or above: an error, and the member stays.
template <class Number>
void SetInRange(vtkObject& object, const char* name, Number& member,
  std::type_identity_t<Number> value, std::type_identity_t<Number> least,
  std::type_identity_t<Number> most)
{
  if (value != value || (value < 0 && least >= 0))
  {
    vtkErrorWithObjectMacro(&object, << name << " must be from " << least << " to " << most
                                     << ", not " << value << ": it stays " << member);
    return;
  }
  const Number clamped = std::clamp(value, least, most);
  if (clamped != member)
  {
    member = clamped;
    object.Modified();
  }
}

}

#define KDSTREAM_SET_IN_RANGE(Class, Name, Type, least, most)           \
  void Class::Set##Name(Type value)                                     \
  {                                                                     \
    kdstream::SetInRange(*this, #Name, this->Name, value, least, most); \
  }
