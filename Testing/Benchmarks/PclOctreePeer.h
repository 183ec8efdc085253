// SPDX-License-Identifier: BSD-3-Clause
// PCL's octree as a peer of ours. It is built separately, so that PCL's options and headers do not
// affect our code.
#pragma once

#include "filters/core/Types.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace kdstream::bench
{

struct PclOctree
{
  double seconds = 0; // to build the tree, from points that PCL already holds
  std::size_t leaves = 0;
};

// Builds pcl::octree::OctreePointCloudPointVector, which splits leaves of more than `most` points.
// REQUIRES: points.
PclOctree TimePclOctree(std::span<const Vec3> points, std::uint32_t most);

}
