// SPDX-License-Identifier: BSD-3-Clause
// A pass over blocks of a level. Only for the makers of levels.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/levels/LevelBlocks.h"

#include <cstddef>
#include <functional>
#include <span>

namespace kdstream
{

// Loads each of these blocks and calls use(block), one block after the other. The next block is
// fetched while the current one is used. Errors: those of the blocks and of `use`.
Status ForEachLoaded(LevelBlocks& blocks, std::span<const std::size_t> which,
  const std::function<Status(std::size_t)>& use, const Execution& execution);

}
