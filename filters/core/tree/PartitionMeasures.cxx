// SPDX-License-Identifier: BSD-3-Clause
// Partition measures: see PartitionMeasures.h. Steps:
// 1. Compute counts and areas, and list the edges of the triangles of every partition.
// 2. Sort edges by (ends, partition): edges that occur only once are on the boundary.
// 3. Compute compactness and statistics.
#include "filters/core/tree/PartitionMeasures.h"

#include "filters/core/VectorMath.h"
#include "filters/core/Weld.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <tuple>

namespace kdstream
{
namespace
{

// An edge of a triangle, with the partition of that triangle.
struct PartitionEdge
{
  VertexId a, b; // a < b
  std::uint32_t partition;
  bool operator==(const PartitionEdge&) const = default;
  bool operator<(const PartitionEdge& other) const
  {
    return std::tie(this->a, this->b, this->partition) <
           std::tie(other.a, other.b, other.partition);
  }
};

double TriangleArea(const Vec3& p, const Vec3& q, const Vec3& r)
{
  return Length(Cross(Minus(q, p), Minus(r, p))) / 2;
}

// Moves the points to the origin, and scales them to an extent of 1 to 2, so that squares are in
// the range of doubles. unit: gets the scale, a power of two, so that only the translation rounds.
Result<std::vector<Vec3>> Scale(std::span<const Vec3> points, double& unit)
{
  const Box box = BoxOfPoints(points);
  double side = 0;
  for (std::size_t k = 0; k < 3 && !box.Empty(); ++k)
  {
    side = std::max(side, box.hi[k] - box.lo[k]);
  }
  if (!std::isfinite(side))
  {
    return Error{ ErrorCode::InvalidInput, "the mesh's extent exceeds the range of doubles" };
  }
  const int exponent = side > 0 ? std::ilogb(side) : 0;
  unit = std::ldexp(1, exponent);
  std::vector<Vec3> scaled(points.begin(), points.end());
  for (Vec3& p : scaled)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      p[k] = std::ldexp(p[k] - box.lo[k], -exponent);
    }
  }
  return scaled;
}

// Adds counts and areas. Returns the edges of triangles whose corners are in three different
// places.
std::vector<PartitionEdge> AddTriangles(std::span<const Vec3> points,
  std::span<const Triangle> triangles, const Clustering& clustering,
  std::vector<PartitionMeasure>& partitions)
{
  const std::vector<VertexId> place = FirstCoincident(points, Coincidence::ValueEqual);
  std::vector<PartitionEdge> edges;
  edges.reserve(3 * triangles.size());
  for (const Triangle& t : triangles)
  {
    std::array<std::uint32_t, 3> touched{ clustering.clusterOf[t[0]], clustering.clusterOf[t[1]],
      clustering.clusterOf[t[2]] };
    std::sort(touched.begin(), touched.end());
    const auto end = std::unique(touched.begin(), touched.end());
    ++partitions[touched[0]].ownTriangles;
    const VertexId corners[] = { place[t[0]], place[t[1]], place[t[2]] };
    const bool degenerate = IsDegenerate({ corners[0], corners[1], corners[2] });
    const double area = TriangleArea(points[t[0]], points[t[1]], points[t[2]]);
    for (auto partition = touched.begin(); partition != end; ++partition)
    {
      ++partitions[*partition].triangles;
      partitions[*partition].area += area;
      for (std::size_t k = 0; k < 3 && !degenerate; ++k)
      {
        const auto [a, b] = std::minmax(corners[k], corners[(k + 1) % 3]);
        edges.push_back({ a, b, *partition });
      }
    }
  }
  return edges;
}

void AddBoundaries(std::span<const Vec3> points, std::vector<PartitionEdge>& edges,
  std::vector<PartitionMeasure>& partitions)
{
  std::sort(edges.begin(), edges.end());
  for (std::size_t i = 0; i < edges.size();)
  {
    std::size_t end = i + 1;
    while (end < edges.size() && edges[end] == edges[i])
    {
      ++end;
    }
    if (end - i == 1)
    {
      partitions[edges[i].partition].boundaryLength +=
        Length(Minus(points[edges[i].a], points[edges[i].b]));
    }
    i = end;
  }
}

// Eq. (1), NaN without area or boundary.
double CompactnessOf(const PartitionMeasure& partition)
{
  const double compactness =
    partition.boundaryLength * partition.boundaryLength / (4 * std::numbers::pi * partition.area);
  return partition.area > 0 && partition.boundaryLength > 0 && std::isfinite(compactness)
           ? compactness
           : std::numeric_limits<double>::quiet_NaN();
}

}

Spread SpreadOf(std::span<const double> values)
{
  Spread spread;
  if (values.empty())
  {
    return spread;
  }
  const auto count = static_cast<double>(values.size());
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  spread.minimum = *least;
  spread.maximum = *most;
  for (const double value : values)
  {
    spread.mean += value / count;
  }
  double squares = 0;
  for (const double value : values)
  {
    squares += (value - spread.mean) * (value - spread.mean) / count;
  }
  spread.standardDeviation = std::sqrt(squares);
  if (spread.maximum > 0)
  {
    spread.ratio = spread.minimum > 0 ? spread.maximum / spread.minimum
                                      : std::numeric_limits<double>::infinity();
  }
  return spread;
}

Result<PartitionMeasures> MeasurePartitions(std::span<const Vec3> points,
  std::span<const Triangle> triangles, const Clustering& clustering, const Execution& execution)
{
  KDSTREAM_TRY(CheckClustering(points.size(), clustering));
  double unit = 1;
  const Result<std::vector<Vec3>> scaled = Scale(points, unit);
  KDSTREAM_TRY(scaled);
  PartitionMeasures result;
  std::vector<PartitionMeasure>& partitions = result.partitions;
  partitions.resize(clustering.clusters);
  for (const std::uint32_t cluster : clustering.clusterOf)
  {
    ++partitions[cluster].vertices;
  }
  std::vector<PartitionEdge> edges = AddTriangles(*scaled, triangles, clustering, partitions);
  KDSTREAM_TRY(execution.Report("measures", 0.3));
  AddBoundaries(*scaled, edges, partitions);

  std::vector<double> vertices, counts, compactness;
  for (PartitionMeasure& partition : partitions)
  {
    partition.compactness = CompactnessOf(partition);
    if (!std::isnan(partition.compactness))
    {
      compactness.push_back(partition.compactness);
    }
    partition.boundaryLength *= unit;
    partition.area *= unit * unit;
    vertices.push_back(static_cast<double>(partition.vertices));
    counts.push_back(static_cast<double>(partition.triangles));
  }
  result.vertices = SpreadOf(vertices);
  result.triangles = SpreadOf(counts);
  result.compactness = SpreadOf(compactness);
  result.measured = compactness.size();
  KDSTREAM_TRY(execution.Report("measures", 1));
  return result;
}

}
