// SPDX-License-Identifier: BSD-3-Clause
// Triangles of levels that face the wrong way: what shows as dark specks where back faces are
// culled.
#pragma once

#include "filters/core/Types.h"
#include "filters/core/levels/ClusterLevels.h"

#include <cstddef>
#include <vector>

namespace kdstream::fixtures
{

// Of one level.
struct FoldOverCount
{
  std::size_t triangles = 0;
  // A triangle of a level is the image of one or several original triangles (its own), and its
  // corners are the images of the three clusters' triangles. Its reference is the sum of the area
  // vectors of its own original triangles, and of all original triangles that touch one of the
  // clusters, once for each of these; where those of a cluster point all ways (their sum is less
  // than a quarter of their area: both sides of a thin wall, a whole limb) the cluster is left out.
  // Opposed: the triangle has area, and its normal is more than a right angle away from the
  // reference.
  std::size_t opposed = 0;
  double opposedArea = 0; // of the level's area
  // The same with the normal of the original vertex that is nearest to the triangle's centre (the
  // sum of the area vectors around it) as the reference. Misleads where walls are thin.
  std::size_t opposedNearest = 0;
};

// For each level, [depth]; levels that there are none of are left at 0.
std::vector<FoldOverCount> CountFoldOvers(const Mesh& mesh, const ClusterLevels& levels);

}
