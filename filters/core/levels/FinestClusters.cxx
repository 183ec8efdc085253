// SPDX-License-Identifier: BSD-3-Clause
// The finest clusters: see FinestClusters.h.
//   1. Inside each cell join vertices along edges and where they coincide: the components.
//      Do not join along edges that cross an edge between colours.
//   2. Number the clusters by cell and lowest vertex.
//   3. Find the boundary of the surface.
//   4. For each cluster: sums, box and quadric; the representative and its geometric error.
#include "filters/core/levels/FinestClusters.h"

#include "filters/core/DisjointSets.h"
#include "filters/core/Lanes.h"
#include "filters/core/VectorMath.h"
#include "filters/core/Weld.h"
#include "filters/core/levels/CellComponents.h"
#include "filters/core/levels/CollapseAttributes.h"
#include "filters/core/levels/LevelProgress.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace kdstream
{
namespace
{

constexpr std::size_t clusterGrain = 1 << 14;

std::uint32_t Hash(VertexId v)
{
  std::uint32_t x = v + 1;
  x = (x ^ (x >> 16)) * 0x7feb352dU;
  x = (x ^ (x >> 15)) * 0x846ca68bU;
  return x ^ (x >> 16);
}

// The quadric in one lane.
Quadric QuadricOf(const QuadraticForm<Lanes>& forms, std::size_t lane)
{
  Quadric quadric;
  for (std::size_t k = 0; k < 6; ++k)
  {
    quadric.a[k] = forms.a[k][lane];
  }
  for (std::size_t k = 0; k < 3; ++k)
  {
    quadric.b[k] = forms.b[k][lane];
  }
  quadric.c = forms.c[lane];
  return quadric;
}

class FinestBuilder
{
public:
  FinestBuilder(const FinestInput& input, const ClusterOptions& options, const Execution& execution)
    : Points(input.points)
    , Triangles(input.triangles)
    , Tree(input.tree)
    , Buckets(input.partitionTriangles)
    , Ids(input.ids)
    , VertexColors(input.vertexColors)
    , Options(options)
    , Exec(execution)
    , Below(input.tree.depths.finest - input.tree.depths.partition)
  {
    this->Output.origin = input.origin;
  }

  Result<FinestClusters> Build()
  {
    std::vector<VertexId> root(this->Points.size());
    std::vector<std::uint8_t> surface(this->Points.size(), 0);
    KDSTREAM_TRY(this->Exec.Report("levels", 0));
    this->FindCellComponents(root, surface);
    KDSTREAM_TRY(this->Exec.Report("levels", componentsFoundPart));
    const std::vector<VertexId> clusterBegin = this->NumberClusters(root, surface);
    root.clear();
    root.shrink_to_fit();
    KDSTREAM_TRY(this->SumClusters(clusterBegin, surface));
    if (this->Options.joinCoincident)
    {
      JoinCoincidentClusters(this->Output, this->Below);
    }
    RepresentClusters(this->Output.clusters, this->Options.representative, this->Output.origin,
      this->Output.level, this->Exec);
    return std::move(this->Output);
  }

private:
  // The id of a vertex in the mesh.
  VertexId IdOf(VertexId v) const { return this->Ids.empty() ? v : this->Ids[v]; }

  bool HasColorEdge(VertexId a, VertexId b) const
  {
    return this->VertexColors && IsColorEdge(*this->VertexColors, a, b);
  }

  Vec3 Relative(VertexId v) const { return Minus(this->Points[v], this->Output.origin); }

  template <class Visit>
  void ForEachPartition(std::size_t first, std::size_t last, const Visit& visit) const
  {
    this->Exec.parallelFor(last - first, 1,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t partition = first + begin; partition < first + end; ++partition)
        {
          visit(partition);
        }
      });
  }

  // Joins the vertices of each finest cell along the triangles' edges, and where they coincide.
  void FindCellComponents(std::vector<VertexId>& root, std::vector<std::uint8_t>& surface)
  {
    std::iota(root.begin(), root.end(), VertexId{ 0 });
    const std::vector<std::uint32_t> cell =
      CellOfVertex(this->Tree, this->Tree.depths.finest, this->Points.size(), this->Exec);
    // Ghosts are in no cell. A cell lies in one partition, so partitions can be processed in
    // parallel: they do not share trees of the forest.
    this->ForEachPartition(0, this->Buckets.begin.size() - 1,
      [&](std::size_t partition)
      {
        for (const std::uint32_t t : this->Buckets.Of(partition))
        {
          const Triangle& triangle = this->Triangles[t];
          for (std::size_t k = 0; k < 3; ++k)
          {
            const VertexId a = triangle[k], b = triangle[(k + 1) % 3];
            if (cell[a] >> this->Below == partition)
            {
              surface[a] = 1;
              if (cell[a] == cell[b] && root[a] != root[b] && !this->HasColorEdge(a, b))
              {
                Join(root, a, b);
              }
            }
          }
        }
      });
    if (this->Options.mayCoincide)
    {
      this->JoinCoincident(root, cell);
    }
  }

  // Links vertices in the same place into a chain, in the order of the cells. A cell of any depth
  // is an interval in that order, so the part of a chain inside a cell is connected.
  void JoinCoincident(std::vector<VertexId>& root, const std::vector<std::uint32_t>& cell)
  {
    const std::vector<VertexId> first =
      FirstCoincident(this->Points, Coincidence::ValueEqual, this->Exec);
    std::vector<VertexId> last(first.size(), noVertex);
    for (const VertexId v : this->Tree.order)
    {
      VertexId& previous = last[first[v]];
      if (previous != noVertex && cell[previous] == cell[v])
      {
        Join(root, previous, v);
      }
      else if (previous != noVertex)
      {
        this->Output.coincident.emplace_back(previous, v);
      }
      previous = v;
    }
  }

  // Gives every vertex its cluster; returns where each cell's clusters begin.
  std::vector<VertexId> NumberClusters(
    std::vector<VertexId>& root, const std::vector<std::uint8_t>& surface)
  {
    const std::size_t cells = this->Tree.cellBegin.size() - 1;
    std::vector<VertexId> clusterBegin(cells + 1, 0);
    std::vector<VertexId>& clusterOf = this->Output.clusterOf;
    clusterOf.assign(this->Points.size(), noVertex);
    this->Exec.parallelFor(cells, clusterGrain / 8,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t c = begin; c < end; ++c)
        {
          const std::span<const VertexId> members = this->Tree.Cell(this->Tree.depths.finest, c);
          const VertexId first = members.empty() ? noVertex : FindRoot(root, members.front());
          if (!members.empty() && std::all_of(members.begin(), members.end(),
                                    [&](VertexId v) { return FindRoot(root, v) == first; }))
          {
            // One component, as in most cells.
            std::for_each(members.begin(), members.end(), [&](VertexId v) { clusterOf[v] = 0; });
            clusterBegin[c + 1] = 1;
            continue;
          }
          clusterBegin[c + 1] = static_cast<VertexId>(GroupCell(
            members, this->Options.byComponents, [&](VertexId v) { return FindRoot(root, v); },
            [&](VertexId v) {
              return CellComponent{ 1, this->Relative(v), surface[v] != 0, 0 };
            },
            [&](VertexId v, std::size_t local) { clusterOf[v] = static_cast<VertexId>(local); }));
        }
      });
    std::partial_sum(clusterBegin.begin(), clusterBegin.end(), clusterBegin.begin());
    this->Output.cellOf.resize(clusterBegin.back());
    for (std::size_t c = 0; c < cells; ++c)
    {
      for (const VertexId v : this->Tree.Cell(this->Tree.depths.finest, c))
      {
        clusterOf[v] += clusterBegin[c];
      }
      std::fill(this->Output.cellOf.data() + clusterBegin[c],
        this->Output.cellOf.data() + clusterBegin[c + 1], static_cast<std::uint32_t>(c));
    }
    return clusterBegin;
  }

  // Sums up the vertices and triangles of each cluster, in the order of their numbers, so that the
  // sums do not depend on the threads. Works in parts, and reports progress after each.
  Status SumClusters(
    const std::vector<VertexId>& clusterBegin, const std::vector<std::uint8_t>& surface)
  {
    this->Output.clusters.assign(clusterBegin.back(), {});
    const bool boundary = this->Options.representative == Representative::Quadric;
    this->Output.partitionBegin.assign(this->Buckets.begin.size(), 0);
    // See FindUnbalanced. Each partition writes the sums of its own vertices only.
    std::vector<std::uint32_t> unbalanced(boundary ? this->Points.size() : 0, 0);
    const std::size_t count = this->Buckets.begin.size() - 1;
    constexpr std::size_t fewest = 256, reports = 16; // partitions at once keep all threads busy
    const std::size_t atOnce = std::max(fewest, count / reports);
    for (std::size_t first = 0; first < count; first += atOnce)
    {
      const std::size_t last = std::min(first + atOnce, count);
      this->ForEachPartition(first, last,
        [&](std::size_t partition)
        { this->SumPartition(partition, clusterBegin, surface, boundary, unbalanced); });
      const double done = double(last) / double(count);
      KDSTREAM_TRY(this->Exec.Report(
        "levels", componentsFoundPart + (clustersSummedPart - componentsFoundPart) * done));
    }
    return {};
  }

  void SumPartition(std::size_t partition, const std::vector<VertexId>& clusterBegin,
    const std::vector<std::uint8_t>& surface, bool boundary, std::vector<std::uint32_t>& unbalanced)
  {
    const std::size_t firstCell = partition << this->Below;
    const std::size_t endCell = (partition + 1) << this->Below;
    for (std::size_t c = firstCell; c < endCell; ++c)
    {
      this->SumVertices(c, surface);
    }
    const VertexId first = clusterBegin[firstCell], end = clusterBegin[endCell];
    this->Output.partitionBegin[partition + 1] = end;
    this->SumTriangles(partition, first, end);
    if (boundary && this->FindUnbalanced(partition, first, end, unbalanced))
    {
      this->SumBoundary(partition, first, end, unbalanced);
    }
  }

  void SumVertices(std::size_t cell, const std::vector<std::uint8_t>& surface)
  {
    for (const VertexId v : this->Tree.Cell(this->Tree.depths.finest, cell))
    {
      ClusterSum& cluster = this->Output.clusters[this->Output.clusterOf[v]];
      cluster.AddVertex(this->IdOf(v), this->Points[v], this->Relative(v));
      cluster.surface |= surface[v] != 0;
    }
  }

  // Adds the triangles' planes to the partition's clusters, which are [firstCluster, endCluster).
  void SumTriangles(std::size_t partition, VertexId firstCluster, VertexId endCluster)
  {
    const std::span<const std::uint32_t> numbers = this->Buckets.Of(partition);
    for (std::size_t i = 0; i < numbers.size(); i += 2) // two at a time
    {
      const Triangle& first = this->Triangles[numbers[i]];
      const Triangle& second = this->Triangles[numbers[std::min(i + 1, numbers.size() - 1)]];
      std::array<std::array<Lanes, 3>, 3> corners;
      for (std::size_t k = 0; k < 3; ++k)
      {
        const Vec3 p = this->Relative(first[k]), q = this->Relative(second[k]);
        corners[k] = { Lanes(p[0], q[0]), Lanes(p[1], q[1]), Lanes(p[2], q[2]) };
      }
      const QuadraticForm<Lanes> planes =
        QuadraticForm<Lanes>::OfTriangle(corners[0], corners[1], corners[2]);
      const std::array<Lanes, 3> twice =
        Cross(Minus(corners[1], corners[0]), Minus(corners[2], corners[0]));
      this->AddPlane(first, planes, twice, 0, firstCluster, endCluster);
      if (i + 1 < numbers.size())
      {
        this->AddPlane(second, planes, twice, 1, firstCluster, endCluster);
      }
    }
  }

  // Adds a triangle's plane and its area vector once to each of the triangle's clusters that belong
  // to the partition. twice: twice the area vector.
  void AddPlane(const Triangle& triangle, const QuadraticForm<Lanes>& planes,
    const std::array<Lanes, 3>& twice, std::size_t lane, VertexId firstCluster, VertexId endCluster)
  {
    const Quadric quadric = QuadricOf(planes, lane);
    const Vec3 area{ twice[0][lane] / 2, twice[1][lane] / 2, twice[2][lane] / 2 };
    VertexId done[3] = { noVertex, noVertex, noVertex };
    for (std::size_t k = 0; k < 3; ++k)
    {
      const VertexId cluster = this->Output.clusterOf[triangle[k]];
      if (cluster >= firstCluster && cluster < endCluster && cluster != done[0] &&
          cluster != done[1])
      {
        ClusterSum& sum = this->Output.clusters[cluster];
        sum.quadric.Add(quadric);
        sum.normal = Plus(sum.normal, area);
      }
      done[k] = cluster;
    }
  }

  // Whether a vertex is the partition's own, whose clusters are [firstCluster, endCluster).
  bool IsOwn(VertexId v, VertexId firstCluster, VertexId endCluster) const
  {
    const VertexId cluster = this->Output.clusterOf[v];
    return cluster >= firstCluster && cluster < endCluster;
  }

  // Finds the partition's own vertices at the ends of boundary edges, without a list of edges. For
  // each triangle, a vertex adds the hash of the corner after it and subtracts that of the corner
  // before it. An edge that is used equally often in both directions sums to 0 at both ends; a
  // boundary edge does not. (With a probability of 2^-32, several boundary edges sum to 0 by
  // chance: then the boundary at this vertex is not held in place.) Returns whether a sum is not 0.
  // Needs only the partition's triangles.
  bool FindUnbalanced(std::size_t partition, VertexId firstCluster, VertexId endCluster,
    std::vector<std::uint32_t>& sums) const
  {
    for (const std::uint32_t t : this->Buckets.Of(partition))
    {
      const Triangle& triangle = this->Triangles[t];
      std::uint32_t hashed[3];
      for (std::size_t k = 0; k < 3; ++k)
      {
        hashed[k] = Hash(this->IdOf(triangle[k]));
      }
      for (std::size_t k = 0; k < 3; ++k)
      {
        if (this->IsOwn(triangle[k], firstCluster, endCluster))
        {
          sums[triangle[k]] += hashed[(k + 1) % 3] - hashed[(k + 2) % 3];
        }
      }
    }
    const auto own = this->Tree.Cell(this->Tree.depths.partition, partition);
    return std::any_of(own.begin(), own.end(), [&](VertexId v) { return sums[v] != 0; });
  }

  // Adds the planes through boundary edges to the partition's clusters, and the ends of these edges
  // to their boundary sums. Looks only at edges with an own end: the partition has all triangles at
  // such an edge, so it knows whether the edge is on the boundary (in only one triangle).
  void SumBoundary(std::size_t partition, VertexId firstCluster, VertexId endCluster,
    const std::vector<std::uint32_t>& unbalanced)
  {
    struct Edge
    {
      VertexId low, high, opposite;
    };
    std::vector<Edge> edges;
    const auto own = [&](VertexId v) { return this->IsOwn(v, firstCluster, endCluster); };
    const auto balanced = [&](VertexId v) { return own(v) && unbalanced[v] == 0; };
    for (const std::uint32_t t : this->Buckets.Of(partition))
    {
      const Triangle& triangle = this->Triangles[t];
      for (std::size_t k = 0; k < 3; ++k)
      {
        const auto [low, high] = std::minmax(triangle[k], triangle[(k + 1) % 3],
          [&](VertexId a, VertexId b) { return this->IdOf(a) < this->IdOf(b); });
        const VertexId opposite = triangle[(k + 2) % 3];
        if ((own(low) || own(high)) && !balanced(low) && !balanced(high) && low != high &&
            opposite != low && opposite != high)
        {
          edges.push_back({ low, high, opposite });
        }
      }
    }
    std::sort(edges.begin(), edges.end(),
      [&](const Edge& a, const Edge& b)
      {
        return a.low != b.low ? this->IdOf(a.low) < this->IdOf(b.low)
                              : this->IdOf(a.high) < this->IdOf(b.high);
      });
    const auto same = [&](std::size_t i, std::size_t j)
    { return edges[i].low == edges[j].low && edges[i].high == edges[j].high; };
    std::vector<VertexId> ends;
    for (std::size_t i = 0; i < edges.size(); ++i)
    {
      if ((i > 0 && same(i, i - 1)) || (i + 1 < edges.size() && same(i, i + 1)))
      {
        continue;
      }
      this->AddBoundaryEdge(
        { edges[i].low, edges[i].high, edges[i].opposite }, firstCluster, endCluster, ends);
    }
    std::sort(ends.begin(), ends.end());
    ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
    for (const VertexId v : ends)
    {
      ClusterSum& cluster = this->Output.clusters[this->Output.clusterOf[v]];
      const Vec3 p = this->Relative(v);
      for (std::size_t k = 0; k < 3; ++k)
      {
        cluster.boundarySum[k] += p[k];
      }
      ++cluster.boundaryCount;
    }
  }

  // edge: its two ends, and the opposite vertex of its triangle.
  void AddBoundaryEdge(
    const Triangle& edge, VertexId firstCluster, VertexId endCluster, std::vector<VertexId>& ends)
  {
    Quadric quadric;
    quadric.AddBoundary(this->Relative(edge[0]), this->Relative(edge[1]), this->Relative(edge[2]));
    VertexId done = noVertex;
    for (std::size_t k = 0; k < 2; ++k)
    {
      const VertexId cluster = this->Output.clusterOf[edge[k]];
      if (cluster >= firstCluster && cluster < endCluster)
      {
        ends.push_back(edge[k]);
        if (cluster != done)
        {
          this->Output.clusters[cluster].quadric.Add(quadric);
          done = cluster;
        }
      }
    }
  }

  std::span<const Vec3> Points;
  std::span<const Triangle> Triangles;
  const KdTree& Tree;
  const TriangleBuckets& Buckets;
  std::span<const VertexId> Ids;
  const Attribute* VertexColors;
  const ClusterOptions& Options;
  const Execution& Exec;
  unsigned Below; // levels from the partitions to the finest
  FinestClusters Output;
};

}

Result<FinestClusters> BuildFinestClusters(
  const FinestInput& input, const ClusterOptions& options, const Execution& execution)
{
  return FinestBuilder(input, options, execution).Build();
}

void RepresentClusters(std::vector<ClusterSum>& clusters, Representative representative,
  const Vec3& origin, ClusterLevel& level, const Execution& execution)
{
  level.positions.resize(clusters.size());
  level.geometricErrors.resize(clusters.size());
  level.lowest.resize(clusters.size());
  execution.parallelFor(clusters.size(), clusterGrain,
    [&](std::size_t begin, std::size_t end)
    {
      for (std::size_t i = begin; i < end; ++i)
      {
        ClusterSum& cluster = clusters[i];
        const Vec3 x = cluster.Represent(representative, origin);
        level.positions[i] = x;
        cluster.geometricError =
          std::max(cluster.geometricError, cluster.GeometricErrorAt(Minus(x, origin)));
        level.geometricErrors[i] = cluster.geometricError;
        level.lowest[i] = cluster.lowest;
      }
    });
}

}
