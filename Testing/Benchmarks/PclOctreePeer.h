// SPDX-License-Identifier: BSD-3-Clause
// PCL's octree as a peer of ours: built apart, since PCL's options and headers stay out of ours.
#pragma once

#include "filters/core/Types.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace kdstream::bench
{

struct PclOctree
{
  double seconds = 0; // to build, from points that PCL holds already
  std::size_t leaves = 0;
};

// Builds pcl::octree::OctreePointCloudPointVector, which splits leaves of more than `most` points.
// REQUIRES: points.
PclOctree TimePclOctree(std::span<const Vec3> points, std::uint32_t most);

}
