// SPDX-License-Identifier: BSD-3-Clause
// Setters for numbers with a range, and for vectors; to be used in the source of a class.
#pragma once

#include <vtkObject.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <type_traits>

namespace kdstream
{

// Clamps as vtkSetClampMacro does. But NaN, or a negative value below the range, is an error, and
// the member does not change.
template <class Number>
void SetInRange(vtkObject& object, const char* name, Number& member,
  std::type_identity_t<Number> value, std::type_identity_t<Number> least,
  std::type_identity_t<Number> most)
{
  if (value != value || (value < 0 && value < least))
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

// Like vtkSetVector3Macro; but a value that is not finite is an error, and the member does not
// change.
inline void SetFinite(
  vtkObject& object, const char* name, double (&member)[3], double x, double y, double z)
{
  if (!std::isfinite(x) || !std::isfinite(y) || !std::isfinite(z))
  {
    vtkErrorWithObjectMacro(&object, << name << " must be finite, not (" << x << ", " << y << ", "
                                     << z << "): it stays (" << member[0] << ", " << member[1]
                                     << ", " << member[2] << ")");
    return;
  }
  const double value[] = { x, y, z };
  if (!std::equal(std::begin(value), std::end(value), member))
  {
    std::copy(std::begin(value), std::end(value), member);
    object.Modified();
  }
}

}

#define KDSTREAM_SET_IN_RANGE(Class, Name, Type, least, most)           \
  void Class::Set##Name(Type value)                                     \
  {                                                                     \
    kdstream::SetInRange(*this, #Name, this->Name, value, least, most); \
  }

#define KDSTREAM_SET_FINITE(Class, Name)                    \
  void Class::Set##Name(double x, double y, double z)       \
  {                                                         \
    kdstream::SetFinite(*this, #Name, this->Name, x, y, z); \
  }                                                         \
  void Class::Set##Name(const double value[3])              \
  {                                                         \
    this->Set##Name(value[0], value[1], value[2]);          \
  }
