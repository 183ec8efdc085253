// SPDX-License-Identifier: BSD-3-Clause
// Finest clusters that hold vertices in the same place become one: where vertices are split, at
// texture seams and hard edges, levels would open slits between them. For the makers of levels
// alone.
#pragma once

#include "filters/core/levels/FinestClusters.h"

namespace kdstream
{

// Joins the clusters of one partition that finest.coincident links; clusters of different
// partitions stay apart, since a cluster may not lie in both. A joined cluster is at home in the
// cell of its lowest vertex. Adjusts all of `finest` but the level and the links.
// cellsBelowPartition: how many depths the finest cells are below the partitions. O(clusters +
// links).
void JoinCoincidentClusters(FinestClusters& finest, unsigned cellsBelowPartition);

}
