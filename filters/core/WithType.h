// SPDX-License-Identifier: BSD-3-Clause
// From the type of an attribute to the type of C++.
#pragma once

#include "filters/core/Attribute.h"

#include <cstdint>

namespace kdstream
{

// Calls function.operator()<T>() with the C++ type of `type`.
template <class Function>
decltype(auto) WithType(AttributeType type, Function&& function)
{
  switch (type)
  {
    case AttributeType::Int8:
      return function.template operator()<std::int8_t>();
    case AttributeType::UInt8:
      return function.template operator()<std::uint8_t>();
    case AttributeType::Int16:
      return function.template operator()<std::int16_t>();
    case AttributeType::UInt16:
      return function.template operator()<std::uint16_t>();
    case AttributeType::Int32:
      return function.template operator()<std::int32_t>();
    case AttributeType::UInt32:
      return function.template operator()<std::uint32_t>();
    case AttributeType::Int64:
      return function.template operator()<std::int64_t>();
    case AttributeType::UInt64:
      return function.template operator()<std::uint64_t>();
    case AttributeType::Float32:
      return function.template operator()<float>();
    case AttributeType::Float64:
      break;
  }
  return function.template operator()<double>();
}

}
