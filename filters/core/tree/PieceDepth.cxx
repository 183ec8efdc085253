// SPDX-License-Identifier: BSD-3-Clause
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
  return std::min(depths.partition, depth > depths.onePiece ? depth - depths.onePiece : 0);
}

unsigned PreviewLevel(const TreeDepths& depths)
{
  return std::min(depths.finest, depths.onePiece);
}

AncestorLevels AncestorLevelsOf(Resolution resolution, const TreeDepths& depths)
{
  const bool own = resolution <= Resolution::Level(depths.stitch);
  const unsigned coarsest = PreviewLevel(depths);
  const unsigned end = own ? resolution.Depth() : depths.stitch;
  return { coarsest, end > coarsest ? end - coarsest : 0, own };
}

bool HasChildNodes(Resolution resolution, const TreeDepths& depths)
{
  return resolution >= Resolution::Level(PreviewLevel(depths)) &&
         resolution < Resolution::Level(depths.stitch);
}

}
