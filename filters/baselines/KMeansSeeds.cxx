// SPDX-License-Identifier: BSD-3-Clause
#include "filters/baselines/KMeansSurface.h"

#include "filters/baselines/FaceClustering.h"
#include "filters/core/DisjointSets.h"
#include "filters/core/VectorMath.h"
#include "filters/core/tree/KdTree.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <numeric>
#include <span>
#include <tuple>

namespace kdstream
{
namespace
{

// The parts of a surface that are large enough for seeds of their own.
struct LargeParts
{
  std::vector<bool> vertices;      // the vertices of large parts
  std::vector<Triangle> triangles; // the triangles of large parts
  std::size_t count = 0;           // number of vertices
};

// The components with at least half the vertices of a mean cluster.
LargeParts FindLargeParts(const KMeansSurface& surface, std::uint32_t clusters)
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

// The `count` clusters with the most triangles; if several have as many, the lowest.
std::vector<bool> FindFullest(const FaceClustering& faces, std::uint32_t count)
{
  std::vector<std::uint32_t> size(faces.clusters, 0);
  for (const std::uint32_t c : faces.clusterOf)
  {
    ++size[c];
  }
  std::vector<std::uint32_t> fullest(faces.clusters);
  std::iota(fullest.begin(), fullest.end(), 0);
  std::stable_sort(fullest.begin(), fullest.end(),
    [&](std::uint32_t a, std::uint32_t b) { return size[a] > size[b]; });
  fullest.resize(std::min<std::size_t>(fullest.size(), count));
  std::vector<bool> isFullest(faces.clusters, false);
  for (const std::uint32_t c : fullest)
  {
    isFullest[c] = true;
  }
  return isFullest;
}

// A list of seeds without duplicates.
class Seeds
{
public:
  explicit Seeds(const KMeansSurface& surface)
    : Mesh(surface)
    , Taken(surface.points.size(), false)
  {
  }

  // Adds a seed for each of `count` clusters of the triangles; for the fullest ones if there are
  // more.
  Status AddOnFaces(
    std::span<const Triangle> triangles, std::uint32_t count, const Execution& execution)
  {
    const Result<FaceClustering> faces =
      ClusterFaces(this->Mesh.points, triangles, count, execution);
    KDSTREAM_TRY(faces);
    std::vector<bool> wanted = FindFullest(*faces, count);
    for (const Corner& corner : this->CornersByDistance(triangles, *faces))
    {
      if (wanted[corner.cluster] && !this->Taken[corner.vertex])
      {
        wanted[corner.cluster] = false;
        this->Add(corner.vertex);
      }
    }
    return {};
  }

  // Adds `count` vertices that are not seeds yet, spaced evenly along the order of a k-d tree. They
  // are outside `parts` if there are enough vertices there.
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
  // A corner of a triangle in a cluster, and its distance from the cluster's middle.
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

  // The corners of each cluster, nearest first.
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

  const KMeansSurface& Mesh;
  std::vector<bool> Taken;
  std::vector<VertexId> Chosen;
};

}

Result<std::vector<VertexId>> SpreadSeeds(
  const KMeansSurface& surface, std::uint32_t clusters, const Execution& execution)
{
  const LargeParts large = FindLargeParts(surface, clusters);
  Seeds seeds(surface);
  if (large.count > 0)
  {
    const double share = double(large.count) / double(surface.points.size()) * clusters;
    const auto count = static_cast<std::uint32_t>(std::max(1.0, std::floor(share + 0.5)));
    KDSTREAM_TRY(seeds.AddOnFaces(large.triangles, count, execution));
  }
  KDSTREAM_TRY(seeds.AddLoose(large.vertices, clusters - seeds.Get().size(), execution));
  return seeds.Get();
}

}
