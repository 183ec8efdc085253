// SPDX-License-Identifier: BSD-3-Clause
// How a model stands: a given direction stays, a missing one is guessed, and all builds guess the
// same.
#include "Testing/Fixtures/Meshes.h"
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/build/ExternalBuilder.h"
#include "filters/build/GuessHomeView.h"
#include "filters/core/VectorMath.h"
#include "filters/meshio/MeshWriter.h"
#include "filters/program/TbbExecution.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <functional>

using namespace kdstream;
using namespace kdstream::fixtures;
namespace fs = std::filesystem;

namespace
{

// A closed surface around the y axis. radius(h, a): its distance from the axis at height h (0-1)
// and angle a (0-1). Both ends are flat.
Mesh Bag(const Vec3& foot, double height, const std::function<double(double, double)>& radius)
{
  constexpr std::uint32_t rings = 33, around = 48;
  Mesh mesh;
  for (std::uint32_t i = 0; i < rings; ++i)
  {
    for (std::uint32_t j = 0; j < around; ++j)
    {
      const double h = double(i) / (rings - 1), turn = double(j) / around;
      const double angle = 2 * std::acos(-1.0) * turn, r = radius(h, turn);
      mesh.points.push_back(
        Plus(foot, Vec3{ r * std::sin(angle), h * height, r * std::cos(angle) }));
    }
  }
  const auto at = [](std::uint32_t i, std::uint32_t j) { return i * around + j % around; };
  for (std::uint32_t j = 0; j < around; ++j)
  {
    for (std::uint32_t i = 0; i + 1 < rings; ++i)
    {
      mesh.triangles.push_back({ at(i, j), at(i, j + 1), at(i + 1, j + 1) });
      mesh.triangles.push_back({ at(i, j), at(i + 1, j + 1), at(i + 1, j) });
    }
    mesh.triangles.push_back({ at(0, j + 1), at(0, j), at(0, 0) });
    mesh.triangles.push_back({ at(rings - 1, j), at(rings - 1, j + 1), at(rings - 1, 0) });
  }
  return mesh;
}

// y is up, and the face towards +z: a plinth, shoulders, a neck, a head with a nose and wrinkles.
Mesh Bust()
{
  return Bag({ 5, 2, 1 }, 2,
    [](double h, double turn)
    {
      const double torso = h < 0.55 ? 0.6 - 0.5 * h * h : 0;
      const double away = (h - 0.8) / 0.21;
      const double head = std::abs(away) < 1 ? 0.45 * std::sqrt(1 - away * away) : 0;
      const double ahead = std::min(turn, 1 - turn); // angle from the line of the nose
      const double face =
        h > 0.62 && h < 0.98 && ahead < 0.2 ? 0.05 * std::sin(120 * h) * (1 - ahead / 0.2) : 0;
      return std::max({ torso, head, 0.2 }) + face;
    });
}

// y is up, and the head towards +x: a body on four legs.
Mesh Horse()
{
  Mesh mesh;
  for (const double x : { -0.7, 0.7 })
  {
    for (const double z : { -0.2, 0.2 })
    {
      Append(mesh, Bag({ x, 0, z }, 1, [](double, double) { return 0.08; }));
    }
  }
  Mesh body = Bag({ 0, 0, 0 }, 2.2,
    [](double h, double) { return 0.05 + 0.35 * std::sqrt(std::max(0.0, 4 * h * (1 - h))); });
  for (Vec3& p : body.points)
  {
    p = { p[1] - 1.1, 1.2 - p[0], p[2] };
  }
  Append(mesh, body);
  Append(mesh, Bag({ 0.95, 1.3, 0 }, 0.9, [](double, double) { return 0.12; }));
  return mesh;
}

using Turn = std::function<Vec3(const Vec3&)>;

Mesh Turned(Mesh mesh, const Turn& turn)
{
  for (Vec3& p : mesh.points)
  {
    p = turn(p);
  }
  return mesh;
}

HomeView Guess(const Mesh& mesh, std::string_view ending = ".ply")
{
  return GuessHomeView(mesh.points, mesh.triangles, ending, std::nullopt, std::nullopt);
}

const Turn asItIs = [](const Vec3& p) { return p; };
const Turn zUp = [](const Vec3& p) { return Vec3{ p[0], -p[2], p[1] }; };
const Turn zUpFromBehind = [](const Vec3& p) { return Vec3{ -p[0], p[2], p[1] }; };
const Turn upsideDown = [](const Vec3& p) { return Vec3{ p[0], -p[1], -p[2] }; };
const Turn lengthAlongZ = [](const Vec3& p) { return Vec3{ p[2], p[1], -p[0] }; };

}

TEST(TestGuessHomeView, ABustStandsOnItsPlinthAndShowsItsFace)
{
  for (const Turn& turn : { asItIs, zUp, zUpFromBehind, upsideDown })
  {
    const HomeView homeView = Guess(Turned(Bust(), turn));
    EXPECT_EQ(homeView.up, turn({ 0, 1, 0 }));
    EXPECT_EQ(homeView.view, turn({ 0, 0, 1 }));
    EXPECT_TRUE(homeView.guessed);
  }
}

// Deeper than wide, with its head forward. Its left and right sides are mirror images, which shows
// where its face is.
TEST(TestGuessHomeView, AHeadIsNotSeenInProfile)
{
  const Mesh deep = Turned(Bust(),
    [](const Vec3& p) {
      return Vec3{ p[0], p[1], 1.35 * p[2] + (p[1] > 3.2 ? 0.3 : 0) };
    });
  for (const Turn& turn : { asItIs, zUp, zUpFromBehind })
  {
    EXPECT_EQ(Guess(Turned(deep, turn)).view, turn({ 0, 0, 1 }));
  }
}

// The shape has no foot to stand on, and in most files of this kind z is up, so it would lie on its
// back.
TEST(TestGuessHomeView, WhatHasAFaceAheadStands)
{
  const Mesh egg = Bag({}, 2,
    [](double h, double turn)
    {
      const double ahead = std::min(turn, 1 - turn);
      const double face =
        h > 0.3 && h < 0.8 && ahead < 0.2 ? 0.05 * std::sin(60 * h) * (1 - ahead / 0.2) : 0;
      return std::max(0.7 * std::sqrt(std::max(0.0, 4 * h * (1 - h))), 0.02) + face;
    });
  EXPECT_EQ(Guess(egg).up, (Vec3{ 0, 1, 0 }));
  EXPECT_EQ(Guess(egg).view, (Vec3{ 0, 0, 1 }));
}

TEST(TestGuessHomeView, AVaseIsNotABustUpsideDown)
{
  const Mesh vase = Bag({}, 1.8, [](double h, double) { return 0.25 + 1.3 * h * (1.15 - h); });
  EXPECT_EQ(Guess(vase).up, (Vec3{ 0, 1, 0 }));
  EXPECT_EQ(Guess(Turned(vase, zUp)).up, (Vec3{ 0, 0, 1 }));
}

TEST(TestGuessHomeView, AHorseStandsOnItsFeetAndIsSeenFromItsSide)
{
  for (const Turn& turn : { asItIs, zUp, lengthAlongZ })
  {
    const HomeView homeView = Guess(Turned(Horse(), turn));
    EXPECT_EQ(homeView.up, turn({ 0, 1, 0 }));
    EXPECT_EQ(std::abs(Dot(homeView.view, turn({ 0, 0, 1 }))), 1);
  }
}

TEST(TestGuessHomeView, WhatIsFlatLiesAndIsSeenFromAbove)
{
  const Mesh terrain = // z as a function of x and y
    Turned(HeightField(40),
      [](const Vec3& p) {
        return Vec3{ p[0], p[1], 0.2 * p[2] };
      });
  EXPECT_EQ(Guess(terrain).up, (Vec3{ 0, 0, 1 }));
  EXPECT_EQ(Guess(ThinPlate(8)).view, Guess(ThinPlate(8)).up);
}

TEST(TestGuessHomeView, AWallIsSeenFromWhereItFaces)
{
  const Mesh wall = Turned(GridPlate(10), [](const Vec3& p) { return Vec3{ p[0], 0, p[1] }; });
  EXPECT_EQ(Guess(wall).up, (Vec3{ 0, 0, 1 }));
  EXPECT_EQ(Guess(wall).view, (Vec3{ 0, -1, 0 }));
  const Mesh ground = Turned(GridPlate(10), [](const Vec3& p) { return Vec3{ p[0], 0, -p[1] }; });
  EXPECT_EQ(Guess(ground).up, (Vec3{ 0, 1, 0 }));
  EXPECT_EQ(Guess(ground).view, (Vec3{ 0, 1, 0 }));
}

TEST(TestGuessHomeView, WhereTheShapeDoesNotSayTheFormatDoes)
{
  const Mesh ball = DisplacedSphere(4);
  EXPECT_EQ(Guess(ball, ".ply").up, (Vec3{ 0, 0, 1 }));
  EXPECT_EQ(Guess(ball, ".stl").view, (Vec3{ 0, -1, 0 }));
  EXPECT_EQ(Guess(ball, ".obj").up, (Vec3{ 0, 1, 0 }));
  EXPECT_EQ(Guess(ball, ".off").up, (Vec3{ 0, 1, 0 }));
  const HomeView gltf = Guess(Turned(Bust(), zUp), ".glb");
  EXPECT_EQ(gltf.up, (Vec3{ 0, 1, 0 }));
  EXPECT_EQ(gltf.view, (Vec3{ 0, 0, 1 }));
}

TEST(TestGuessHomeView, WhatIsGivenStays)
{
  const Mesh bust = Bust();
  const Vec3 up{ 0, 0.6, 0.8 }, view{ 1, 0, 0 };
  const HomeView both = GuessHomeView(bust.points, bust.triangles, ".ply", up, view);
  EXPECT_EQ(both.up, up);
  EXPECT_EQ(both.view, view);
  EXPECT_FALSE(both.guessed);
  const HomeView one = GuessHomeView(bust.points, bust.triangles, ".ply", up, std::nullopt);
  EXPECT_TRUE(one.guessed);
  EXPECT_NEAR(Dot(one.view, up), 0, 1e-15) << "the view is level";
  EXPECT_NEAR(Length(one.view), 1, 1e-15);
  // For this up direction the front is as near to y as the up direction itself.
  const Vec3 leaning{ 0, std::sqrt(0.5), std::sqrt(0.5) };
  const HomeView between =
    GuessHomeView(bust.points, bust.triangles, ".ply", leaning, std::nullopt);
  EXPECT_EQ(between.view[0], 0);
}

// The home view of any mesh has valid directions.
TEST(TestGuessHomeView, EveryMeshHasAHomeView)
{
  for (const NamedMesh& named : AllMeshes())
  {
    SCOPED_TRACE(named.name);
    for (const std::string_view ending : { ".ply", ".obj", ".glb" })
    {
      const HomeView homeView = Guess(named.mesh, ending);
      EXPECT_NEAR(Length(homeView.up), 1, 1e-12);
      EXPECT_NEAR(Length(homeView.view), 1, 1e-12);
    }
  }
  EXPECT_EQ(Guess(Mesh{}).up, (Vec3{ 0, 0, 1 }));
}

TEST(TestGuessHomeView, AllBuildsGuessAlike)
{
  const TemporaryFolder folder;
  const fs::path input = folder / "bust.ply", store = folder / "bust.kds";
  ASSERT_TRUE(WriteMesh(input, Turned(Bust(), zUp)));
  const auto inMemory = BuildStore(input, store, {});
  ASSERT_TRUE(inMemory) << inMemory.GetError().message;
  BuildOptions little;
  little.memory = std::uint64_t{ 64 } << 20;
  const auto externally = BuildStoreExternally(input, store, little, MakeTbbExecution(2));
  ASSERT_TRUE(externally) << externally.GetError().message;
  const HomeView expected{ { 0, 0, 1 }, { 0, -1, 0 }, true };
  EXPECT_EQ(inMemory->info.homeView, expected);
  EXPECT_EQ(externally->info.homeView, expected);
  EXPECT_EQ((*Store::Open(store))->Info().homeView, expected);
  BuildOptions given;
  given.up = Vec3{ 1, 0, 0 };
  given.view = Vec3{ 0, 1, 0 };
  const auto reported = BuildStore(input, store, given);
  ASSERT_TRUE(reported);
  EXPECT_EQ(reported->info.homeView, (HomeView{ *given.up, *given.view, false }));
  EXPECT_EQ(reported->info.digest, inMemory->info.digest) << "it is no content";
}
