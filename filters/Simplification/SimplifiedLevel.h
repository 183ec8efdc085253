// SPDX-License-Identifier: BSD-3-Clause
// Chooses which level of a mesh a filter is asked for, and makes it: between the filter's
// parameters and core. No VTK here.
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
  // The depth of the level; nothing = the finest. Not used with a target or clusters.
  std::optional<unsigned> depth;
  // Triangles, or points where the mesh has no triangles; 0 = by depth. Not used with clusters.
  std::size_t target = 0;
};

struct SimplifiedLevel
{
  ClusterLevel level;
  std::vector<VertexId> clusterOf; // of each vertex of the mesh
  unsigned finestDepth = 0;        // of the tree
};

// The level of a mesh with at least one point. By depth: that level. By target:
// LevelMaker::Collapse continues from the next finer level until the target is reached;
// LevelMaker::Cluster, and point clouds, give the level whose number is nearest (of two, the
// coarser). Complexity and errors: BuildLevels, CollapseTo; InvalidArgument for a depth below the
// finest.
Result<SimplifiedLevel> SimplifyMesh(
  const Mesh& mesh, const SimplificationOptions& options, const Execution& execution);

}
