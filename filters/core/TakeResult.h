// SPDX-License-Identifier: BSD-3-Clause
// Moves the value of a result into a variable, for functions that return at the first error.
#pragma once

#include "filters/core/Result.h"

#include <utility>

namespace kdstream
{

// Moves the value into `to`, or returns the error.
template <class T>
Status Take(Result<T>&& from, T& to)
{
  KDSTREAM_TRY(from);
  to = std::move(*from);
  return {};
}

}
