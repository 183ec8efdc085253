// SPDX-License-Identifier: BSD-3-Clause
// Counts triangles of levels that face the wrong way. If back faces are culled, they are visible as
// dark specks.
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
  // Triangles that face away from their reference. A triangle of a level is the image of one or
  // several original triangles (its own), and its corners are three clusters. The reference is the
  // sum of the area vectors of its own original triangles, and of all original triangles that touch
  // one of the three clusters, once for each cluster. A cluster is left out if its triangles face
  // all directions: the sum of their area vectors is less than a quarter of their area, as for both
  // sides of a thin wall or for a whole limb. A triangle is opposed if it has an area and its
  // normal is more than a right angle away from the reference.
  std::size_t opposed = 0;
  double opposedArea = 0; // share of the level's area
  // The same with another reference: the normal of the original vertex nearest to the triangle's
  // centre, which is the sum of the area vectors around that vertex. Misleading at thin walls.
  std::size_t opposedNearest = 0;
};

// Counts fold-overs for each level, [depth]; 0 for levels that do not exist.
std::vector<FoldOverCount> CountFoldOvers(const Mesh& mesh, const ClusterLevels& levels);

}
