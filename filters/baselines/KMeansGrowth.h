// SPDX-License-Identifier: BSD-3-Clause
// Step c of k-means clustering (KMeansClustering.cxx): clusters grow from their seeds along the
// edges of a mesh. Only for KMeansClustering.
#pragma once

#include "filters/baselines/KMeansClustering.h"
#include "filters/baselines/KMeansSurface.h"
#include "filters/core/Types.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <queue>
#include <span>
#include <tuple>
#include <vector>

namespace kdstream
{

// The neighbours of each vertex along edges. Vertices in one place form a chain of edges of length
// 0.
class EdgeGraph
{
public:
  explicit EdgeGraph(const KMeansSurface& surface);

  std::span<const VertexId> Neighbours(VertexId v) const
  {
    return { this->Ends.data() + this->Begin[v], this->Ends.data() + this->Begin[v + 1] };
  }
  // The lengths of the edges to the neighbours, in the order of the neighbours.
  std::span<const double> LengthsTo(VertexId v) const
  {
    return { this->Lengths.data() + this->Begin[v], this->Lengths.data() + this->Begin[v + 1] };
  }
  double MeanEdgeLength() const { return this->MeanLength; }

private:
  std::vector<std::size_t> Begin;
  std::vector<VertexId> Ends;
  std::vector<double> Lengths;
  double MeanLength = 0;
};

// Grows all clusters at the same time; the cheapest vertex that any of them reaches is always next.
// KMeansClustering.h describes the cost of a vertex. Keeps a reference to the surface.
class KMeansGrowth
{
public:
  KMeansGrowth(const KMeansSurface& surface, const KMeansOptions& options, std::uint32_t clusters);

  // Returns the cluster of each vertex. seeds: a vertex for each cluster, all different. O((n + t)
  // log n).
  const std::vector<std::uint32_t>& Grow(const std::vector<VertexId>& seeds);

private:
  // A vertex that a cluster reaches.
  struct Candidate
  {
    double cost;
    VertexId vertex;
    std::uint32_t cluster;
    double distance; // from the seed, along edges
    bool operator>(const Candidate& other) const
    {
      return std::tie(this->cost, this->vertex, this->cluster) >
             std::tie(other.cost, other.vertex, other.cluster);
    }
  };

  static constexpr std::uint32_t noCluster = std::numeric_limits<std::uint32_t>::max();
  static constexpr std::size_t neighboursLookedAt = 16;

  // Adds the vertex to the cluster, which then reaches its neighbours.
  void Take(const Candidate& taken)
  {
    this->Cluster[taken.vertex] = taken.cluster;
    ++this->Size[taken.cluster];
    const std::span<const VertexId> neighbours = this->Edges.Neighbours(taken.vertex);
    const std::span<const double> lengths = this->Edges.LengthsTo(taken.vertex);
    for (std::size_t i = 0; i < neighbours.size(); ++i)
    {
      if (this->Cluster[neighbours[i]] == noCluster)
      {
        const double distance = taken.distance + lengths[i];
        this->Front.push({ this->Cost(neighbours[i], taken.cluster, distance), neighbours[i],
          taken.cluster, distance });
      }
    }
  }

  double Cost(VertexId vertex, std::uint32_t cluster, double distance) const
  {
    const std::span<const VertexId> neighbours = this->Edges.Neighbours(vertex);
    const std::size_t looked = std::min(neighbours.size(), neighboursLookedAt);
    std::size_t outside = 0;
    for (std::size_t i = 0; i < looked; ++i)
    {
      outside += this->Cluster[neighbours[i]] != cluster;
    }
    return this->PerLength * distance + this->PerGap * double(outside) / double(looked) +
           this->PerVertex * double(this->Size[cluster]);
  }

  void TakeUnreached(const std::vector<VertexId>& seeds);

  const KMeansSurface& Mesh;
  EdgeGraph Edges;
  std::vector<std::uint32_t> Cluster; // of each vertex, or noCluster
  std::vector<std::uint32_t> Size;    // of each cluster, in vertices
  std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>> Front;
  double PerLength = 0, PerGap = 0, PerVertex = 0; // costs
};

}
