#include "filters/core/tree/PieceDepth.h"

#include <algorithm>

namespace kdstream
{

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
