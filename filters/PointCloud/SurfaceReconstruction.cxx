// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. make points relative to the box's centre, each place once
// 2. find the nearest neighbours of each place, and with them the spacing
// 3. find normals: fit planes, and orient them
// 4. let PCL make the surface
// 5. convert it back to the points of the input.
#include "filters/PointCloud/SurfaceReconstruction.h"

#include "filters/core/UnitVector.h"
#include "filters/core/Weld.h"

#include <pcl/console/print.h>
#include <pcl/features/normal_3d.h>
#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/surface/gp3.h>
#include <pcl/surface/poisson.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace kdstream
{
namespace
{

using Cloud = pcl::PointCloud<pcl::PointNormal>;

constexpr std::size_t grain = 1024;
constexpr std::size_t batch = 1 << 16;     // points between two reports of progress
constexpr std::size_t spacingNeighbor = 6; // a vertex of a regular mesh has six neighbours
// The longest edge of a greedy surface. Measured with the dragon's points, and with a regular and a
// random sphere: a smaller value leaves holes, a larger one gives folds.
constexpr double radiusInSpacings = 2.25;
constexpr double unlimitedMu = 1e6;
constexpr double lineTolerance = 1e-6; // if points are on a line: second extent relative to first
constexpr double pi = 3.14159265358979323846;

Vec3 AreaOf(const Vec3& a, const Vec3& b, const Vec3& c)
{
  return Cross(Minus(b, a), Minus(c, a));
}

// PCL's classes print messages; they do not while an object of this class exists.
class QuietPcl
{
public:
  QuietPcl()
    : Before(pcl::console::getVerbosityLevel())
  {
    pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  }
  ~QuietPcl() { pcl::console::setVerbosityLevel(this->Before); }
  QuietPcl(const QuietPcl&) = delete;
  QuietPcl& operator=(const QuietPcl&) = delete;

private:
  pcl::console::VERBOSITY_LEVEL Before;
};

class Reconstructor
{
public:
  Reconstructor(std::span<const Vec3> points, std::span<const Vec3> normals,
    const ReconstructionOptions& options, const Execution& execution)
    : Points(points)
    , GivenNormals(normals)
    , Options(options)
    , Exec(execution)
    , Places(new Cloud)
  {
  }

  Result<Reconstruction> Run()
  {
    KDSTREAM_TRY(this->CollectPlaces());
    KDSTREAM_TRY(this->FindNeighbors());
    KDSTREAM_TRY(this->FindNormals());
    KDSTREAM_TRY(this->Exec.Report("surface", 0));
    const QuietPcl quiet;
    if (this->Options.method == ReconstructionOptions::Method::Greedy)
    {
      this->MakeGreedySurface();
    }
    else
    {
      this->MakePoissonSurface();
    }
    KDSTREAM_TRY(this->Exec.Report("surface", 1));
    return std::move(this->Output);
  }

private:
  // Calls body(i) for every place, and reports progress after each batch.
  template <class Body>
  Status ForEachPlace(const char* step, const Body& body) const
  {
    const std::size_t count = this->Places->size();
    for (std::size_t first = 0; first < count; first += batch)
    {
      KDSTREAM_TRY(this->Exec.Report(step, double(first) / double(count)));
      this->Exec.parallelFor(std::min(batch, count - first), grain,
        [&](std::size_t begin, std::size_t end)
        {
          for (std::size_t i = first + begin; i < first + end; ++i)
          {
            body(i);
          }
        });
    }
    return this->Exec.Report(step, 1);
  }

  Vec3 Place(std::size_t i) const
  {
    const pcl::PointNormal& p = (*this->Places)[i];
    return { double(p.x), double(p.y), double(p.z) };
  }

  Status CollectPlaces()
  {
    if (this->Points.size() > std::size_t(std::numeric_limits<std::int32_t>::max()))
    {
      return Error{ ErrorCode::LimitExceeded,
        std::to_string(this->Points.size()) + " points; PCL supports at most 2147483647" };
    }
    const Box box = BoxOfPoints(this->Points);
    std::vector<Vec3> rounded(this->Points.size());
    for (std::size_t k = 0; k < 3 && !box.Empty(); ++k)
    {
      this->Centre[k] = box.lo[k] + (box.hi[k] - box.lo[k]) / 2;
      this->Extent = std::max(this->Extent, box.hi[k] - box.lo[k]);
    }
    if (!std::isfinite(this->Extent))
    {
      return Error{ ErrorCode::InvalidInput,
        "the extent of the points exceeds the range of doubles" };
    }
    this->Unit = this->Extent > 0 ? std::ldexp(1.0, std::ilogb(this->Extent)) : 1;
    for (std::size_t i = 0; i < rounded.size(); ++i)
    {
      for (std::size_t k = 0; k < 3; ++k)
      {
        rounded[i][k] = double(float((this->Points[i][k] - this->Centre[k]) / this->Unit));
      }
    }
    const std::vector<VertexId> first = FirstCoincident(rounded, Coincidence::ValueEqual);
    for (VertexId i = 0; i < first.size(); ++i)
    {
      if (first[i] == i)
      {
        pcl::PointNormal place;
        place.x = float(rounded[i][0]);
        place.y = float(rounded[i][1]);
        place.z = float(rounded[i][2]);
        this->Places->push_back(place);
        this->PointOfPlace.push_back(i);
      }
    }
    return this->CheckShape();
  }

  // Checks that there are at least three places that are not on one line: finds the place that is
  // farthest from the first one, then one that is not on the line through both.
  Status CheckShape() const
  {
    const std::size_t count = this->Places->size();
    if (count < 3)
    {
      return Error{ ErrorCode::InvalidInput,
        "a surface needs three points in different places; there are " + std::to_string(count) };
    }
    Vec3 longest{};
    for (std::size_t i = 1; i < count; ++i)
    {
      const Vec3 way = Minus(this->Place(i), this->Place(0));
      longest = Dot(way, way) > Dot(longest, longest) ? way : longest;
    }
    const double length = std::sqrt(Dot(longest, longest));
    const Vec3 line = UnitVector(longest);
    double widest = 0;
    for (std::size_t i = 1; i < count; ++i)
    {
      const Vec3 way = Minus(this->Place(i), this->Place(0));
      const double along = Dot(way, line);
      const Vec3 beside{ way[0] - along * line[0], way[1] - along * line[1],
        way[2] - along * line[2] };
      widest = std::max(widest, std::sqrt(Dot(beside, beside)));
    }
    return widest > lineTolerance * length ? Status()
                                           : Status(Error{ ErrorCode::InvalidInput,
                                               "all points lie on one line: there is no surface" });
  }

  Status FindNeighbors()
  {
    const std::size_t count = this->Places->size();
    this->Tree.setInputCloud(this->Places);
    this->Valence = std::min<std::size_t>(count, std::max(this->Options.neighbors, 3U) + 1);
    this->Neighbors.resize(count * this->Valence);
    std::vector<float> distances(count);
    const std::size_t counted = std::min(spacingNeighbor, this->Valence - 1);
    Status status = this->ForEachPlace("neighbors",
      [&](std::size_t i)
      {
        pcl::Indices found;
        std::vector<float> squares;
        this->Tree.nearestKSearch(
          static_cast<int>(i), static_cast<unsigned>(this->Valence), found, squares);
        // If coordinates overflow, PCL finds fewer neighbours.
        found.resize(this->Valence, static_cast<int>(i));
        squares.resize(this->Valence, 0);
        std::copy(
          found.begin(), found.end(), this->Neighbors.begin() + std::ptrdiff_t(i * this->Valence));
        distances[i] = std::sqrt(squares[counted]);
      });
    KDSTREAM_TRY(status);
    const auto middle = distances.begin() + std::ptrdiff_t(count / 2);
    std::nth_element(distances.begin(), middle, distances.end());
    this->Output.spacing = double(*middle) * this->Unit;
    return {};
  }

  // The unit normal of the plane through the neighbours of a place; zero if there is none.
  Vec3 FitNormal(std::size_t i) const
  {
    pcl::Indices near;
    std::vector<float> squares;
    if (this->Options.normalRadius > 0)
    {
      this->Tree.radiusSearch(
        static_cast<int>(i), this->Options.normalRadius / this->Unit, near, squares);
    }
    if (near.size() < 3)
    {
      const auto begin = this->Neighbors.begin() + std::ptrdiff_t(i * this->Valence);
      near.assign(begin, begin + std::ptrdiff_t(this->Valence));
    }
    Eigen::Vector4f plane;
    float curvature = 0;
    if (!pcl::computePointNormal(*this->Places, near, plane, curvature))
    {
      return {};
    }
    return UnitVector({ double(plane[0]), double(plane[1]), double(plane[2]) });
  }

  Status FindNormals()
  {
    const std::size_t count = this->Places->size();
    std::vector<Vec3> places(count), normals(count);
    std::vector<std::uint8_t> known(count, 0);
    Status status = this->ForEachPlace("normals",
      [&](std::size_t i)
      {
        places[i] = this->Place(i);
        const VertexId point = this->PointOfPlace[i];
        normals[i] = this->GivenNormals.empty() ? Vec3{} : UnitVector(this->GivenNormals[point]);
        known[i] = Dot(normals[i], normals[i]) > 0;
        if (!known[i])
        {
          normals[i] = this->FitNormal(i);
          const Vec3 away = Minus(this->Points[point], this->Options.viewpoint);
          if (this->Options.towardsViewpoint && Dot(normals[i], away) > 0)
          {
            normals[i] = { -normals[i][0], -normals[i][1], -normals[i][2] };
          }
        }
      });
    KDSTREAM_TRY(status);
    if (!this->Options.towardsViewpoint && std::find(known.begin(), known.end(), 0) != known.end())
    {
      OrientNormals(places, known, this->Neighbors, this->Valence, normals);
    }
    for (std::size_t i = 0; i < count; ++i)
    {
      pcl::PointNormal& place = (*this->Places)[i];
      // If a point has no normal so far, all its neighbours are on a line: any normal will do.
      const Vec3 normal = Dot(normals[i], normals[i]) > 0 ? normals[i] : Vec3{ 0, 0, 1 };
      place.normal_x = float(normal[0]);
      place.normal_y = float(normal[1]);
      place.normal_z = float(normal[2]);
    }
    return {};
  }

  Vec3 NormalOf(std::size_t place) const
  {
    const pcl::PointNormal& p = (*this->Places)[place];
    return { double(p.normal_x), double(p.normal_y), double(p.normal_z) };
  }

  // Adds PCL's polygons as fans of triangles; `id` maps a corner to a point.
  template <class Id>
  void AddTriangles(const std::vector<pcl::Vertices>& polygons, std::size_t corners, const Id& id)
  {
    for (const pcl::Vertices& polygon : polygons)
    {
      const auto& v = polygon.vertices;
      const bool sound =
        std::all_of(v.begin(), v.end(), [&](auto c) { return c >= 0 && std::size_t(c) < corners; });
      for (std::size_t i = 2; sound && i < v.size(); ++i)
      {
        this->Output.triangles.push_back({ id(v[0]), id(v[i - 1]), id(v[i]) });
      }
    }
  }

  void MakeGreedySurface()
  {
    const double radius = this->Options.searchRadius > 0 ? this->Options.searchRadius
                                                         : radiusInSpacings * this->Output.spacing;
    pcl::GreedyProjectionTriangulation<pcl::PointNormal> greedy;
    greedy.setSearchRadius(radius / this->Unit);
    greedy.setMu(this->Options.mu > 0 ? this->Options.mu : unlimitedMu);
    greedy.setMaximumNearestNeighbors(
      static_cast<int>(std::max(this->Options.maximumNeighbors, 3U)));
    greedy.setMaximumSurfaceAngle(this->Options.maximumSurfaceAngle * pi / 180);
    greedy.setMinimumAngle(this->Options.minimumAngle * pi / 180);
    greedy.setMaximumAngle(this->Options.maximumAngle * pi / 180);
    greedy.setNormalConsistency(true);
    greedy.setConsistentVertexOrdering(true);
    greedy.setInputCloud(this->Places);
    const auto search = pcl::make_shared<pcl::search::KdTree<pcl::PointNormal>>();
    search->setInputCloud(this->Places);
    greedy.setSearchMethod(search);
    std::vector<pcl::Vertices> polygons;
    greedy.reconstruct(polygons);
    this->AddTriangles(polygons, this->Places->size(),
      [&](auto corner) { return this->PointOfPlace[std::size_t(corner)]; });
    this->Output.normals.resize(this->Points.size());
    for (std::size_t i = 0; i < this->Points.size(); ++i)
    {
      this->Output.normals[i] =
        this->GivenNormals.empty() ? Vec3{} : UnitVector(this->GivenNormals[i]);
    }
    for (std::size_t i = 0; i < this->PointOfPlace.size(); ++i)
    {
      this->Output.normals[this->PointOfPlace[i]] = this->NormalOf(i);
    }
    this->TurnTriangles();
  }

  // PCL orients each triangle by the normal of one corner. Using the normals of all three is more
  // reliable.
  void TurnTriangles()
  {
    for (Triangle& t : this->Output.triangles)
    {
      const Vec3 area = AreaOf(this->Points[t[0]], this->Points[t[1]], this->Points[t[2]]);
      double agreement = 0;
      for (const VertexId corner : t)
      {
        agreement += Dot(area, this->Output.normals[corner]);
      }
      if (agreement < 0)
      {
        std::swap(t[1], t[2]);
      }
    }
  }

  std::uint32_t PoissonDepth() const
  {
    if (this->Options.depth > 0)
    {
      return this->Options.depth;
    }
    std::uint32_t depth = 6;
    while (depth < 10 && std::ldexp(this->Output.spacing, int(depth)) < this->Extent)
    {
      ++depth;
    }
    return depth;
  }

  void MakePoissonSurface()
  {
    pcl::Poisson<pcl::PointNormal> poisson;
    poisson.setDepth(static_cast<int>(this->PoissonDepth()));
    poisson.setSolverDivide(static_cast<int>(std::min(this->PoissonDepth(), 8U)));
    poisson.setIsoDivide(static_cast<int>(std::min(this->PoissonDepth(), 8U)));
    poisson.setMinDepth(static_cast<int>(std::min(this->PoissonDepth(), 5U)));
    poisson.setSamplesPerNode(float(this->Options.samplesPerNode));
    poisson.setPointWeight(float(this->Options.pointWeight));
    poisson.setThreads(1); // another order of sums would change bits
    poisson.setInputCloud(this->Places);
    Cloud surface;
    std::vector<pcl::Vertices> polygons;
    poisson.reconstruct(surface, polygons);
    this->AddTriangles(
      polygons, surface.size(), [](auto corner) { return static_cast<VertexId>(corner); });
    this->TakeSurface(surface);
  }

  // Stores the points of the surface, the input points nearest to them, and their normals.
  void TakeSurface(const Cloud& surface)
  {
    const std::size_t count = surface.size();
    this->Output.points.resize(count);
    this->Output.nearest.resize(count);
    std::vector<double> distances(count);
    this->Exec.parallelFor(count, grain,
      [&](std::size_t begin, std::size_t end)
      {
        pcl::Indices found(1);
        std::vector<float> squares(1);
        for (std::size_t i = begin; i < end; ++i)
        {
          const pcl::PointNormal& p = surface[i];
          this->Output.points[i] = { this->Centre[0] + double(p.x) * this->Unit,
            this->Centre[1] + double(p.y) * this->Unit,
            this->Centre[2] + double(p.z) * this->Unit };
          const bool any = this->Tree.nearestKSearch(p, 1, found, squares) > 0;
          this->Output.nearest[i] = this->PointOfPlace[any ? std::size_t(found[0]) : 0];
          distances[i] = any ? double(std::sqrt(squares[0])) * this->Unit : 0;
        }
      });
    this->FindSurfaceNormals();
    if (this->Options.trimDistance > 0)
    {
      this->Trim(distances);
    }
  }

  // Computes normals from those of the triangles, weighted by their areas. PCL's triangles face to
  // the same side as the normals of the points.
  void FindSurfaceNormals()
  {
    std::vector<Vec3>& normals = this->Output.normals;
    normals.assign(this->Output.points.size(), Vec3{});
    for (const Triangle& t : this->Output.triangles)
    {
      const Vec3 area =
        AreaOf(this->Output.points[t[0]], this->Output.points[t[1]], this->Output.points[t[2]]);
      for (const VertexId corner : t)
      {
        for (std::size_t k = 0; k < 3; ++k)
        {
          normals[corner][k] += area[k];
        }
      }
    }
    std::transform(normals.begin(), normals.end(), normals.begin(), UnitVector);
  }

  // Drops triangles that are not near any point, and then the points that no triangle uses.
  void Trim(const std::vector<double>& distances)
  {
    const double most = this->Options.trimDistance * this->Output.spacing;
    std::vector<Triangle>& triangles = this->Output.triangles;
    triangles.erase(std::remove_if(triangles.begin(), triangles.end(),
                      [&](const Triangle& t) {
                        return std::all_of(
                          t.begin(), t.end(), [&](VertexId c) { return distances[c] > most; });
                      }),
      triangles.end());
    std::vector<VertexId> renumbered(this->Output.points.size(), noVertex);
    Reconstruction kept;
    for (Triangle& t : triangles)
    {
      for (VertexId& corner : t)
      {
        if (renumbered[corner] == noVertex)
        {
          renumbered[corner] = static_cast<VertexId>(kept.points.size());
          kept.points.push_back(this->Output.points[corner]);
          kept.nearest.push_back(this->Output.nearest[corner]);
          kept.normals.push_back(this->Output.normals[corner]);
        }
        corner = renumbered[corner];
      }
    }
    this->Output.points = std::move(kept.points);
    this->Output.nearest = std::move(kept.nearest);
    this->Output.normals = std::move(kept.normals);
  }

  std::span<const Vec3> Points, GivenNormals;
  const ReconstructionOptions& Options;
  const Execution& Exec;
  Vec3 Centre{};
  double Extent = 0; // longest side of the box
  // A power of two near Extent. Places are divided by it, so that their squares fit into floats.
  double Unit = 1;
  Cloud::Ptr Places;
  std::vector<VertexId> PointOfPlace;
  pcl::KdTreeFLANN<pcl::PointNormal> Tree;
  std::size_t Valence = 0; // neighbours of each place in Neighbors, with itself
  std::vector<VertexId> Neighbors;
  Reconstruction Output;
};

}

Result<Reconstruction> ReconstructSurface(std::span<const Vec3> points,
  std::span<const Vec3> normals, const ReconstructionOptions& options, const Execution& execution)
{
  return Reconstructor(points, normals, options, execution).Run();
}

}
