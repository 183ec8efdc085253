// SPDX-License-Identifier: BSD-3-Clause
// Chooses the level that a filter's parameters request, and makes it with core. No VTK here.
#pragma once

#include "filters/core/levels/Levels.h"
#include "filters/core/levels/SimplifyByClusters.h"
#include "filters/core/tree/Clustering.h"

#include <optional>
#include <vector>

namespace kdstream
{

struct SimplificationOptions
{
  KdTreeOptions tree;
  LevelOptions levels;
  // The depth of the level; nothing = the finest. Not used with a target or with clusters.
  std::optional<unsigned> depth;
  // The number of triangles, or of points if the mesh has no triangles; 0 = by depth. Not used with
  // clusters.
  std::size_t target = 0;
};

struct SimplifiedLevel
{
  ClusterLevel level;
  std::vector<VertexId> clusterOf; // for each vertex of the mesh
  unsigned finestDepth = 0;        // of the tree
};

// Makes the level of a mesh, which must have at least one point. By depth: that level. By target:
// LevelMaker::Collapse continues from the next finer level until the target is reached;
// LevelMaker::Cluster, and point clouds, give the level with the nearest number (if two are as
// near, the coarser one). Complexity and errors: BuildLevels, CollapseTo; InvalidArgument for a
// depth below the finest level.
Result<SimplifiedLevel> SimplifyMesh(
  const Mesh& mesh, const SimplificationOptions& options, const Execution& execution);

}
