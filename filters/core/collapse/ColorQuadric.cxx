// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/collapse/ColorQuadric.h"

#include "filters/core/VectorMath.h"

#include <cmath>

namespace kdstream
{
namespace
{

// Adds weight × (g·x + d)² to a quadric.
void AddSquare(Quadric& quadric, const Vec3& g, double d, double weight)
{
  quadric.a[0] += weight * g[0] * g[0];
  quadric.a[1] += weight * g[0] * g[1];
  quadric.a[2] += weight * g[0] * g[2];
  quadric.a[3] += weight * g[1] * g[1];
  quadric.a[4] += weight * g[1] * g[2];
  quadric.a[5] += weight * g[2] * g[2];
  for (std::size_t i = 0; i < 3; ++i)
  {
    quadric.b[i] += weight * d * g[i];
  }
  quadric.c += weight * d * d;
}

}

ColorQuadric ColorQuadric::OfTriangle(
  const std::array<Vec3, 3>& corners, const std::array<Vec3, 3>& colors)
{
  const Vec3 u = Minus(corners[1], corners[0]), v = Minus(corners[2], corners[0]);
  const Vec3 normal = Cross(u, v);
  const double squared = Dot(normal, normal);
  if (!(squared > 0) || !std::isfinite(squared))
  {
    return {};
  }
  // The gradients of the barycentric coordinates that belong to u and v, times `squared`.
  const Vec3 alongU = Cross(v, normal), alongV = Cross(normal, u);
  ColorQuadric quadric;
  quadric.area = std::sqrt(squared) / 2;
  for (std::size_t k = 0; k < 3; ++k)
  {
    const Vec3 slope = Plus(Times(alongU, (colors[1][k] - colors[0][k]) / squared),
      Times(alongV, (colors[2][k] - colors[0][k]) / squared));
    const double constant = colors[0][k] - Dot(slope, corners[0]);
    quadric.slopes[k] = Times(slope, quadric.area);
    quadric.constants[k] = constant * quadric.area;
    AddSquare(quadric.squares, slope, constant, quadric.area);
  }
  return std::isfinite(quadric.squares.Trace() + quadric.squares.c) ? quadric : ColorQuadric{};
}

void ColorQuadric::Add(const ColorQuadric& other)
{
  this->squares.Add(other.squares);
  for (std::size_t k = 0; k < 3; ++k)
  {
    this->slopes[k] = Plus(this->slopes[k], other.slopes[k]);
  }
  this->constants = Plus(this->constants, other.constants);
  this->area += other.area;
}

Quadric ColorQuadric::Residual() const
{
  Quadric residual = this->squares;
  for (std::size_t k = 0; k < 3 && this->area > 0; ++k)
  {
    AddSquare(residual, this->slopes[k], this->constants[k], -1 / this->area);
  }
  return residual;
}

Vec3 ColorQuadric::ColorAt(const Vec3& x) const
{
  Vec3 color{};
  for (std::size_t k = 0; k < 3; ++k)
  {
    color[k] = (Dot(this->slopes[k], x) + this->constants[k]) / this->area;
  }
  return color;
}

}
