// SPDX-License-Identifier: BSD-3-Clause
#include "filters/build/PartitionMesh.h"

#include "filters/core/tree/Clustering.h"
#include "filters/core/tree/KMeansClustering.h"
#include "filters/core/tree/OctreeClustering.h"

namespace kdstream
{
namespace
{

// A clustering as a tree, or why there is none.
template <class C>
Result<PartitionTree> TreeOf(const Mesh& mesh, const Result<C>& clustering)
{
  KDSTREAM_TRY(clustering);
  return PartitionTree{ TreeOfClustering(mesh.points, *clustering), clustering->clusters };
}

}

std::string_view NameOf(Partitioner partitioner)
{
  switch (partitioner)
  {
    case Partitioner::Octree:
      return "octree";
    case Partitioner::KMeans:
      return "kmeans";
    default:
      return "kdtree";
  }
}

Result<PartitionTree> PartitionMesh(const Mesh& mesh, Partitioner partitioner,
  const KdTreeOptions& options, const Execution& execution)
{
  if (partitioner == Partitioner::KdTree)
  {
    Result<KdTree> tree = BuildKdTree(mesh.points, options, execution);
    KDSTREAM_TRY(tree);
    const std::uint64_t partitions = std::uint64_t{ 1 } << tree->depths.partition;
    return PartitionTree{ std::move(*tree), partitions };
  }
  if (partitioner == Partitioner::Octree)
  {
    return TreeOf(mesh, ClusterByOctree(mesh.points,
                          { options.verticesPerPartition, options.partitions }, execution));
  }
  KMeansOptions kmeans;
  kmeans.verticesPerPartition = options.verticesPerPartition;
  kmeans.partitions = options.partitions;
  return TreeOf(mesh, ClusterByKMeans(mesh.points, mesh.triangles, kmeans, execution));
}

}
