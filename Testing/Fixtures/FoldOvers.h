// SPDX-License-Identifier: BSD-3-Clause
// Triangles of levels that face the wrong way: they are visible as dark specks if back faces are
// culled.
#pragma once

#include "filters/core/Types.h"
#include "filters/core/levels/ClusterLevels.h"

#include <cstddef>
#include <vector>

namespace kdstream::fixtures
{

// The fold-overs of one level.
struct FoldOverCount
{
  std::size_t triangles = 0;
  // A triangle of a level is the image of one or several original triangles (its own), and its
  // corners are the images of the three clusters' triangles. Its reference is the sum of the area
  // vectors of its own original triangles, and of all original triangles that touch one of the
  // clusters, once for each cluster. A cluster whose triangles face all ways (their sum is less
  // than a quarter of their area, as for both sides of a thin wall or a whole limb) is left out.
  // Opposed: the triangle has an area, and its normal is more than a right angle away from the
  // reference.
  std::size_t opposed = 0;
  double opposedArea = 0; // of the level's area
  // The same with another reference: the normal of the original vertex nearest to the triangle's
  // centre (the sum of the area vectors around it). Misleading at thin walls.
  std::size_t opposedNearest = 0;
};

// For each level, [depth]; 0 for levels that do not exist.
std::vector<FoldOverCount> CountFoldOvers(const Mesh& mesh, const ClusterLevels& levels);

}
