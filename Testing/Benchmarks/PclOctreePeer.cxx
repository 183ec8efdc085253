// SPDX-License-Identifier: BSD-3-Clause
#define PCL_NO_PRECOMPILE // the octree of leaves with point vectors is not in PCL's libraries
#include <pcl/octree/octree_pointcloud_pointvector.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include "Testing/Benchmarks/PclOctreePeer.h"

#include <algorithm>
#include <chrono>

namespace kdstream::bench
{

PclOctree TimePclOctree(std::span<const Vec3> points, std::uint32_t most)
{
  Box box;
  const auto cloud = std::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (const Vec3& p : points)
  {
    box.Add(p);
    cloud->emplace_back(
      static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2]));
  }
  double side = 0;
  for (std::size_t k = 0; k < 3; ++k)
  {
    side = std::max(side, box.hi[k] - box.lo[k]);
  }
  const auto start = std::chrono::steady_clock::now();
  // The resolution is the size of the smallest cell; leaves are as deep as their points require.
  pcl::octree::OctreePointCloudPointVector<pcl::PointXYZ> octree(side / (1 << 16));
  octree.setInputCloud(cloud);
  octree.defineBoundingBox();
  octree.enableDynamicDepth(most);
  octree.addPointsFromInputCloud();
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  return { seconds.count(), octree.getLeafCount() };
}

}
