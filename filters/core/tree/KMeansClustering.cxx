// K-means clustering: see KMeansClustering.h. Steps:
//   a. points to a box of side 1, vertices in one place to their lowest,
//   b. seeds from hierarchical face clustering,
//   c. five times: all clusters grow from their seeds over the graph of edges; new seeds,
//   d. numbers by first vertices.
#include "filters/core/tree/KMeansClustering.h"

#include "filters/core/DisjointSets.h"
#include "filters/core/Extent.h"
#include "filters/core/NearestPoint.h"
#include "filters/core/Weld.h"
#include "filters/core/tree/FaceClustering.h"
#include "filters/core/tree/KdTree.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <numbers>
#include <queue>
#include <string>
#include <tuple>

namespace kdstream
{
namespace
{

constexpr std::uint32_t noCluster = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t neighboursLookedAt = 16;
constexpr double greatestWeight = 1e6;

double SquaredDistance(const Vec3& a, const Vec3& b)
{
  const Vec3 d{ a[0] - b[0], a[1] - b[1], a[2] - b[2] };
  return d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
}

double Area(const Vec3& p, const Vec3& q, const Vec3& r)
{
  const Vec3 u{ q[0] - p[0], q[1] - p[1], q[2] - p[2] };
  const Vec3 v{ r[0] - p[0], r[1] - p[1], r[2] - p[2] };
  const Vec3 n{ u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0] };
  return std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) / 2;
}

// The mesh in the unit cube, so that no cost depends on units or offsets.
struct Surface
{
  std::vector<Vec3> points;
  std::vector<Triangle> triangles; // corners are the lowest vertices of their places
  std::vector<VertexId> place;     // of each vertex: the lowest in the same place
};

Result<Surface> MakeSurface(std::span<const Vec3> points, std::span<const Triangle> triangles)
{
  const Box box = BoxOfPoints(points);
  KDSTREAM_TRY(CheckExtent(box));
  double side = 0;
  for (std::size_t k = 0; k < 3; ++k)
  {
    side = std::max(side, box.hi[k] - box.lo[k]);
  }
  Surface surface;
  surface.place = FirstCoincident(points, Coincidence::ValueEqual);
  surface.points.reserve(points.size());
  for (const Vec3& p : points)
  {
    Vec3 scaled{};
    for (std::size_t k = 0; k < 3; ++k)
    {
      scaled[k] = side > 0 ? (p[k] - box.lo[k]) / side : 0;
    }
    surface.points.push_back(scaled);
  }
  surface.triangles.reserve(triangles.size());
  for (const Triangle& t : triangles)
  {
    surface.triangles.push_back({ surface.place[t[0]], surface.place[t[1]], surface.place[t[2]] });
  }
  return surface;
}

// The neighbours of each vertex along edges; vertices in one place are a chain of edges of length
// 0.
class Graph
{
public:
  explicit Graph(const Surface& surface)
    : Begin(surface.points.size() + 1, 0)
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
    std::vector<VertexId> last(surface.points.size());
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

  std::span<const VertexId> Neighbours(VertexId v) const
  {
    return { this->Ends.data() + this->Begin[v], this->Ends.data() + this->Begin[v + 1] };
  }
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

// Grows clusters from seeds, always the cheapest vertex next.
class Growth
{
public:
  Growth(const Surface& surface, const KMeansOptions& options, std::uint32_t clusters)
    : Mesh(surface)
    , Edges(surface)
    , Cluster(surface.points.size())
    , Distance(surface.points.size())
    , Size(clusters)
  {
    const auto vertices = static_cast<double>(surface.points.size());
    double area = 0;
    for (const Triangle& t : surface.triangles)
    {
      area += Area(surface.points[t[0]], surface.points[t[1]], surface.points[t[2]]);
    }
    double radius = std::sqrt(area / (std::numbers::pi * clusters));
    if (!(radius > 0))
    {
      radius = this->Edges.MeanEdgeLength() * std::sqrt(vertices / clusters);
    }
    this->PerLength = options.distanceWeight / (radius > 0 ? radius : 1);
    this->PerGap = options.compactnessWeight * this->PerLength * this->Edges.MeanEdgeLength();
    this->PerVertex = options.countWeight * clusters / vertices;
  }

  // The clusters around the seeds, of which there is one a cluster, all different.
  const std::vector<std::uint32_t>& Grow(const std::vector<VertexId>& seeds)
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

  void Take(const Candidate& taken)
  {
    this->Cluster[taken.vertex] = taken.cluster;
    this->Distance[taken.vertex] = taken.distance;
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

  void TakeUnreached(const std::vector<VertexId>& seeds)
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

  const Surface& Mesh;
  Graph Edges;
  std::vector<std::uint32_t> Cluster;
  std::vector<double> Distance;
  std::vector<std::uint32_t> Size;
  std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>> Front;
  double PerLength = 0, PerGap = 0, PerVertex = 0;
};

// For each cluster the vertex nearest to the mean of its vertices, the lowest of equals.
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

// The parts of a surface that deserve seeds of their own.
struct LargeParts
{
  std::vector<bool> vertices;      // which belong to them
  std::vector<Triangle> triangles; // of them
  std::size_t count = 0;           // of vertices
};

// The components of at least half the vertices of a mean cluster.
LargeParts FindLargeParts(const Surface& surface, std::uint32_t clusters)
{
  std::vector<VertexId> root = surface.place;
  for (const Triangle& t : surface.triangles)
  {
    Join(root, t[0], t[1]);
    Join(root, t[1], t[2]);
  }
  std::vector<std::size_t> size(root.size(), 0);
  std::vector<bool> hasTriangle(root.size(), false);
  for (VertexId v = 0; v < root.size(); ++v)
  {
    ++size[FindRoot(root, v)];
  }
  for (const Triangle& t : surface.triangles)
  {
    hasTriangle[FindRoot(root, t[0])] = true;
  }
  const auto isLarge = [&](VertexId v)
  {
    const VertexId of = FindRoot(root, v);
    return hasTriangle[of] && 2.0 * double(size[of]) * clusters >= double(root.size());
  };
  LargeParts parts;
  parts.vertices.reserve(root.size());
  for (VertexId v = 0; v < root.size(); ++v)
  {
    parts.vertices.push_back(isLarge(v));
    parts.count += parts.vertices.back();
  }
  std::copy_if(surface.triangles.begin(), surface.triangles.end(),
    std::back_inserter(parts.triangles), [&](const Triangle& t) { return isLarge(t[0]); });
  return parts;
}

// Seeds, one after the other, none twice.
class Seeds
{
public:
  explicit Seeds(const Surface& surface)
    : Mesh(surface)
    , Taken(surface.points.size(), false)
  {
  }

  // One for each of `count` clusters of the triangles, the fullest if there are more.
  Status AddOnFaces(
    std::span<const Triangle> triangles, std::uint32_t count, const Execution& execution)
  {
    const Result<FaceClustering> faces =
      ClusterFaces(this->Mesh.points, triangles, count, execution);
    KDSTREAM_TRY(faces);
    const std::vector<Corner> corners = this->CornersByDistance(triangles, *faces);
    std::vector<std::uint32_t> size(faces->clusters, 0);
    for (const std::uint32_t c : faces->clusterOf)
    {
      ++size[c];
    }
    std::vector<std::uint32_t> fullest(faces->clusters);
    for (std::uint32_t c = 0; c < faces->clusters; ++c)
    {
      fullest[c] = c;
    }
    std::stable_sort(fullest.begin(), fullest.end(),
      [&](std::uint32_t a, std::uint32_t b) { return size[a] > size[b]; });
    fullest.resize(std::min<std::size_t>(fullest.size(), count));
    std::vector<bool> wanted(faces->clusters, false);
    for (const std::uint32_t c : fullest)
    {
      wanted[c] = true;
    }
    for (const Corner& corner : corners)
    {
      if (wanted[corner.cluster] && !this->Taken[corner.vertex])
      {
        wanted[corner.cluster] = false;
        this->Add(corner.vertex);
      }
    }
    return {};
  }

  // `count` of the vertices that are no seeds yet, spaced evenly along the order of a k-d tree: of
  // those that are not in `parts`, if they are enough.
  Status AddLoose(const std::vector<bool>& parts, std::size_t count, const Execution& execution)
  {
    if (count == 0)
    {
      return {};
    }
    std::vector<bool> used = parts;
    std::transform(
      used.begin(), used.end(), this->Taken.begin(), used.begin(), std::logical_or<>());
    if (std::size_t(std::count(used.begin(), used.end(), false)) < count)
    {
      used = this->Taken;
    }
    std::vector<VertexId> loose;
    std::vector<Vec3> points;
    for (VertexId v = 0; v < used.size(); ++v)
    {
      if (!used[v])
      {
        loose.push_back(v);
        points.push_back(this->Mesh.points[v]);
      }
    }
    KdTreeOptions options;
    options.verticesPerPartition = options.cellVertices = 8;
    Execution quiet = execution;
    quiet.progress = [&](std::string_view, double) { return execution.progress("seeds", 1); };
    const Result<KdTree> tree = BuildKdTree(points, options, quiet);
    KDSTREAM_TRY(tree);
    for (std::size_t i = 0; i < count; ++i)
    {
      this->Add(loose[tree->order[(2 * i + 1) * loose.size() / (2 * count)]]);
    }
    return {};
  }

  const std::vector<VertexId>& Get() const { return this->Chosen; }

private:
  // A corner of a triangle of a cluster, and how far it is from the cluster's middle.
  struct Corner
  {
    std::uint32_t cluster;
    double squared;
    VertexId vertex;
    bool operator<(const Corner& other) const
    {
      return std::tie(this->cluster, this->squared, this->vertex) <
             std::tie(other.cluster, other.squared, other.vertex);
    }
  };

  // Of all clusters, nearest first.
  std::vector<Corner> CornersByDistance(
    std::span<const Triangle> triangles, const FaceClustering& faces) const
  {
    std::vector<Vec3> middle(faces.clusters, Vec3{});
    std::vector<double> count(faces.clusters, 0);
    for (std::size_t i = 0; i < triangles.size(); ++i)
    {
      for (const VertexId v : triangles[i])
      {
        ++count[faces.clusterOf[i]];
        for (std::size_t k = 0; k < 3; ++k)
        {
          middle[faces.clusterOf[i]][k] += this->Mesh.points[v][k];
        }
      }
    }
    std::vector<Corner> corners;
    corners.reserve(3 * triangles.size());
    for (std::size_t i = 0; i < triangles.size(); ++i)
    {
      const std::uint32_t c = faces.clusterOf[i];
      const Vec3 mean{ middle[c][0] / count[c], middle[c][1] / count[c], middle[c][2] / count[c] };
      for (const VertexId v : triangles[i])
      {
        corners.push_back({ c, SquaredDistance(this->Mesh.points[v], mean), v });
      }
    }
    std::sort(corners.begin(), corners.end());
    return corners;
  }

  void Add(VertexId vertex)
  {
    this->Taken[vertex] = true;
    this->Chosen.push_back(vertex);
  }

  const Surface& Mesh;
  std::vector<bool> Taken;
  std::vector<VertexId> Chosen;
};

Result<std::vector<VertexId>> SpreadSeeds(
  const Surface& surface, std::uint32_t clusters, const Execution& execution)
{
  const LargeParts large = FindLargeParts(surface, clusters);
  Seeds seeds(surface);
  if (large.count > 0)
  {
    const double share = double(large.count) / double(surface.points.size()) * clusters;
    const auto count = static_cast<std::uint32_t>(std::max(1.0, std::floor(share + 0.5)));
    KDSTREAM_TRY(seeds.AddOnFaces(large.triangles, count, execution));
  }
  if (Status status = seeds.AddLoose(large.vertices, clusters - seeds.Get().size(), execution);
      !status)
  {
    return status.GetError();
  }
  return seeds.Get();
}

// Numbers clusters by their first vertices.
Clustering Number(std::vector<std::uint32_t> clusterOf, std::uint32_t clusters)
{
  std::vector<std::uint32_t> number(clusters, noCluster);
  Clustering clustering;
  for (std::uint32_t& cluster : clusterOf)
  {
    if (number[cluster] == noCluster)
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
    return bad("number of iterations is 0; at least 1 is needed");
  }
  for (const double weight :
    { options.distanceWeight, options.compactnessWeight, options.countWeight })
  {
    if (!(weight >= 0 && weight <= greatestWeight) || options.distanceWeight == 0)
    {
      return bad("a weight of k-means is " + std::to_string(weight) +
                 "; weights are 0 to 1000000, that of the distance above 0");
    }
  }
  if (!options.partitions)
  {
    if (options.verticesPerPartition == 0)
    {
      return bad("vertices per partition is 0; at least 1 is needed");
    }
    return static_cast<std::uint32_t>((vertices - 1) / options.verticesPerPartition + 1);
  }
  if (*options.partitions == 0)
  {
    return bad("number of partitions is 0; at least 1 is needed");
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
  const Result<Surface> surface = MakeSurface(points, triangles);
  KDSTREAM_TRY(surface);
  Result<std::vector<VertexId>> seeds = SpreadSeeds(*surface, *clusters, execution);
  KDSTREAM_TRY(seeds);
  Growth growth(*surface, options, *clusters);
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
