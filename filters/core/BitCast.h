// SPDX-License-Identifier: BSD-3-Clause
// std::bit_cast, which emscripten's C++ library does not have yet; and the bytes of numbers.
#pragma once

#include <algorithm>
#include <bit>
#include <cstring>
#include <string>
#include <type_traits>

namespace kdstream
{

// The same bits as another type of the same size.
template <class To, class From>
To BitCast(const From& from)
{
  static_assert(sizeof(To) == sizeof(From) && std::is_trivially_copyable_v<To> &&
                std::is_trivially_copyable_v<From>);
  To to;
  std::memcpy(&to, &from, sizeof(to));
  return to;
}

// Appends a number in little-endian order on any machine.
template <class T>
void AppendNumber(std::string& bytes, T value)
{
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if constexpr (std::endian::native == std::endian::big)
  {
    std::reverse(raw, raw + sizeof(T));
  }
  bytes.append(raw, sizeof(T));
}

}
