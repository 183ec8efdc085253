// SPDX-License-Identifier: BSD-3-Clause
#include "filters/baselines/KMeansGrowth.h"

#include "filters/core/NearestPoint.h"
#include "filters/core/VectorMath.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace kdstream
{
namespace
{

double Area(const Vec3& p, const Vec3& q, const Vec3& r)
{
  return Length(Cross(Minus(q, p), Minus(r, p))) / 2;
}

// All edges in both directions, sorted, without duplicates.
std::vector<std::pair<VertexId, VertexId>> EdgesOf(const KMeansSurface& surface)
{
  std::vector<std::pair<VertexId, VertexId>> edges;
  edges.reserve(6 * surface.triangles.size());
  const auto add = [&](VertexId a, VertexId b)
  {
    if (a != b)
    {
      edges.emplace_back(a, b);
      edges.emplace_back(b, a);
    }
  };
  for (const Triangle& t : surface.triangles)
  {
    add(t[0], t[1]);
    add(t[1], t[2]);
    add(t[2], t[0]);
  }
  std::vector<VertexId> last(surface.points.size()); // for each place, the vertex seen last
  for (VertexId v = 0; v < surface.points.size(); ++v)
  {
    if (surface.place[v] != v)
    {
      add(last[surface.place[v]], v);
    }
    last[surface.place[v]] = v;
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

}

EdgeGraph::EdgeGraph(const KMeansSurface& surface)
  : Begin(surface.points.size() + 1, 0)
{
  const std::vector<std::pair<VertexId, VertexId>> edges = EdgesOf(surface);
  this->Ends.reserve(edges.size());
  this->Lengths.reserve(edges.size());
  double sum = 0;
  for (const auto& [a, b] : edges)
  {
    ++this->Begin[a + 1];
    this->Ends.push_back(b);
    this->Lengths.push_back(std::sqrt(SquaredDistance(surface.points[a], surface.points[b])));
    sum += this->Lengths.back();
  }
  for (std::size_t v = 0; v + 1 < this->Begin.size(); ++v)
  {
    this->Begin[v + 1] += this->Begin[v];
  }
  this->MeanLength = edges.empty() ? 0 : sum / double(edges.size());
}

KMeansGrowth::KMeansGrowth(
  const KMeansSurface& surface, const KMeansOptions& options, std::uint32_t clusters)
  : Mesh(surface)
  , Edges(surface)
  , Cluster(surface.points.size())
  , Size(clusters)
{
  const auto vertices = static_cast<double>(surface.points.size());
  double area = 0;
  for (const Triangle& t : surface.triangles)
  {
    area += Area(surface.points[t[0]], surface.points[t[1]], surface.points[t[2]]);
  }
  double radius = std::sqrt(area / (std::numbers::pi * clusters)); // of a mean cluster
  if (!(radius > 0))
  {
    radius = this->Edges.MeanEdgeLength() * std::sqrt(vertices / clusters);
  }
  this->PerLength = options.distanceWeight / (radius > 0 ? radius : 1);
  this->PerGap = options.compactnessWeight * this->PerLength * this->Edges.MeanEdgeLength();
  this->PerVertex = options.countWeight * clusters / vertices;
}

const std::vector<std::uint32_t>& KMeansGrowth::Grow(const std::vector<VertexId>& seeds)
{
  std::fill(this->Cluster.begin(), this->Cluster.end(), noCluster);
  std::fill(this->Size.begin(), this->Size.end(), 0);
  for (std::uint32_t c = 0; c < seeds.size(); ++c)
  {
    this->Take({ 0, seeds[c], c, 0 });
  }
  while (!this->Front.empty())
  {
    const Candidate next = this->Front.top();
    this->Front.pop();
    if (this->Cluster[next.vertex] == noCluster)
    {
      this->Take(next);
    }
  }
  this->TakeUnreached(seeds);
  return this->Cluster;
}

// Vertices that cannot be reached along edges join the nearest seed.
void KMeansGrowth::TakeUnreached(const std::vector<VertexId>& seeds)
{
  if (std::find(this->Cluster.begin(), this->Cluster.end(), noCluster) == this->Cluster.end())
  {
    return;
  }
  std::vector<Vec3> places;
  places.reserve(seeds.size());
  for (const VertexId seed : seeds)
  {
    places.push_back(this->Mesh.points[seed]);
  }
  const NearestPoint nearest(places);
  for (std::size_t v = 0; v < this->Cluster.size(); ++v)
  {
    if (this->Cluster[v] == noCluster)
    {
      this->Cluster[v] = nearest.Find(this->Mesh.points[v]);
    }
  }
}

}
