// SPDX-License-Identifier: BSD-3-Clause
// One level by any clustering of the vertices: the octree's and k-means' meshes beside the k-d
// tree's.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/core/levels/ClusterLevels.h"
#include "filters/core/tree/Clustering.h"

#include <vector>

namespace kdstream
{

// One level of a mesh: a representative for each cluster, or for each sheet of the surface in it,
// and the image of the triangles. As the finest level of BuildClusterLevels, which see, but for any
// clusters. `lowest`, `parents` and coarser levels have no meaning to the caller here.
// clusterOf, where it is not null: of each vertex its representative. Errors: InvalidArgument where
// the clustering is not one of the mesh's vertices; Cancelled. Source: paper 4.3, Figs. 12-14.
Result<ClusterLevel> SimplifyByClusters(const Mesh& mesh, const Clustering& clustering,
  const ClusterOptions& options, const Execution& execution = {},
  std::vector<VertexId>* clusterOf = nullptr);

}
