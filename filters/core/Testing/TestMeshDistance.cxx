// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/core/MeshDistance.h"
#include "filters/core/TriangleDistance.h"
#include "filters/program/TbbExecution.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

Mesh Moved(Mesh mesh, const Vec3& by)
{
  for (Vec3& p : mesh.points)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      p[k] += by[k];
    }
  }
  return mesh;
}

// Two big triangles: a square of 2 × 2 in the plane z = height.
Mesh Square(double height)
{
  return { { { 0, 0, height }, { 2, 0, height }, { 2, 2, height }, { 0, 2, height } },
    { { 0, 1, 2 }, { 0, 2, 3 } } };
}

}

TEST(TriangleDistance, IsThatOfTheNearestOfManyPlaces)
{
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto place = [&] { return Vec3{ unit(random), unit(random), unit(random) }; };
  for (unsigned i = 0; i < 300; ++i)
  {
    const Vec3 p = place(), a = place(), b = i % 10 == 0 ? a : place();
    const Vec3 c = i % 15 == 0 ? b : place();
    double nearest = INFINITY;
    constexpr int steps = 100;
    for (int s = 0; s <= steps; ++s)
    {
      for (int t = 0; s + t <= steps; ++t)
      {
        Vec3 d;
        for (std::size_t k = 0; k < 3; ++k)
        {
          d[k] = p[k] - (a[k] + (b[k] - a[k]) * s / steps + (c[k] - a[k]) * t / steps);
        }
        nearest = std::min(nearest, Dot(d, d));
      }
    }
    const double exact = SquaredToTriangle(p, a, b, c);
    EXPECT_LE(exact, nearest + 1e-12);
    EXPECT_NEAR(std::sqrt(exact), std::sqrt(nearest), 0.03);
  }
}

TEST(MeshDistance, OfAMeshFromItselfIsNothing)
{
  for (const NamedMesh& named : AllMeshes())
  {
    SCOPED_TRACE(named.name);
    const auto d = MeasureDistance(named.mesh, named.mesh, { 2000, 1 });
    ASSERT_TRUE(d) << d.GetError().message;
    EXPECT_LE(d->hausdorff, 1e-9 * (1 + d->diagonal));
  }
}

TEST(MeshDistance, OfParallelSquaresIsTheirDistance)
{
  const auto d = *MeasureDistance(Square(0), Square(0.25), { 1000, 1 });
  EXPECT_DOUBLE_EQ(d.rmsForward, 0.25);
  EXPECT_DOUBLE_EQ(d.rmsBackward, 0.25);
  EXPECT_DOUBLE_EQ(d.hausdorff, 0.25);
  EXPECT_DOUBLE_EQ(d.diagonal, std::sqrt(8.0));
}

TEST(MeshDistance, SamplesAreUniformOverTheArea)
{
  // The other mesh is the square's left edge. The distance is x: its mean square is 4/3, its
  // maximum 2.
  const Mesh edge{ { { 0, 0, 0 }, { 0, 2, 0 }, { 0, 1, 0 } }, { { 0, 1, 2 } } };
  const auto d = *MeasureDistance(Square(0), edge, { 100000, 1 });
  EXPECT_NEAR(d.rmsForward * d.rmsForward, 4.0 / 3, 0.02);
  EXPECT_NEAR(d.hausdorff, 2, 0.01);
  EXPECT_EQ(d.rmsBackward, 0);
}

TEST(MeshDistance, IsThatOfBruteForce)
{
  // A mesh of one point and no triangles has this point as its only sample.
  const Mesh target = DisplacedSphere(4);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-3, 3);
  for (unsigned i = 0; i < 100; ++i)
  {
    const Vec3 p{ unit(random), unit(random), unit(random) };
    double nearest = INFINITY;
    for (const Triangle& t : target.triangles)
    {
      nearest = std::min(nearest,
        SquaredToTriangle(p, target.points[t[0]], target.points[t[1]], target.points[t[2]]));
    }
    const auto d = *MeasureDistance({ { p }, {} }, target, { 1, 1 });
    EXPECT_DOUBLE_EQ(d.rmsForward, std::sqrt(nearest));
  }
}

TEST(MeshDistance, LooksAtBothWays)
{
  // A second sphere, far away, only in the other mesh.
  const Mesh sphere = DisplacedSphere(3);
  Mesh both = sphere;
  const Mesh second = Moved(sphere, { 10, 0, 0 });
  const auto first = static_cast<VertexId>(both.points.size());
  both.points.insert(both.points.end(), second.points.begin(), second.points.end());
  for (const Triangle& t : second.triangles)
  {
    both.triangles.push_back({ first + t[0], first + t[1], first + t[2] });
  }
  const auto d = *MeasureDistance(sphere, both, { 5000, 1 });
  EXPECT_LT(d.rmsForward, 1e-9);
  EXPECT_GT(d.rmsBackward, 5);
  EXPECT_GT(d.hausdorff, 8.5);
  const auto turned = *MeasureDistance(both, sphere, { 5000, 1 });
  EXPECT_EQ(turned.rmsForward, d.rmsBackward);
  EXPECT_EQ(turned.hausdorff, d.hausdorff);
}

TEST(MeshDistance, IsTheSameOnAnyNumberOfThreads)
{
  const Mesh a = DisplacedSphere(5), b = Moved(DisplacedSphere(4), { 0.01, 0, 0 });
  const auto serial = *MeasureDistance(a, b, { 20000, 7 });
  for (const unsigned threads : { 2U, 8U })
  {
    const auto parallel = *MeasureDistance(a, b, { 20000, 7 }, MakeTbbExecution(threads));
    EXPECT_EQ(parallel.rmsForward, serial.rmsForward);
    EXPECT_EQ(parallel.rmsBackward, serial.rmsBackward);
    EXPECT_EQ(parallel.hausdorff, serial.hausdorff);
  }
  EXPECT_NE(MeasureDistance(a, b, { 20000, 8 })->rmsForward, serial.rmsForward) << "the seed";
}

TEST(MeshDistance, SaysWhatIsWrong)
{
  const Mesh square = Square(0);
  const auto distance = [](const Mesh& a, const Mesh& b, std::size_t samples = 10) {
    return MeasureDistance(a, b, { samples, 1 });
  };
  constexpr ErrorCode wrong = ErrorCode::InvalidArgument;
  EXPECT_TRUE(FailsAt(distance({}, square), wrong, "reference mesh"));
  EXPECT_TRUE(FailsAt(distance(square, {}), wrong, "other mesh"));
  EXPECT_TRUE(FailsAt(distance(square, square, 0), wrong, "samples"));
  const auto triangle = distance(square, { { { 0, 0, 0 } }, { { 0, 0, 1 } } });
  EXPECT_TRUE(FailsAt(triangle, wrong, "other mesh"));
  EXPECT_TRUE(FailsAt(triangle, wrong, "triangle 0"));
  const auto vertex = distance({ { { 0, 0, 0 }, { 0, NAN, 0 } }, {} }, square);
  EXPECT_TRUE(FailsAt(vertex, wrong, "reference mesh"));
  EXPECT_TRUE(FailsAt(vertex, wrong, "vertex 1"));
  Execution stop;
  stop.progress = [](std::string_view, double) { return false; };
  EXPECT_EQ(MeasureDistance(square, square, {}, stop).GetError().code, ErrorCode::Cancelled);
}
