// SPDX-License-Identifier: BSD-3-Clause
// K-means clustering: see KMeansClustering.h. Steps:
//   a. Move points into a box of side 1, and map vertices in the same place to the lowest one
//      (KMeansSurface).
//   b. Choose seeds by hierarchical face clustering (KMeansSeeds).
//   c. As often as the options say: let all clusters grow from their seeds over the graph of edges
//      (KMeansGrowth); the middle of each is its next seed.
//   d. Number the clusters by their first vertices.
#include "filters/baselines/KMeansClustering.h"

#include "filters/baselines/KMeansGrowth.h"
#include "filters/baselines/KMeansSurface.h"
#include "filters/core/VectorMath.h"

#include <limits>
#include <string>

namespace kdstream
{
namespace
{

constexpr double greatestWeight = 1e6;

// For each cluster the vertex nearest to the mean of its vertices; if several are as near, the
// lowest.
std::vector<VertexId> Centres(
  std::span<const Vec3> points, const std::vector<std::uint32_t>& clusterOf, std::size_t clusters)
{
  std::vector<Vec3> mean(clusters, Vec3{});
  std::vector<double> count(clusters, 0);
  for (std::size_t v = 0; v < points.size(); ++v)
  {
    const std::uint32_t c = clusterOf[v];
    ++count[c];
    for (std::size_t k = 0; k < 3; ++k)
    {
      mean[c][k] += points[v][k];
    }
  }
  for (std::size_t c = 0; c < clusters; ++c)
  {
    mean[c] = { mean[c][0] / count[c], mean[c][1] / count[c], mean[c][2] / count[c] };
  }
  std::vector<VertexId> centre(clusters, noVertex);
  std::vector<double> nearest(clusters, std::numeric_limits<double>::infinity());
  for (std::size_t v = 0; v < points.size(); ++v)
  {
    const std::uint32_t c = clusterOf[v];
    const double squared = SquaredDistance(points[v], mean[c]);
    if (squared < nearest[c])
    {
      nearest[c] = squared;
      centre[c] = static_cast<VertexId>(v);
    }
  }
  return centre;
}

// Numbers clusters by their first vertices.
Clustering Number(std::vector<std::uint32_t> clusterOf, std::uint32_t clusters)
{
  constexpr std::uint32_t noNumber = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> number(clusters, noNumber);
  Clustering clustering;
  for (std::uint32_t& cluster : clusterOf)
  {
    if (number[cluster] == noNumber)
    {
      number[cluster] = clustering.clusters++;
    }
    cluster = number[cluster];
  }
  clustering.clusterOf = std::move(clusterOf);
  return clustering;
}

Result<std::uint32_t> CountOf(std::size_t vertices, const KMeansOptions& options)
{
  const auto bad = [](const std::string& message) {
    return Error{ ErrorCode::InvalidArgument, message };
  };
  if (vertices == 0)
  {
    return bad("the mesh has no vertices");
  }
  if (vertices >= noVertex)
  {
    return Error{ ErrorCode::LimitExceeded,
      std::to_string(vertices) + " vertices; at most 4294967294 fit k-means in memory" };
  }
  if (options.iterations == 0)
  {
    return bad("the number of iterations must be at least 1, not 0");
  }
  for (const double weight :
    { options.distanceWeight, options.compactnessWeight, options.countWeight })
  {
    if (!(weight >= 0 && weight <= greatestWeight) || options.distanceWeight == 0)
    {
      return bad("a weight of k-means is " + std::to_string(weight) +
                 "; weights must be 0 to 1000000, and that of the distance above 0");
    }
  }
  if (!options.partitions)
  {
    if (options.verticesPerPartition == 0)
    {
      return bad("the number of vertices per partition must be at least 1, not 0");
    }
    return static_cast<std::uint32_t>((vertices - 1) / options.verticesPerPartition + 1);
  }
  if (*options.partitions == 0)
  {
    return bad("the number of partitions must be at least 1, not 0");
  }
  if (*options.partitions > vertices)
  {
    return bad("number of partitions " + std::to_string(*options.partitions) +
               " is above the number of vertices, " + std::to_string(vertices));
  }
  return *options.partitions;
}

}

Result<Clustering> ClusterByKMeans(std::span<const Vec3> points,
  std::span<const Triangle> triangles, const KMeansOptions& options, const Execution& execution)
{
  const Result<std::uint32_t> clusters = CountOf(points.size(), options);
  KDSTREAM_TRY(clusters);
  const Result<KMeansSurface> surface = MakeKMeansSurface(points, triangles);
  KDSTREAM_TRY(surface);
  Result<std::vector<VertexId>> seeds = SpreadSeeds(*surface, *clusters, execution);
  KDSTREAM_TRY(seeds);
  KMeansGrowth growth(*surface, options, *clusters);
  for (std::uint32_t i = 0; i + 1 < options.iterations; ++i)
  {
    KDSTREAM_TRY(execution.Report("k-means", double(i) / options.iterations));
    *seeds = Centres(surface->points, growth.Grow(*seeds), *clusters);
  }
  std::vector<std::uint32_t> clusterOf = growth.Grow(*seeds);
  KDSTREAM_TRY(execution.Report("k-means", 1));
  return Number(std::move(clusterOf), *clusters);
}

}
