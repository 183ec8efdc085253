// SPDX-License-Identifier: BSD-3-Clause
// What colours, normals and values that are no numbers do to levels by edge collapse.
#include "filters/core/Testing/BuiltLevels.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

// A flat plate painted as a checkerboard of 8 × 8 fields whose borders lie between vertices.
Mesh Checkerboard()
{
  constexpr unsigned side = 95;
  Mesh plate = GridPlate(side);
  Attribute colors;
  colors.name = "RGB";
  colors.type = AttributeType::UInt8;
  colors.components = 3;
  for (const Vec3& p : plate.points)
  {
    const auto field = static_cast<unsigned>(p[0]) / 12 + static_cast<unsigned>(p[1]) / 12;
    const auto value = static_cast<std::uint8_t>(field % 2 == 0 ? 20 : 230);
    colors.values.insert(colors.values.end(), { value, value, value });
  }
  plate.attributes.push_back(std::move(colors));
  return plate;
}

// How far the painted level's colours are from the board's, as RMS over the board's vertices: a
// colour at a place is that of the corner of the triangle there which is nearest in the plane.
double ColorError(const Mesh& board, const ClusterLevel& level, const std::vector<VertexId>& of)
{
  std::vector<double> sum(level.positions.size(), 0), count(level.positions.size(), 0);
  for (std::size_t v = 0; v < of.size(); ++v)
  {
    sum[of[v]] += board.attributes[0].Get(v, 0);
    count[of[v]] += 1;
  }
  double squares = 0;
  for (std::size_t v = 0; v < of.size(); ++v)
  {
    const double d = board.attributes[0].Get(v, 0) - sum[of[v]] / count[of[v]];
    squares += d * d;
  }
  return std::sqrt(squares / double(of.size()));
}

}

TEST(CollapseLevels, ColoursKeepTheirEdges)
{
  const Mesh board = Checkerboard();
  Mesh plain = board;
  plain.attributes.clear();
  const BuiltLevels painted = BuildAllLevels(board), bare = BuildAllLevels(plain);
  for (const unsigned d : { 6U, 7U, 8U })
  {
    EXPECT_LT(ColorError(board, painted.levels.levels[d], painted.clusterAt[d]),
      0.5 * ColorError(board, bare.levels.levels[d], bare.clusterAt[d]))
      << "level " << d;
  }
}

TEST(CollapseLevels, OneColourChangesNothing)
{
  const Mesh plain = DisplacedSphere(4);
  Mesh painted = plain;
  Attribute colors;
  colors.name = "RGBA";
  colors.type = AttributeType::UInt8;
  colors.components = 4;
  colors.values.assign(4 * plain.points.size(), 100);
  painted.attributes.push_back(colors);
  const BuiltLevels a = BuildAllLevels(plain), b = BuildAllLevels(painted);
  for (std::size_t d = 0; d < a.levels.levels.size(); ++d)
  {
    EXPECT_EQ(a.levels.levels[d].positions, b.levels.levels[d].positions);
    EXPECT_EQ(a.levels.levels[d].triangles, b.levels.levels[d].triangles);
  }
}

TEST(CollapseLevels, AttributesThatAreNoNumbersDoNoHarm)
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
