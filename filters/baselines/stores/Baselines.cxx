// SPDX-License-Identifier: BSD-3-Clause
// The baselines that work in memory, and the names of all methods: see Baselines.h.
#include "filters/baselines/stores/Baselines.h"

#include "filters/baselines/KMeansClustering.h"
#include "filters/baselines/OctreeClustering.h"
#include "filters/baselines/stores/OctreeStore.h"
#include "filters/core/tree/Clustering.h"

#include <utility>

namespace kdstream
{
namespace
{

// The clustering as a tree, or its error.
template <class C>
Result<PartitionTree> TreeOf(const Mesh& mesh, const Result<C>& clustering)
{
  KDSTREAM_TRY(clustering);
  return PartitionTree{ TreeOfClustering(mesh.points, *clustering), clustering->clusters };
}

class Octree : public PartitionMethod
{
public:
  std::string_view Name() const override { return "octree"; }
  bool HasLevels() const override { return false; }
  Result<PartitionTree> Partition(
    const Mesh& mesh, const KdTreeOptions& options, const Execution& execution) const override
  {
    return TreeOf(mesh, ClusterByOctree(mesh.points,
                          { options.verticesPerPartition, options.partitions }, execution));
  }
  Result<const ExternalMethod*> External() const override { return &ExternalOctreeMethod(); }
};

class KMeans : public PartitionMethod
{
public:
  std::string_view Name() const override { return "kmeans"; }
  bool HasLevels() const override { return false; }
  Result<PartitionTree> Partition(
    const Mesh& mesh, const KdTreeOptions& options, const Execution& execution) const override
  {
    KMeansOptions kmeans;
    kmeans.verticesPerPartition = options.verticesPerPartition;
    kmeans.partitions = options.partitions;
    return TreeOf(mesh, ClusterByKMeans(mesh.points, mesh.triangles, kmeans, execution));
  }
  Result<const ExternalMethod*> External() const override
  {
    return Error{ ErrorCode::LimitExceeded,
      "k-means partitions can only be built in memory: raise --memory, or use another "
      "--partitioner" };
  }
};

struct NamedMedian
{
  std::string_view name;
  MedianMethod method;
};
constexpr NamedMedian medians[] = { { "histogram", FindMedianByHistogram },
  { "auto", FindMedianByHistogram }, { "heaps", FindMedianByHeaps },
  { "torben", FindMedianByTorben }, { "sort", FindMedianBySort } };

}

const PartitionMethod& OctreeMethod()
{
  static const Octree method;
  return method;
}

const PartitionMethod& KMeansMethod()
{
  static const KMeans method;
  return method;
}

const PartitionMethod* PartitionMethodOfName(std::string_view name)
{
  for (const PartitionMethod* method : { &KdTreeMethod(), &OctreeMethod(), &KMeansMethod() })
  {
    if (method->Name() == name)
    {
      return method;
    }
  }
  return nullptr;
}

MedianMethod MedianMethodOfName(std::string_view name)
{
  for (const NamedMedian& median : medians)
  {
    if (median.name == name)
    {
      return median.method;
    }
  }
  return nullptr;
}

}
