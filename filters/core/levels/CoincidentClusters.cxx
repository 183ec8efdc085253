// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/levels/FinestClusters.h"

#include "filters/core/DisjointSets.h"

#include <numeric>

namespace kdstream
{
namespace
{

// For each cluster the one that it joins: among the clusters linked to it, directly or through
// others, the one with the lowest vertex.
std::vector<VertexId> TargetsOf(const FinestClusters& finest, unsigned cellsBelowPartition)
{
  std::vector<VertexId> parent(finest.clusters.size());
  std::iota(parent.begin(), parent.end(), VertexId{ 0 });
  for (const Link& link : finest.coincident)
  {
    const VertexId a = finest.clusterOf[link.first], b = finest.clusterOf[link.second];
    if (finest.cellOf[a] >> cellsBelowPartition == finest.cellOf[b] >> cellsBelowPartition)
    {
      Join(parent, a, b);
    }
  }
  std::vector<VertexId> lowest = parent; // of each root the cluster with the lowest vertex
  for (VertexId c = 0; c < parent.size(); ++c)
  {
    VertexId& best = lowest[FindRoot(parent, c)];
    best = finest.clusters[c].lowest < finest.clusters[best].lowest ? c : best;
  }
  std::vector<VertexId> targets(parent.size());
  for (VertexId c = 0; c < targets.size(); ++c)
  {
    targets[c] = lowest[FindRoot(parent, c)];
  }
  return targets;
}

}

void JoinCoincidentClusters(FinestClusters& finest, unsigned cellsBelowPartition)
{
  if (finest.coincident.empty())
  {
    return;
  }
  const std::vector<VertexId> targets = TargetsOf(finest, cellsBelowPartition);
  // For each cluster, the number of clusters before it that stay.
  std::vector<VertexId> number(targets.size() + 1, 0);
  for (VertexId c = 0; c < targets.size(); ++c)
  {
    number[c + 1] = number[c] + (targets[c] == c);
    if (targets[c] != c)
    {
      finest.clusters[targets[c]].Add(finest.clusters[c]);
    }
  }
  for (VertexId& cluster : finest.clusterOf)
  {
    cluster = cluster == noVertex ? noVertex : number[targets[cluster]];
  }
  for (VertexId c = 0; c < targets.size(); ++c)
  {
    if (targets[c] == c)
    {
      finest.clusters[number[c]] = finest.clusters[c];
      finest.cellOf[number[c]] = finest.cellOf[c];
    }
  }
  finest.clusters.resize(number.back());
  finest.cellOf.resize(number.back());
  for (VertexId& begin : finest.partitionBegin)
  {
    begin = number[begin];
  }
}

}
