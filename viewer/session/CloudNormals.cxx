// Normals of a cloud that came without: see CloudNormals.h.
#include "viewer/session/CloudNormals.h"

#include "viewer/session/Geometry.h"
#include "viewer/session/SplatRadii.h"
#include "viewer/session/VertexNormals.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace kdstream
{
namespace
{

constexpr std::size_t neighbours = 12;

// The ways to the nearest points of the run, itself the first.
std::array<Vec3, neighbours + 1> NearestOf(
  const Surface& cloud, const PointRun& run, std::size_t from, std::size_t& count)
{
  std::array<std::pair<double, Vec3>, neighbours + 1> kept;
  kept.fill({ std::numeric_limits<double>::infinity(), Vec3{} });
  for (std::size_t i = run.begin; i < run.end; ++i)
  {
    const Vec3 way = cloud.points[i] - cloud.points[from];
    const double square = Dot(way, way);
    std::size_t place = kept.size();
    for (; place > 0 && square < kept[place - 1].first; --place)
    {
      if (place < kept.size())
      {
        kept[place] = kept[place - 1];
      }
    }
    if (place < kept.size())
    {
      kept[place] = { square, way };
    }
  }
  std::array<Vec3, neighbours + 1> ways{};
  count = std::min(run.end - run.begin, kept.size());
  for (std::size_t i = 0; i < count; ++i)
  {
    ways[i] = kept[i].second;
  }
  return ways;
}

using Matrix = std::array<Vec3, 3>;

// By the largest entry: the next product stays in the range of doubles. False where all are 0.
bool Scale(Matrix& m)
{
  double largest = 0.0;
  for (const Vec3& row : m)
  {
    largest = std::max({ largest, std::abs(row[0]), std::abs(row[1]), std::abs(row[2]) });
  }
  if (!(largest > 0.0) || !std::isfinite(largest))
  {
    return false;
  }
  for (Vec3& row : m)
  {
    row = row * (1.0 / largest);
  }
  return true;
}

// The eigenvector of the least eigenvalue of a covariance: the adjugate has the same eigenvectors
// and, of each, the product of the other two eigenvalues, so this one's is the largest, and by far
// after a few squares.
Vec3 ThinnestDirection(Matrix covariance)
{
  if (!Scale(covariance))
  {
    return {};
  }
  Matrix power{ Cross(covariance[1], covariance[2]), Cross(covariance[2], covariance[0]),
    Cross(covariance[0], covariance[1]) };
  // On a line two eigenvalues are nothing but rounding.
  if (std::max({ power[0][0], power[1][1], power[2][2] }) < 1e-12 || !Scale(power))
  {
    return {};
  }
  for (int squared = 0; squared < 5; ++squared)
  {
    Matrix product{};
    for (std::size_t i = 0; i < 3; ++i)
    {
      for (std::size_t j = 0; j < 3; ++j)
      {
        product[i][j] = Dot(power[i], power[j]); // it is symmetric
      }
    }
    power = product;
    Scale(power);
  }
  return *std::max_element(
    power.begin(), power.end(), [](const Vec3& a, const Vec3& b) { return Dot(a, a) < Dot(b, b); });
}

Vec3 NormalAt(const Surface& cloud, const PointRun& run, std::size_t point)
{
  std::size_t count = 0;
  const auto ways = NearestOf(cloud, run, point, count);
  if (count < 3)
  {
    return {};
  }
  Vec3 mean{};
  for (std::size_t i = 0; i < count; ++i)
  {
    mean = mean + ways[i] * (1.0 / static_cast<double>(count));
  }
  Matrix covariance{};
  for (std::size_t i = 0; i < count; ++i)
  {
    const Vec3 off = ways[i] - mean;
    for (std::size_t k = 0; k < 3; ++k)
    {
      covariance[k] = covariance[k] + off * off[k];
    }
  }
  return ThinnestDirection(covariance);
}

}

std::vector<std::array<float, 3>> EstimateNormals(const Surface& cloud)
{
  std::vector<std::array<float, 3>> normals;
  normals.reserve(cloud.points.size());
  for (const PointRun& run : RunsOf(cloud))
  {
    for (std::size_t i = run.begin; i < run.end; ++i)
    {
      normals.push_back(UnitNormal(NormalAt(cloud, run, i)));
    }
  }
  return normals;
}

}
