// SPDX-License-Identifier: BSD-3-Clause
// Step b of k-means clustering (KMeansClustering.cxx): the first seeds. For KMeansClustering alone.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/core/tree/KMeansSurface.h"

#include <cstdint>
#include <vector>

namespace kdstream
{

// A seed for each of so many clusters, all different, as KMeansClustering.h says. Errors:
// Cancelled.
Result<std::vector<VertexId>> SpreadSeeds(
  const KMeansSurface& surface, std::uint32_t clusters, const Execution& execution);

}
