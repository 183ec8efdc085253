// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/FoldOvers.h"

#include "filters/core/NearestPoint.h"
#include "filters/core/SortTriangles.h"
#include "filters/core/VectorMath.h"

#include <algorithm>
#include <map>
#include <optional>

namespace kdstream::fixtures
{
namespace
{

constexpr double leastAgreement = 0.25; // length of the sum of its area vectors / its area

// Twice the area vector.
Vec3 NormalOf(const std::vector<Vec3>& points, const Triangle& t)
{
  return Cross(Minus(points[t[1]], points[t[0]]), Minus(points[t[2]], points[t[0]]));
}

void AddTo(Vec3& sum, const Vec3& vector)
{
  sum = Plus(sum, vector);
}

// The direction that each triangle of a level should face.
class References
{
public:
  References(const Mesh& mesh, const std::vector<VertexId>& clusterOf, const ClusterLevel& level)
    : Clusters(level.positions.size(), Vec3{})
  {
    std::vector<double> areas(this->Clusters.size(), 0);
    for (const Triangle& t : mesh.triangles)
    {
      const Vec3 normal = NormalOf(mesh.points, t);
      const Triangle image{ clusterOf[t[0]], clusterOf[t[1]], clusterOf[t[2]] };
      for (std::size_t k = 0; k < 3; ++k)
      {
        if ((k == 0 || image[k] != image[0]) && (k < 2 || image[2] != image[1]))
        {
          AddTo(this->Clusters[image[k]], normal);
          areas[image[k]] += Length(normal);
        }
      }
      if (image[0] != image[1] && image[1] != image[2] && image[2] != image[0])
      {
        AddTo(this->Own.try_emplace(RotateLowestFirst(image)).first->second, normal);
      }
    }
    for (std::size_t c = 0; c < areas.size(); ++c)
    {
      if (Length(this->Clusters[c]) < leastAgreement * areas[c])
      {
        this->Clusters[c] = {};
      }
    }
  }

  Vec3 Of(const Triangle& t) const
  {
    const auto own = this->Own.find(RotateLowestFirst(t));
    Vec3 sum = own == this->Own.end() ? Vec3{} : own->second;
    for (const VertexId corner : t)
    {
      AddTo(sum, this->Clusters[corner]);
    }
    return sum;
  }

private:
  std::vector<Vec3> Clusters;
  std::map<Triangle, Vec3> Own; // by the triangle that they become
};

// The normals of the vertices that have one.
class NearestNormals
{
public:
  explicit NearestNormals(const Mesh& mesh)
  {
    std::vector<Vec3> normals(mesh.points.size(), Vec3{});
    for (const Triangle& t : mesh.triangles)
    {
      const Vec3 normal = NormalOf(mesh.points, t);
      std::for_each(t.begin(), t.end(), [&](VertexId v) { AddTo(normals[v], normal); });
    }
    for (std::size_t v = 0; v < normals.size(); ++v)
    {
      if (Dot(normals[v], normals[v]) > 0)
      {
        this->Points.push_back(mesh.points[v]);
        this->Normals.push_back(normals[v]);
      }
    }
    this->Nearest.emplace(this->Points);
  }

  // REQUIRES: at least one vertex has a normal.
  const Vec3& At(const Vec3& p) const { return this->Normals[this->Nearest->Find(p)]; }
  bool Empty() const { return this->Points.empty(); }

private:
  std::vector<Vec3> Points, Normals;
  std::optional<NearestPoint> Nearest;
};

FoldOverCount CountLevel(
  const ClusterLevel& level, const References& references, const NearestNormals& nearest)
{
  FoldOverCount count;
  double all = 0;
  for (const Triangle& t : level.triangles)
  {
    const Vec3 normal = NormalOf(level.positions, t);
    const double area = Length(normal);
    all += area;
    ++count.triangles;
    if (Dot(normal, references.Of(t)) < 0)
    {
      ++count.opposed;
      count.opposedArea += area;
    }
    const Vec3 centre = Times(
      Plus(Plus(level.positions[t[0]], level.positions[t[1]]), level.positions[t[2]]), 1.0 / 3);
    count.opposedNearest += !nearest.Empty() && Dot(normal, nearest.At(centre)) < 0;
  }
  count.opposedArea /= all > 0 ? all : 1;
  return count;
}

}

std::vector<FoldOverCount> CountFoldOvers(const Mesh& mesh, const ClusterLevels& levels)
{
  const NearestNormals nearest(mesh);
  std::vector<FoldOverCount> counts(levels.levels.size());
  std::vector<VertexId> clusterOf = levels.finest;
  for (std::size_t depth = levels.levels.size(); depth-- > 0;)
  {
    const ClusterLevel& level = levels.levels[depth];
    if (level.positions.empty())
    {
      break;
    }
    counts[depth] = CountLevel(level, { mesh, clusterOf, level }, nearest);
    for (VertexId& cluster : clusterOf)
    {
      cluster = level.parents.empty() ? cluster : level.parents[cluster];
    }
  }
  return counts;
}

}
