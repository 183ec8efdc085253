// SPDX-License-Identifier: BSD-3-Clause
// How levels by edge collapse change with colours, normals and NaN values.
#include "filters/core/Light.h"
#include "filters/core/Testing/BuiltLevels.h"
#include "filters/core/VectorMath.h"
#include "filters/core/levels/LevelAttributes.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

// A flat plate of 96 × 96 vertices; the colour of a vertex depends on its place.
template <class ColorAt>
Mesh ColoredPlate(const ColorAt& colorAt)
{
  Mesh plate = GridPlate(95);
  Attribute colors{ { "RGB", AttributeType::UInt8, AttributeAssociation::Point, 3 }, {} };
  for (const Vec3& p : plate.points)
  {
    const auto value = static_cast<std::uint8_t>(colorAt(p[0], p[1]));
    colors.values.insert(colors.values.end(), { value, value, value });
  }
  plate.attributes.push_back(std::move(colors));
  return plate;
}

// A checkerboard. The borders of its fields lie between vertices.
Mesh Checkerboard(unsigned field)
{
  return ColoredPlate(
    [field](double x, double y)
    {
      const bool dark =
        (static_cast<unsigned>(x) / field + static_cast<unsigned>(y) / field) % 2 == 0;
      return dark ? 20 : 230;
    });
}

// The red value of a level at a place of the plate, from any triangle there, because the level is
// flat; `otherwise` if there is no triangle.
double RedAt(const ClusterLevel& level, double x, double y, double otherwise)
{
  for (const Triangle& t : level.triangles)
  {
    const Vec3 &a = level.positions[t[0]], &b = level.positions[t[1]], &c = level.positions[t[2]];
    const double area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    const double ofA = ((b[0] - x) * (c[1] - y) - (b[1] - y) * (c[0] - x)) / area;
    const double ofB = ((c[0] - x) * (a[1] - y) - (c[1] - y) * (a[0] - x)) / area;
    if (ofA >= 0 && ofB >= 0 && ofA + ofB <= 1)
    {
      const Attribute& colors = level.attributes[0];
      return ofA * colors.Get(t[0], 0) + ofB * colors.Get(t[1], 0) +
             (1 - ofA - ofB) * colors.Get(t[2], 0);
    }
  }
  return otherwise;
}

// The mean difference between the pictures of a level and of the board, in grey values. Sampled
// between the vertices of the board, in places where it has one colour.
double PictureError(const ClusterLevel& level)
{
  double sum = 0, count = 0;
  for (double y = 1.25; y < 94; y += 1.5)
  {
    for (double x = 1.25; x < 94; x += 1.5)
    {
      const double inX = std::fmod(x, 12), inY = std::fmod(y, 12);
      if (inX < 11 && inY < 11)
      {
        const bool dark = (static_cast<int>(x / 12) + static_cast<int>(y / 12)) % 2 == 0;
        sum += std::abs(RedAt(level, x, y, dark ? 20 : 230) - (dark ? 20 : 230));
        ++count;
      }
    }
  }
  return sum / count;
}

}

TEST(CollapseLevels, ColoursKeepTheirEdges)
{
  const Mesh board = Checkerboard(12); // 8 × 8 fields
  Mesh plain = board;
  plain.attributes.clear();
  ClusterLevels colored = BuildAllLevels(board).levels, means = BuildAllLevels(plain).levels;
  AddLevelAttributes(board, colored);
  AddLevelAttributes(board, means);
  // 64 fields have four corners each: a level of at least 256 vertices can keep all corners.
  for (const unsigned d : { 8U, 9U, 10U })
  {
    const double error = PictureError(colored.levels[d]);
    EXPECT_LT(error, 4) << "level " << d;
    EXPECT_LT(error, 0.25 * PictureError(means.levels[d])) << "level " << d;
  }
}

TEST(CollapseLevels, FinestClustersPartAlongTheColors)
{
  const Mesh board = Checkerboard(11); // cells of the tree contain fields of both colours
  const BuiltLevels built = BuildAllLevels(board);
  std::vector<int> colorOf(built.levels.levels.back().positions.size(), -1);
  for (std::size_t v = 0; v < board.points.size(); ++v)
  {
    const int value = board.attributes[0].values[3 * v];
    int& color = colorOf[built.levels.finest[v]];
    ASSERT_TRUE(color == -1 || color == value) << "vertex " << v;
    color = value;
  }
}

// If a vertex is not in the middle of its cluster, as along the plate's border, it does not have
// the mean of its originals' colours.
TEST(CollapseLevels, SmoothColorsAreThoseOfThePlace)
{
  const Mesh ramp = ColoredPlate([](double x, double y) { return x + 1.5 * y; });
  ClusterLevels levels = BuildAllLevels(ramp).levels;
  AddLevelAttributes(ramp, levels);
  for (const unsigned d : { 6U, 7U, 8U })
  {
    const ClusterLevel& level = levels.levels[d];
    double sum = 0;
    for (std::size_t c = 0; c < level.positions.size(); ++c)
    {
      const Vec3& p = level.positions[c];
      sum += std::abs(level.attributes[0].Get(c, 0) - (p[0] + 1.5 * p[1]));
    }
    EXPECT_LT(sum / double(level.positions.size()), 2) << "level " << d;
  }
}

// The mean linear light of a level, weighted by area.
double MeanLight(const ClusterLevel& level)
{
  double light = 0, whole = 0;
  for (const Triangle& t : level.triangles)
  {
    const std::vector<Vec3>& at = level.positions;
    const double area = Length(Cross(Minus(at[t[1]], at[t[0]]), Minus(at[t[2]], at[t[0]])));
    for (const VertexId v : t)
    {
      light += area * ToLinear(level.attributes[0].Get(v, 0) / 255) / 3;
    }
    whole += area;
  }
  return light / whole;
}

// With means of bytes the light would go down to 0.2.
TEST(CollapseLevels, WhatIsMixedKeepsItsLight)
{
  const Mesh board = Checkerboard(3);
  ClusterLevels levels = BuildAllLevels(board).levels;
  AddLevelAttributes(board, levels);
  const double half = (ToLinear(20 / 255.0) + ToLinear(230 / 255.0)) / 2;
  std::size_t coarse = 0;
  for (const ClusterLevel& level : levels.levels)
  {
    if (level.triangles.size() >= 60)
    {
      EXPECT_NEAR(MeanLight(level), half, 0.025) << level.triangles.size() << " triangles";
      coarse += level.triangles.size() < 400 ? 1 : 0;
    }
  }
  EXPECT_GE(coarse, 2U);
}

TEST(ColorQuadric, SmoothColorsCostNothing)
{
  // Red grows along x, green along y; blue is the same everywhere.
  const auto color = [](const Vec3& p) { return Vec3{ 2 * p[0], 3 * p[1] - 1, 7 }; };
  const Vec3 a{ 1, 2, 3 }, b{ 4, 2, 3 }, c{ 1, 7, 3 }, d{ 5, 6, 3 };
  ColorQuadric quadric = ColorQuadric::OfTriangle({ a, b, c }, { color(a), color(b), color(c) });
  EXPECT_DOUBLE_EQ(quadric.area, 7.5);
  quadric.Add(ColorQuadric::OfTriangle({ b, d, c }, { color(b), color(d), color(c) }));
  const Vec3 place{ 3, 4, 3 }, found = quadric.ColorAt(place);
  for (std::size_t k = 0; k < 3; ++k)
  {
    EXPECT_NEAR(found[k], color(place)[k], 1e-12);
  }
  EXPECT_NEAR(quadric.Residual().At(place), 0, 1e-9);
}

TEST(ColorQuadric, AnEdgeOfTheColorsHoldsItsVertices)
{
  // Dark on one side of y = 0, bright from y = 1 on.
  const Vec3 a{ 0, 0, 0 }, b{ 1, 0, 0 }, c{ 0, 1, 0 }, d{ 1, -1, 0 };
  const Vec3 dark{}, bright{ 1, 1, 1 };
  ColorQuadric quadric = ColorQuadric::OfTriangle({ a, b, c }, { dark, dark, bright });
  quadric.Add(ColorQuadric::OfTriangle({ a, d, b }, { dark, dark, dark }));
  const Quadric residual = quadric.Residual();
  EXPECT_NEAR(residual.At({ 0.5, 0, 0 }), 0, 1e-12);
  EXPECT_NEAR(residual.At({ 9, 0, 0 }), 0, 1e-12); // along the edge
  EXPECT_NEAR(residual.At({ 0.5, -1, 0 }), 0.75, 1e-12);
  EXPECT_NEAR(residual.At({ 0.5, 0, 5 }), 0, 1e-12); // off the plane: only the plane quadrics count
}

TEST(ColorQuadric, TrianglesWithoutAreaSayNothing)
{
  const Vec3 a{ 0, 0, 0 }, b{ 1, 0, 0 }, color{ 1, 2, 3 };
  EXPECT_EQ(ColorQuadric::OfTriangle({ a, b, { 2, 0, 0 } }, { color, {}, color }).area, 0);
  EXPECT_EQ(ColorQuadric::OfTriangle({ a, { 1e200, 0, 0 }, { 0, 1e200, 0 } }, {}).area, 0);
  EXPECT_EQ(ColorQuadric::OfTriangle({ a, { NAN, 0, 0 }, b }, {}).area, 0);
  // A triangle so thin that the slope of its colour is not a number.
  const Vec3 none{}, much{ 1e9, 0, 0 }, near{ 1e-155, 0, 0 }, up{ 0, 1e-6, 0 };
  const ColorQuadric thin = ColorQuadric::OfTriangle({ a, near, up }, { none, much, none });
  EXPECT_TRUE(std::isfinite(thin.squares.c) && std::isfinite(thin.squares.Trace()));
}

TEST(CollapseLevels, OneColourChangesNothing)
{
  const Mesh plain = DisplacedSphere(4);
  Mesh colored = plain;
  Attribute colors;
  colors.name = "RGBA";
  colors.type = AttributeType::UInt8;
  colors.components = 4;
  colors.values.assign(4 * plain.points.size(), 100);
  colored.attributes.push_back(colors);
  const BuiltLevels a = BuildAllLevels(plain), b = BuildAllLevels(colored);
  for (std::size_t d = 0; d < a.levels.levels.size(); ++d)
  {
    EXPECT_EQ(a.levels.levels[d].positions, b.levels.levels[d].positions);
    EXPECT_EQ(a.levels.levels[d].triangles, b.levels.levels[d].triangles);
  }
}

TEST(CollapseLevels, AttributesThatAreNotNumbersDoNoHarm)
{
  Mesh mesh = DisplacedSphere(4);
  Attribute normals;
  normals.name = "Normals";
  normals.type = AttributeType::Float64;
  normals.components = 3;
  normals.values.resize(mesh.points.size() * normals.TupleSize());
  for (std::size_t v = 0; v < mesh.points.size(); ++v)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      normals.Set(v, k, v % 7 == 0 ? NAN : v % 11 == 0 ? 1e300 : mesh.points[v][k]);
    }
  }
  mesh.attributes.push_back(normals);
  const BuiltLevels built = BuildAllLevels(mesh);
  for (const ClusterLevel& level : built.levels.levels)
  {
    for (const Vec3& p : level.positions)
    {
      ASSERT_TRUE(std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]));
    }
  }
  EXPECT_LE(built.levels.levels[6].positions.size(), 100U);
}
