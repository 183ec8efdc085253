// SPDX-License-Identifier: BSD-3-Clause
// Distances of meshes by samples: see MeshDistance.h.
//   1. Sample both meshes: choose triangles in proportion to their areas, and places in a triangle
//      uniformly.
//   2. Make a tree of boxes over each mesh's triangles (Boost.Geometry's R-tree).
//   3. For each sample visit the nearest boxes, until the next box is farther than the nearest
//      point found.
#include "filters/core/MeshDistance.h"

#include "filters/core/MixBits.h"
#include "filters/core/TriangleDistance.h"
#include "filters/core/VectorMath.h"

#include <boost/geometry.hpp>
#include <boost/geometry/geometries/box.hpp>
#include <boost/geometry/geometries/point.hpp>
#include <boost/geometry/index/rtree.hpp>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace kdstream
{
namespace
{

namespace geometry = boost::geometry;
using TreePoint = geometry::model::point<double, 3, geometry::cs::cartesian>;
using TreeBox = geometry::model::box<TreePoint>;
using Entry = std::pair<TreeBox, std::uint32_t>; // of a triangle, or of a vertex

constexpr std::size_t sampleGrain = 1024; // samples

// The box of a mesh; for a surface, only of points that its triangles use.
Box BoxOf(const Mesh& mesh)
{
  Box box;
  for (const Triangle& t : mesh.triangles)
  {
    std::for_each(t.begin(), t.end(), [&](VertexId v) { box.Add(mesh.points[v]); });
  }
  for (std::size_t v = 0; mesh.triangles.empty() && v < mesh.points.size(); ++v)
  {
    box.Add(mesh.points[v]);
  }
  return box;
}

// Pseudorandom numbers: splitmix64 (Steele, Lea and Flood, 2014).
class Random
{
public:
  explicit Random(std::uint64_t seed)
    : State(seed)
  {
  }
  // Uniform in [0, 1).
  double Next()
  {
    this->State += 0x9E3779B97F4A7C15U;
    return double(MixBits(this->State) >> 11) / double(std::uint64_t{ 1 } << 53);
  }

private:
  std::uint64_t State;
};

std::vector<Vec3> SampleMesh(const Mesh& mesh, std::size_t count, std::uint64_t seed)
{
  std::vector<double> areaUpTo;
  double area = 0;
  for (const Triangle& t : mesh.triangles)
  {
    const Vec3 u = Minus(mesh.points[t[1]], mesh.points[t[0]]);
    const Vec3 v = Minus(mesh.points[t[2]], mesh.points[t[0]]);
    area += Length(Cross(u, v)) / 2;
    areaUpTo.push_back(area);
  }
  Random random(seed);
  std::vector<Vec3> samples(count);
  for (Vec3& sample : samples)
  {
    const double where = random.Next();
    if (!(area > 0))
    {
      sample = mesh.points[static_cast<std::size_t>(where * double(mesh.points.size()))];
      continue;
    }
    const auto found = std::upper_bound(areaUpTo.begin(), areaUpTo.end(), where * area);
    const auto last = static_cast<std::ptrdiff_t>(areaUpTo.size()) - 1;
    const Triangle& t =
      mesh.triangles[static_cast<std::size_t>(std::min(found - areaUpTo.begin(), last))];
    double s = random.Next(), r = random.Next();
    if (s + r > 1) // the other half of the parallelogram
    {
      s = 1 - s;
      r = 1 - r;
    }
    for (std::size_t k = 0; k < 3; ++k)
    {
      sample[k] =
        mesh.points[t[0]][k] * (1 - s - r) + mesh.points[t[1]][k] * s + mesh.points[t[2]][k] * r;
    }
  }
  return samples;
}

// Finds the distance to the nearest place of a mesh.
class NearestPlace
{
public:
  explicit NearestPlace(const Mesh& mesh)
    : Target(mesh)
  {
    std::vector<Entry> entries;
    const std::size_t count = mesh.triangles.empty() ? mesh.points.size() : mesh.triangles.size();
    entries.reserve(count);
    for (std::size_t i = 0; i < count; ++i)
    {
      Box box;
      for (const VertexId v : this->Corners(i))
      {
        box.Add(mesh.points[v]);
      }
      entries.emplace_back(
        TreeBox{ { box.lo[0], box.lo[1], box.lo[2] }, { box.hi[0], box.hi[1], box.hi[2] } },
        static_cast<std::uint32_t>(i));
    }
    this->Tree = decltype(this->Tree)(entries);
  }

  double SquaredDistance(const Vec3& p) const
  {
    const TreePoint point(p[0], p[1], p[2]);
    const std::vector<Vec3>& at = this->Target.points;
    double nearest = std::numeric_limits<double>::infinity();
    std::vector<Entry> entries;
    for (unsigned count = 8;; count *= 4)
    {
      entries.clear();
      this->Tree.query(geometry::index::nearest(point, count), std::back_inserter(entries));
      double farthest = 0; // of the boxes seen
      for (const Entry& entry : entries)
      {
        const Triangle t = this->Corners(entry.second);
        nearest = std::min(nearest, SquaredToTriangle(p, at[t[0]], at[t[1]], at[t[2]]));
        farthest = std::max(farthest, geometry::comparable_distance(point, entry.first));
      }
      if (entries.size() < count || farthest >= nearest)
      {
        return nearest;
      }
    }
  }

private:
  Triangle Corners(std::size_t i) const
  {
    const auto v = static_cast<VertexId>(i);
    return this->Target.triangles.empty() ? Triangle{ v, v, v } : this->Target.triangles[i];
  }

  const Mesh& Target;
  geometry::index::rtree<Entry, geometry::index::rstar<8>> Tree;
};

Status CheckMesh(const Mesh& mesh, const std::string& which)
{
  const auto refuse = [&](const std::string& what) {
    return Error{ ErrorCode::InvalidArgument, "the " + which + " mesh " + what };
  };
  if (mesh.points.empty())
  {
    return refuse("has no vertices");
  }
  for (std::size_t v = 0; v < mesh.points.size(); ++v)
  {
    for (const double value : mesh.points[v])
    {
      if (!std::isfinite(value))
      {
        return refuse("has a coordinate that is not finite: vertex " + std::to_string(v));
      }
    }
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
  {
    for (const VertexId v : mesh.triangles[t])
    {
      if (v >= mesh.points.size())
      {
        return refuse("has a triangle with vertex " + std::to_string(v) + " of " +
                      std::to_string(mesh.points.size()) + ": triangle " + std::to_string(t));
      }
    }
  }
  return {};
}

// Computes the mean squared and the largest distance from samples of `from` to the mesh `to`.
Status MeasureOneWay(const Mesh& from, const Mesh& to, const MeshDistanceOptions& options,
  const Execution& execution, double progress, double& meanSquare, double& largest)
{
  const std::vector<Vec3> samples = SampleMesh(from, options.samples, options.seed);
  const NearestPlace nearest(to);
  std::vector<double> squares(samples.size());
  execution.parallelFor(samples.size(), sampleGrain,
    [&](std::size_t begin, std::size_t end)
    {
      for (std::size_t i = begin; i < end; ++i)
      {
        squares[i] = nearest.SquaredDistance(samples[i]);
      }
    });
  double sum = 0;
  largest = 0;
  for (const double square : squares)
  {
    sum += square;
    largest = std::max(largest, square);
  }
  meanSquare = sum / double(samples.size());
  return execution.Report("distance", progress);
}

}

Result<MeshDistance> MeasureDistance(const Mesh& reference, const Mesh& other,
  const MeshDistanceOptions& options, const Execution& execution)
{
  if (options.samples == 0)
  {
    return Error{ ErrorCode::InvalidArgument, "the number of samples must be at least 1, not 0" };
  }
  for (const auto& [mesh, which] :
    { std::pair(&reference, "reference"), std::pair(&other, "other") })
  {
    KDSTREAM_TRY(CheckMesh(*mesh, which));
  }
  double forward = 0, backward = 0, farthest = 0, farthestBack = 0;
  KDSTREAM_TRY(MeasureOneWay(reference, other, options, execution, 0.5, forward, farthest));
  KDSTREAM_TRY(MeasureOneWay(other, reference, options, execution, 1, backward, farthestBack));
  const Box box = BoxOf(reference);
  const Vec3 size = Minus(box.hi, box.lo);
  return MeshDistance{ std::sqrt(forward), std::sqrt(backward),
    std::sqrt(std::max(farthest, farthestBack)), std::sqrt(Dot(size, size)) };
}

}
