// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/levels/ClusterSum.h"

#include "filters/core/VectorMath.h"

#include <algorithm>
#include <cmath>

namespace kdstream
{
namespace
{

constexpr double regularisation = 1e-3; // of the quadric's trace; measured in the prototype

}

void ClusterSum::AddVertex(VertexId v, const Vec3& absolute, const Vec3& relative)
{
  this->box.Add(absolute);
  this->squares += Dot(relative, relative);
  for (std::size_t k = 0; k < 3; ++k)
  {
    this->sum[k] += relative[k];
  }
  ++this->count;
  this->lowest = std::min(this->lowest, v);
}

void ClusterSum::Add(const ClusterSum& child)
{
  this->count += child.count;
  this->squares += child.squares;
  this->boundaryCount += child.boundaryCount;
  for (std::size_t k = 0; k < 3; ++k)
  {
    this->sum[k] += child.sum[k];
    this->boundarySum[k] += child.boundarySum[k];
    this->normal[k] += child.normal[k];
  }
  this->box.Add(child.box);
  this->quadric.Add(child.quadric);
  this->geometricError = std::max(this->geometricError, child.geometricError);
  this->lowest = std::min(this->lowest, child.lowest);
  this->surface |= child.surface;
}

Vec3 ClusterSum::Represent(Representative representative, const Vec3& origin) const
{
  const bool boundary = representative == Representative::Quadric && this->boundaryCount > 0;
  const auto n = static_cast<double>(boundary ? this->boundaryCount : this->count);
  const Vec3& total = boundary ? this->boundarySum : this->sum;
  Vec3 x{ total[0] / n, total[1] / n, total[2] / n };
  if (representative == Representative::Quadric)
  {
    x = this->quadric.Minimum(x, regularisation);
    // Each step leaves a thousandth of the way to the planes; several steps reach the corners of
    // the boundary.
    for (unsigned i = 0; boundary && i < 3; ++i)
    {
      x = this->quadric.Minimum(x, regularisation);
    }
  }
  for (std::size_t k = 0; k < 3; ++k)
  {
    x[k] = std::clamp(x[k] + origin[k], this->box.lo[k], this->box.hi[k]) + 0.0;
  }
  return x;
}

Vec3 ClusterSum::Facing() const
{
  return FacingOf(this->normal, this->quadric);
}

double ClusterSum::GeometricErrorAt(const Vec3& x) const
{
  const double trace = this->quadric.Trace();
  if (trace > 0)
  {
    return std::sqrt(this->quadric.At(x) / trace);
  }
  const auto n = static_cast<double>(this->count);
  double mean = this->squares / n;
  for (std::size_t k = 0; k < 3; ++k)
  {
    mean += x[k] * x[k] - 2 * x[k] * this->sum[k] / n;
  }
  return std::sqrt(std::max(mean, 0.0));
}

}
