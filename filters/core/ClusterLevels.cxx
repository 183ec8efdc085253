// Levels by clustering: see ClusterLevels.h.
//   1. Finest level: inside each cell join vertices along edges and where they coincide: the
//   sheets.
//   2. Per sheet: sums, box and quadric; the representative and its deviation.
//   3. The triangles' image, and the pairs of clusters that only collapsed triangles link.
//   4. Each coarser level the same way from the level below it: clusters in the place of vertices.
#include "filters/core/ClusterLevels.h"

#include "filters/core/CellSheets.h"
#include "filters/core/Quadric.h"
#include "filters/core/Weld.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

namespace kdstream
{
namespace
{

constexpr double regularisation = 1e-3; // of the quadric's trace; measured in the prototype
constexpr std::size_t grain = 1 << 14;

using Link = std::pair<VertexId, VertexId>; // lower first

// What is known of a cluster beside its place in the level. A finest cluster adds up vertices, a
// coarser one clusters.
struct Cluster
{
  std::uint64_t count = 0; // original vertices
  Vec3 sum{};              // of positions relative to the centre
  double squares = 0;      // of their squared lengths
  Box box;                 // of the vertices
  Quadric quadric;         // relative to the centre
  double deviation = 0;
  VertexId lowest = noVertex;
  bool surface = false; // whether a triangle touches one of its vertices
};

struct Workspace
{
  std::vector<Cluster> clusters;     // of the level last made
  std::vector<std::uint32_t> cellOf; // of each cluster
  std::vector<Link> collapsed; // pairs linked by collapsed triangles or by coincidence, sorted
};

VertexId FindRoot(std::vector<VertexId>& parent, VertexId v)
{
  while (parent[v] != v)
  {
    parent[v] = parent[parent[v]];
    v = parent[v];
  }
  return v;
}

void Join(std::vector<VertexId>& parent, VertexId a, VertexId b)
{
  a = FindRoot(parent, a);
  b = FindRoot(parent, b);
  parent[std::max(a, b)] = std::min(a, b);
}

class LevelBuilder
{
public:
  LevelBuilder(std::span<const Vec3> points, std::span<const Triangle> triangles,
    const KdTree& tree, const TriangleBuckets& buckets, const ClusterOptions& options,
    const Execution& execution)
    : Points(points)
    , Triangles(triangles)
    , Tree(tree)
    , Buckets(buckets)
    , Options(options)
    , Exec(execution)
  {
    const Box& box = tree.boxes[1];
    for (std::size_t k = 0; k < 3; ++k)
    {
      this->Centre[k] = box.lo[k] / 2 + box.hi[k] / 2;
    }
  }

  Result<ClusterLevels> Build()
  {
    const unsigned finest = this->Tree.depths.finest;
    this->Output.levels.resize(finest + 1);
    if (Status status = this->BuildFinest(); !status)
    {
      return status.GetError();
    }
    for (unsigned depth = finest; depth-- > this->Options.coarsestDepth;)
    {
      const double done = 1.0 - double(depth + 1) / double(finest + 1);
      if (Status status = this->Exec.Report("levels", 0.5 + 0.5 * done); !status)
      {
        return status.GetError();
      }
      this->BuildCoarser(depth);
    }
    return std::move(this->Output);
  }

private:
  Vec3 Relative(VertexId v) const
  {
    const Vec3& p = this->Points[v];
    return { p[0] - this->Centre[0], p[1] - this->Centre[1], p[2] - this->Centre[2] };
  }

  Status BuildFinest()
  {
    const unsigned depth = this->Tree.depths.finest;
    std::vector<VertexId> root(this->Points.size());
    std::vector<std::uint8_t> surface(this->Points.size(), 0);
    std::vector<Link> coincident;
    this->FindSheets(root, surface, coincident);
    if (Status status = this->Exec.Report("levels", 0.1); !status)
    {
      return status;
    }
    const std::vector<VertexId> clusterBegin = this->NumberFinest(root, surface);
    if (this->Options.mostClusters > 0 && clusterBegin.back() > this->Options.mostClusters)
    {
      return Error{ ErrorCode::LimitExceeded,
        "the finest level has " + std::to_string(clusterBegin.back()) + " clusters; at most " +
          std::to_string(this->Options.mostClusters) + " are allowed" };
    }
    root.clear();
    root.shrink_to_fit();
    this->SumFinest(clusterBegin, surface);
    if (Status status = this->Exec.Report("levels", 0.3); !status)
    {
      return status;
    }
    this->FinishLevel(depth);
    this->Output.levels[depth].triangles =
      ImageOfTriangles(this->Triangles, this->Output.finest, this->Exec);
    this->CollectLinks(this->Triangles, coincident, this->Output.finest);
    return {};
  }

  // Joins the vertices of each finest cell along the triangles' edges, and where they coincide.
  void FindSheets(
    std::vector<VertexId>& root, std::vector<std::uint8_t>& surface, std::vector<Link>& coincident)
  {
    std::iota(root.begin(), root.end(), VertexId{ 0 });
    const std::vector<std::uint32_t> cell = CellOfVertex(this->Tree, this->Tree.depths.finest);
    const unsigned below = this->Tree.depths.finest - this->Tree.depths.partition;
    const std::vector<VertexId> first = FirstCoincident(this->Points, Coincidence::ValueEqual);
    // A cell lies in one partition, so partitions do not meet in the forest.
    this->Exec.parallelFor(this->Buckets.begin.size() - 1, 1,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t partition = begin; partition < end; ++partition)
        {
          for (const std::uint32_t t : this->Buckets.Of(partition))
          {
            const Triangle& triangle = this->Triangles[t];
            for (std::size_t k = 0; k < 3; ++k)
            {
              const VertexId a = triangle[k], b = triangle[(k + 1) % 3];
              if (cell[a] >> below == partition)
              {
                surface[a] = 1;
                if (cell[a] == cell[b])
                {
                  Join(root, a, b);
                }
              }
            }
          }
        }
      });
    // Coincident vertices form a chain in the order of the cells, so that those of any cell, of any
    // depth, are a connected part of it.
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
        coincident.emplace_back(previous, v);
      }
      previous = v;
    }
  }

  // Gives every vertex its finest cluster; returns where each cell's clusters begin.
  std::vector<VertexId> NumberFinest(
    std::vector<VertexId>& root, const std::vector<std::uint8_t>& surface)
  {
    const std::size_t cells = this->Tree.cellBegin.size() - 1;
    std::vector<VertexId> clusterBegin(cells + 1, 0);
    this->Output.finest.resize(this->Points.size());
    this->Exec.parallelFor(cells, grain / 8,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t c = begin; c < end; ++c)
        {
          clusterBegin[c + 1] = static_cast<VertexId>(GroupCell(
            this->Tree.Cell(this->Tree.depths.finest, c), this->Options.sheets,
            [&](VertexId v) { return FindRoot(root, v); },
            [&](VertexId v) {
              return Sheet{ 1, this->Relative(v), surface[v] != 0, 0 };
            },
            [&](VertexId v, std::size_t local)
            { this->Output.finest[v] = static_cast<VertexId>(local); }));
        }
      });
    std::partial_sum(clusterBegin.begin(), clusterBegin.end(), clusterBegin.begin());
    this->Work.cellOf.resize(clusterBegin.back());
    for (std::size_t c = 0; c < cells; ++c)
    {
      for (const VertexId v : this->Tree.Cell(this->Tree.depths.finest, c))
      {
        this->Output.finest[v] += clusterBegin[c];
      }
      std::fill(this->Work.cellOf.data() + clusterBegin[c],
        this->Work.cellOf.data() + clusterBegin[c + 1], static_cast<std::uint32_t>(c));
    }
    return clusterBegin;
  }

  // Adds up vertices (ascending id) and triangles (ascending number) of each finest cluster.
  void SumFinest(
    const std::vector<VertexId>& clusterBegin, const std::vector<std::uint8_t>& surface)
  {
    this->Work.clusters.assign(clusterBegin.back(), {});
    const unsigned below = this->Tree.depths.finest - this->Tree.depths.partition;
    this->Exec.parallelFor(this->Buckets.begin.size() - 1, 1,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t partition = begin; partition < end; ++partition)
        {
          for (std::size_t c = partition << below; c < (partition + 1) << below; ++c)
          {
            this->SumVertices(c, surface);
          }
          this->SumTriangles(
            partition, clusterBegin[partition << below], clusterBegin[(partition + 1) << below]);
        }
      });
  }

  void SumVertices(std::size_t cell, const std::vector<std::uint8_t>& surface)
  {
    for (const VertexId v : this->Tree.Cell(this->Tree.depths.finest, cell))
    {
      Cluster& cluster = this->Work.clusters[this->Output.finest[v]];
      const Vec3 p = this->Relative(v);
      cluster.box.Add(this->Points[v]);
      cluster.squares += p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
      for (std::size_t k = 0; k < 3; ++k)
      {
        cluster.sum[k] += p[k];
      }
      ++cluster.count;
      cluster.lowest = std::min(cluster.lowest, v);
      cluster.surface |= surface[v] != 0;
    }
  }

  // Adds each triangle's plane once to each of its clusters in [firstCluster, endCluster), those of
  // the partition.
  void SumTriangles(std::size_t partition, VertexId firstCluster, VertexId endCluster)
  {
    for (const std::uint32_t t : this->Buckets.Of(partition))
    {
      const Triangle& triangle = this->Triangles[t];
      Quadric quadric;
      quadric.AddTriangle(
        this->Relative(triangle[0]), this->Relative(triangle[1]), this->Relative(triangle[2]));
      VertexId done[3] = { noVertex, noVertex, noVertex };
      for (std::size_t k = 0; k < 3; ++k)
      {
        const VertexId cluster = this->Output.finest[triangle[k]];
        if (cluster >= firstCluster && cluster < endCluster && cluster != done[0] &&
            cluster != done[1])
        {
          this->Work.clusters[cluster].quadric.Add(quadric);
        }
        done[k] = cluster;
      }
    }
  }

  // Makes level `depth` from level depth + 1.
  void BuildCoarser(unsigned depth)
  {
    ClusterLevel& below = this->Output.levels[depth + 1];
    const Workspace children = std::move(this->Work);
    this->Work = {};
    std::vector<VertexId> root(children.clusters.size());
    std::iota(root.begin(), root.end(), VertexId{ 0 });
    const auto join = [&](VertexId a, VertexId b)
    {
      if (children.cellOf[a] >> 1 == children.cellOf[b] >> 1)
      {
        Join(root, a, b);
      }
    };
    for (const Triangle& t : below.triangles)
    {
      join(t[0], t[1]);
      join(t[1], t[2]);
      join(t[2], t[0]);
    }
    for (const Link& link : children.collapsed)
    {
      join(link.first, link.second);
    }
    this->NumberCoarser(depth, children, root, below.parents);
    this->FinishLevel(depth);
    this->Output.levels[depth].triangles =
      ImageOfTriangles(below.triangles, below.parents, this->Exec);
    this->CollectLinks(below.triangles, children.collapsed, below.parents);
  }

  // Groups the children of each cell at `depth` and adds them up, by lowest id.
  void NumberCoarser(unsigned depth, const Workspace& children, std::vector<VertexId>& root,
    std::vector<VertexId>& parents)
  {
    parents.resize(children.clusters.size());
    const std::size_t most =
      std::min(children.clusters.size(), (this->Options.sheets ? mostSheets : 1) << depth);
    this->Work.clusters.reserve(most);
    this->Work.cellOf.reserve(most);
    std::vector<VertexId> members;
    for (std::size_t first = 0; first < children.clusters.size();)
    {
      const std::uint32_t cell = children.cellOf[first] >> 1;
      std::size_t end = first;
      members.clear();
      while (end < children.clusters.size() && children.cellOf[end] >> 1 == cell)
      {
        members.push_back(static_cast<VertexId>(end++));
      }
      std::sort(members.begin(), members.end(),
        [&](VertexId a, VertexId b)
        { return children.clusters[a].lowest < children.clusters[b].lowest; });
      const std::size_t offset = this->Work.clusters.size();
      const std::size_t count = GroupCell(
        members, this->Options.sheets, [&](VertexId m) { return FindRoot(root, m); },
        [&](VertexId m)
        {
          const Cluster& c = children.clusters[m];
          return Sheet{ c.count, c.sum, c.surface, 0 };
        },
        [&](VertexId m, std::size_t local) { parents[m] = static_cast<VertexId>(offset + local); });
      this->Work.clusters.resize(offset + count);
      this->Work.cellOf.resize(offset + count, cell);
      for (const VertexId m : members)
      {
        this->AddChild(this->Work.clusters[parents[m]], children.clusters[m]);
      }
      first = end;
    }
  }

  static void AddChild(Cluster& cluster, const Cluster& child)
  {
    cluster.count += child.count;
    cluster.squares += child.squares;
    for (std::size_t k = 0; k < 3; ++k)
    {
      cluster.sum[k] += child.sum[k];
    }
    cluster.box.Add(child.box);
    cluster.quadric.Add(child.quadric);
    cluster.deviation = std::max(cluster.deviation, child.deviation);
    cluster.lowest = std::min(cluster.lowest, child.lowest);
    cluster.surface |= child.surface;
  }

  // Representatives and deviations of the clusters in Work.
  void FinishLevel(unsigned depth)
  {
    ClusterLevel& level = this->Output.levels[depth];
    const std::size_t count = this->Work.clusters.size();
    level.positions.resize(count);
    level.deviations.resize(count);
    level.lowest.resize(count);
    this->Exec.parallelFor(count, grain,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t i = begin; i < end; ++i)
        {
          Cluster& cluster = this->Work.clusters[i];
          const Vec3 x = this->RepresentativeOf(cluster);
          level.positions[i] = x;
          for (double& value : level.positions[i])
          {
            value += 0.0; // no -0.0, whose sign would depend on which vertex the box met first
          }
          cluster.deviation = std::max(cluster.deviation, this->DeviationAt(cluster, x));
          level.deviations[i] = cluster.deviation;
          level.lowest[i] = cluster.lowest;
        }
      });
  }

  // Inside the box of the cluster's vertices, so that what lies in a plane or in one place stays
  // there exactly.
  Vec3 RepresentativeOf(const Cluster& cluster) const
  {
    const auto n = static_cast<double>(cluster.count);
    Vec3 x{ cluster.sum[0] / n, cluster.sum[1] / n, cluster.sum[2] / n };
    if (this->Options.representative == Representative::Quadric)
    {
      x = cluster.quadric.Minimum(x, regularisation);
    }
    for (std::size_t k = 0; k < 3; ++k)
    {
      x[k] = std::clamp(x[k] + this->Centre[k], cluster.box.lo[k], cluster.box.hi[k]);
    }
    return x;
  }

  double DeviationAt(const Cluster& cluster, const Vec3& position) const
  {
    const Vec3 x{ position[0] - this->Centre[0], position[1] - this->Centre[1],
      position[2] - this->Centre[2] };
    const double trace = cluster.quadric.Trace();
    if (trace > 0)
    {
      return std::sqrt(cluster.quadric.At(x) / trace);
    }
    // The mean squared distance of the vertices to x.
    const auto n = static_cast<double>(cluster.count);
    double mean = cluster.squares / n;
    for (std::size_t k = 0; k < 3; ++k)
    {
      mean += x[k] * x[k] - 2 * x[k] * cluster.sum[k] / n;
    }
    return std::sqrt(std::max(mean, 0.0));
  }

  // The pairs of clusters that are linked but share no triangle of the level: images of collapsed
  // triangles, and of pairs that were linked so below.
  void CollectLinks(
    std::span<const Triangle> triangles, std::span<const Link> links, std::span<const VertexId> map)
  {
    std::vector<Link>& collapsed = this->Work.collapsed;
    const auto add = [&](VertexId a, VertexId b)
    {
      if (a != b)
      {
        collapsed.emplace_back(std::min(a, b), std::max(a, b));
      }
    };
    for (const Triangle& t : triangles)
    {
      const VertexId a = map[t[0]], b = map[t[1]], c = map[t[2]];
      if (a == b || b == c || c == a)
      {
        add(a, a == b ? c : b);
      }
    }
    for (const Link& link : links)
    {
      add(map[link.first], map[link.second]);
    }
    std::sort(collapsed.begin(), collapsed.end());
    collapsed.erase(std::unique(collapsed.begin(), collapsed.end()), collapsed.end());
  }

  std::span<const Vec3> Points;
  std::span<const Triangle> Triangles;
  const KdTree& Tree;
  const TriangleBuckets& Buckets;
  const ClusterOptions& Options;
  const Execution& Exec;
  Vec3 Centre{};
  Workspace Work;
  ClusterLevels Output;
};

}

Result<ClusterLevels> BuildClusterLevels(std::span<const Vec3> points,
  std::span<const Triangle> triangles, const KdTree& tree,
  const TriangleBuckets& partitionTriangles, const ClusterOptions& options,
  const Execution& execution)
{
  return LevelBuilder(points, triangles, tree, partitionTriangles, options, execution).Build();
}

Triangle RotateLowestFirst(const Triangle& t)
{
  return std::min({ t, Triangle{ t[1], t[2], t[0] }, Triangle{ t[2], t[0], t[1] } });
}

std::vector<Triangle> ImageOfTriangles(
  std::span<const Triangle> triangles, std::span<const VertexId> map, const Execution& execution)
{
  // Each chunk keeps its own image, sorted; the chunks are merged pairwise. The result does not
  // depend on how many there are.
  constexpr std::size_t chunk = std::size_t{ 1 } << 20;
  const std::size_t chunks = (triangles.size() + chunk - 1) / chunk;
  std::vector<std::vector<Triangle>> images(chunks);
  execution.parallelFor(chunks, 1,
    [&](std::size_t begin, std::size_t end)
    {
      for (std::size_t i = begin; i < end; ++i)
      {
        std::vector<Triangle>& image = images[i];
        for (const Triangle& t :
          triangles.subspan(i * chunk, std::min(chunk, triangles.size() - i * chunk)))
        {
          const Triangle mapped{ map[t[0]], map[t[1]], map[t[2]] };
          if (mapped[0] != mapped[1] && mapped[1] != mapped[2] && mapped[2] != mapped[0])
          {
            image.push_back(RotateLowestFirst(mapped));
          }
        }
        std::sort(image.begin(), image.end());
        image.erase(std::unique(image.begin(), image.end()), image.end());
      }
    });
  for (std::size_t width = 1; width < chunks; width *= 2)
  {
    execution.parallelFor((chunks + 2 * width - 1) / (2 * width), 1,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t i = 2 * width * begin; i < 2 * width * end && i + width < chunks;
             i += 2 * width)
        {
          std::vector<Triangle> merged;
          merged.reserve(images[i].size() + images[i + width].size());
          std::set_union(images[i].begin(), images[i].end(), images[i + width].begin(),
            images[i + width].end(), std::back_inserter(merged));
          images[i] = std::move(merged);
          images[i + width] = {};
        }
      });
  }
  return chunks == 0 ? std::vector<Triangle>{} : std::move(images[0]);
}

}
