// SPDX-License-Identifier: BSD-3-Clause
// Processes blocks one after the other, and loads the next one meanwhile.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"

#include <cstddef>
#include <optional>
#include <utility>

namespace kdstream
{

// Calls use(item) for the items 0 … count - 1, in order; load(i) -> Result<Item> loads each. While
// an item is used, the next one is loaded, if the execution has a thread for it. `use` may run on
// another thread than the caller's, but never twice at the same time. Memory: two items. Errors:
// those of `load` and `use`; the first in the order of the items.
template <class Load, class Use>
Status ForEachLoaded(
  std::size_t count, const Load& load, const Use& use, const Execution& execution)
{
  using Loaded = decltype(load(std::size_t{}));
  std::optional<Loaded> next;
  if (count > 0)
  {
    next.emplace(load(0));
  }
  for (std::size_t i = 0; i < count; ++i)
  {
    if (!*next)
    {
      return next->GetError();
    }
    Loaded current = std::move(*next);
    next.reset();
    Status used;
    const auto step = [&](std::size_t which)
    {
      if (which == 0)
      {
        used = use(*current);
      }
      else if (i + 1 < count)
      {
        next.emplace(load(i + 1));
      }
    };
    execution.parallelFor(2, 1,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t which = begin; which < end; ++which)
        {
          step(which);
        }
      });
    KDSTREAM_TRY(used);
  }
  return {};
}

}
