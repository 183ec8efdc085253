// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/tree/PieceDepth.h"

#include <algorithm>

namespace kdstream
{
namespace
{

constexpr unsigned previewLevel = 11; // a piece of a level holds about 2^11 cells

}

unsigned PieceDepth(Resolution resolution, const TreeDepths& depths)
{
  if (resolution.IsOriginal())
  {
    return depths.partition;
  }
  const unsigned depth = resolution.Depth();
  return std::min(depths.partition, depth > previewLevel ? depth - previewLevel : 0);
}

}
