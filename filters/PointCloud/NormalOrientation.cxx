// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. make the edges of the graph go both ways
// 2. start at every known normal, or at a part's highest point, and follow the edges between the
//    most parallel normals first (Prim).
#include "filters/PointCloud/SurfaceReconstruction.h"

#include "filters/core/VectorMath.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>
#include <tuple>

namespace kdstream
{
namespace
{

// The neighbours of all points, point after point. Each edge is stored at both of its ends.
class Graph
{
public:
  Graph(std::span<const VertexId> neighbors, std::size_t k, std::size_t points)
    : Begins(points + 1)
  {
    const auto forEachEdge = [&](const auto& call)
    {
      for (std::size_t i = 0; i < neighbors.size(); ++i)
      {
        const auto from = static_cast<VertexId>(i / k);
        if (neighbors[i] != from)
        {
          call(from, neighbors[i]);
          call(neighbors[i], from);
        }
      }
    };
    forEachEdge([&](VertexId from, VertexId) { ++this->Begins[from + 1]; });
    std::partial_sum(this->Begins.begin(), this->Begins.end(), this->Begins.begin());
    this->Ends.resize(this->Begins.back());
    std::vector<std::size_t> next(this->Begins.begin(), this->Begins.end() - 1);
    forEachEdge([&](VertexId from, VertexId to) { this->Ends[next[from]++] = to; });
  }

  std::span<const VertexId> Of(VertexId point) const
  {
    return std::span(this->Ends)
      .subspan(this->Begins[point], this->Begins[point + 1] - this->Begins[point]);
  }

private:
  std::vector<std::size_t> Begins;
  std::vector<VertexId> Ends;
};

// An edge to follow: its cost, the point to which it leads, and the point from which it comes.
using Step = std::tuple<double, VertexId, VertexId>;

class Orienter
{
public:
  Orienter(const Graph& graph, std::span<Vec3> normals)
    : Edges(graph)
    , Normals(normals)
    , Done(normals.size(), 0)
  {
  }

  bool IsDone(VertexId point) const { return this->Done[point] != 0; }

  // Marks a point whose normal is right as it is.
  void Finish(VertexId point)
  {
    this->Done[point] = 1;
    for (const VertexId neighbor : this->Edges.Of(point))
    {
      if (!this->IsDone(neighbor))
      {
        const double cost = 1 - std::abs(Dot(this->Normals[point], this->Normals[neighbor]));
        this->Queue.emplace(cost, neighbor, point);
      }
    }
  }

  void Spread()
  {
    while (!this->Queue.empty())
    {
      const auto [cost, point, from] = this->Queue.top();
      this->Queue.pop();
      if (!this->IsDone(point))
      {
        Vec3& normal = this->Normals[point];
        if (Dot(normal, this->Normals[from]) < 0)
        {
          normal = { -normal[0], -normal[1], -normal[2] };
        }
        this->Finish(point);
      }
    }
  }

private:
  const Graph& Edges;
  std::span<Vec3> Normals;
  std::vector<std::uint8_t> Done;
  std::priority_queue<Step, std::vector<Step>, std::greater<>> Queue;
};

}

void OrientNormals(std::span<const Vec3> points, std::span<const std::uint8_t> known,
  std::span<const VertexId> neighbors, std::size_t k, std::span<Vec3> normals)
{
  const Graph graph(neighbors, k, points.size());
  Orienter orienter(graph, normals);
  for (VertexId i = 0; i < points.size(); ++i)
  {
    if (known[i])
    {
      orienter.Finish(i);
    }
  }
  orienter.Spread();
  std::vector<VertexId> highest(points.size());
  std::iota(highest.begin(), highest.end(), VertexId{ 0 });
  std::stable_sort(highest.begin(), highest.end(),
    [&](VertexId a, VertexId b) { return points[a][2] > points[b][2]; });
  for (const VertexId top : highest)
  {
    if (!orienter.IsDone(top))
    {
      Vec3& normal = normals[top];
      if (normal[2] < 0)
      {
        normal = { -normal[0], -normal[1], -normal[2] };
      }
      orienter.Finish(top);
      orienter.Spread();
    }
  }
}

}
