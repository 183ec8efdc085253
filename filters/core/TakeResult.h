// SPDX-License-Identifier: BSD-3-Clause
// For functions that go on as long as all is well: a result's value goes to where it is kept.
#pragma once

#include "filters/core/Result.h"

#include <utility>

namespace kdstream
{

// The value to `to`, or why there is none.
template <class T>
Status Take(Result<T>&& from, T& to)
{
  KDSTREAM_TRY(from);
  to = std::move(*from);
  return {};
}

}
