// SPDX-License-Identifier: BSD-3-Clause
// Counts the vertices of each cluster, for the tests of the baselines.
#pragma once

#include "filters/core/tree/Clustering.h"

#include <cstdint>
#include <vector>

namespace kdstream
{

inline std::vector<std::uint32_t> SizesOf(const Clustering& clustering)
{
  std::vector<std::uint32_t> sizes(clustering.clusters, 0);
  for (const std::uint32_t c : clustering.clusterOf)
  {
    ++sizes.at(c);
  }
  return sizes;
}

}
