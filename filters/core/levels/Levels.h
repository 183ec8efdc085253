// SPDX-License-Identifier: BSD-3-Clause
// Levels of detail of a mesh: chooses their maker. Step "levels" of the pipeline picture.
#pragma once

#include "filters/core/levels/ClusterLevels.h"

namespace kdstream
{

enum class LevelMaker
{
  Collapse, // the finest level by clusters, coarser ones by rounds of edge collapse
  Cluster   // all by clusters of cells; the paper's method if Representative::Mean, one a cell
};

struct LevelOptions : ClusterOptions
{
  LevelMaker maker = LevelMaker::Collapse;
};

// Builds the levels L … options.coarsestDepth of a mesh with the maker that the options name; a
// mesh without triangles always with clusters. Input and errors: see BuildClusterLevels and
// BuildCollapseLevels. The levels carry the means of normals and colours (AddLevelAttributes).
Result<ClusterLevels> BuildLevels(const Mesh& mesh, const KdTree& tree,
  const TriangleBuckets& partitionTriangles, const LevelOptions& options,
  const Execution& execution = {});

}
