// SPDX-License-Identifier: BSD-3-Clause
// std::bit_cast, which emscripten's C++ library does not have yet.
#pragma once

#include <cstring>
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

}
