// SPDX-License-Identifier: BSD-3-Clause
// Makes one level from any clustering of the vertices, for comparing the octree and k-means with
// the k-d tree.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/core/levels/ClusterLevels.h"
#include "filters/core/tree/Clustering.h"

#include <vector>

namespace kdstream
{

// One level of a mesh: a representative for each cluster, or for each component of the surface in
// it, and the image of the triangles. See the finest level of BuildClusterLevels; this works for
// any clusters. `lowest`, `parents` and coarser levels have no meaning here. clusterOf, if not
// null: the representative of each vertex. Errors: InvalidArgument if the clustering does not fit
// the mesh's vertices (CheckClustering); Cancelled. Source: paper 4.3, Figs. 12-14.
Result<ClusterLevel> SimplifyByClusters(const Mesh& mesh, const Clustering& clustering,
  const ClusterOptions& options, const Execution& execution = {},
  std::vector<VertexId>* clusterOf = nullptr);

}
