// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/levels/ForEachLoaded.h"

namespace kdstream
{

Status ForEachLoaded(LevelBlocks& blocks, std::span<const std::size_t> which,
  const std::function<Status(std::size_t)>& use, const Execution& execution)
{
  for (std::size_t i = 0; i < which.size(); ++i)
  {
    KDSTREAM_TRY(blocks.Load(which[i]));
    const std::size_t tasks = i + 1 < which.size() ? 2 : 1; // use this block, fetch the next
    Status used;
    execution.parallelFor(tasks, 1,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t task = begin; task < end; ++task)
        {
          if (task == 0)
          {
            used = use(which[i]);
          }
          else
          {
            blocks.LoadAhead(which[i + 1]);
          }
        }
      });
    KDSTREAM_TRY(used);
  }
  return {};
}

}
