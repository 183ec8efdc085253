// SPDX-License-Identifier: BSD-3-Clause
// Ambient occlusion in the phone's pictures: hollows get darker, and nothing else changes.
#include "Testing/Fixtures/DepthStep.h"
#include "viewer/mobile/Testing/GlesTools.h"

#include <cmath>
#include <string>

namespace kdstream::test
{
namespace
{

constexpr int width = 201, height = 150; // odd, so that half of it is not an integer

ViewerScene SceneBefore(Surface surface, const Vec3& eye, double viewAngle = 0.6)
{
  ViewerScene scene = SceneOf(std::move(surface));
  scene.eye = eye;
  scene.focal = { 0, 0, 0 };
  scene.viewAngle = viewAngle;
  return scene;
}

struct Pair
{
  Image plain, occluded;
};

Pair DrawBoth(Canvas& canvas, const ViewerScene& scene)
{
  canvas.renderer->SetOcclusion(false);
  Pair pair;
  pair.plain = canvas.Draw(scene);
  canvas.renderer->SetOcclusion(true);
  pair.occluded = canvas.Draw(scene);
  return pair;
}

// The share of light that is left at a pixel, 0 to 1.
double LeftAt(const Pair& pair, int x, int y)
{
  const std::size_t i = 3 * static_cast<std::size_t>(y * width + x);
  return static_cast<double>(pair.occluded[i]) / pair.plain[i];
}

// A plane does not change, whatever its slope, and however wide the angle of view.
TEST(GlesOcclusion, APlaneStaysAsItIs)
{
  for (const double slope : { 0.0, 0.5, -1.0, 2.0 })
  {
    for (const double viewAngle : { 0.2, 1.2 })
    {
      SCOPED_TRACE(std::to_string(slope) + ", " + std::to_string(viewAngle));
      Canvas canvas(width, height);
      const double distance = 1.5 / std::tan(0.5 * viewAngle);
      const Pair pair = DrawBoth(canvas,
        SceneBefore(Extruded({ { -1, -slope }, { 1, slope } }), { 0, 0, distance }, viewAngle));
      EXPECT_LE(Compare(pair.plain, pair.occluded).largest, 3);
    }
  }
}

TEST(GlesOcclusion, APlaneStaysAsItIsWhereDepthsAreCoarse)
{
  for (const double slope : { 0.0, 0.5, -1.0 })
  {
    for (const double viewAngle : { 0.05, 0.2, 1.2 })
    {
      SCOPED_TRACE(std::to_string(slope) + ", " + std::to_string(viewAngle));
      Canvas canvas(width, height);
      const Pair pair =
        DrawBoth(canvas, SceneBefore(AroundTheEye(Extruded({ { -1, -slope }, { 1, slope } })),
                           { 0, 0, 5 }, viewAngle));
      EXPECT_LE(Compare(pair.plain, pair.occluded).largest, 3);
    }
  }
}

TEST(GlesOcclusion, AGrooveIsDarkWhereDepthsAreCoarse)
{
  Canvas canvas(width, height);
  const Pair pair = DrawBoth(canvas,
    SceneBefore(
      AroundTheEye(Extruded({ { -1, 0 }, { -0.15, 0 }, { 0, -0.3 }, { 0.15, 0 }, { 1, 0 } })),
      { 0, 0, 5 }));
  EXPECT_LT(LeftAt(pair, 100, 75), 0.6);
  EXPECT_GT(LeftAt(pair, 130, 75), 0.97);
}

// A valley along y, made of n × n quads.
Surface Valley(double slope, std::uint32_t n)
{
  Surface surface;
  for (std::uint32_t i = 0; i <= n; ++i)
  {
    for (std::uint32_t j = 0; j <= n; ++j)
    {
      const double x = -2.0 + 4.0 * i / n;
      surface.points.push_back({ x, -2.0 + 4.0 * j / n, slope * std::abs(x) });
      surface.sources.push_back({ Resolution::Level(7), MakeKey(0, i * (n + 1) + j) });
      if (i < n && j < n)
      {
        const VertexId a = i * (n + 1) + j;
        surface.triangles.push_back({ a, a + n + 1, a + 1 });
        surface.triangles.push_back({ a + 1, a + n + 1, a + n + 2 });
      }
    }
  }
  return surface;
}

// If triangles are larger than the search radius, a shallow concave edge is ignored, because it may
// only come from dividing a round surface into triangles. A deep one is dark.
TEST(GlesOcclusion, AShallowValleyIsDarkWhereItsTrianglesAreSmall)
{
  const auto left = [](double slope, std::uint32_t quads)
  {
    Canvas canvas(width, height);
    return LeftAt(DrawBoth(canvas, SceneBefore(Valley(slope, quads), { 0, 0, 5 })), 100, 75);
  };
  EXPECT_LT(left(0.12, 200), 0.975);
  EXPECT_GT(left(0.12, 2), 0.99);
  EXPECT_LT(left(1.0, 2), 0.7);
  EXPECT_NEAR(left(1.0, 2), left(1.0, 200), 0.08);
}

// A groove is dark at its bottom, less dark at its walls, and not dark beside it; a ridge is not
// darkened. This is the same for any size of the model, and any distance from the origin.
TEST(GlesOcclusion, AGrooveIsDark)
{
  const std::vector<std::array<double, 2>> profile{ { -1, 0 }, { -0.15, 0 }, { 0, -0.3 },
    { 0.15, 0 }, { 1, 0 } };
  for (const double unit : { 1.0, 1e-6, 1e7 })
  {
    SCOPED_TRACE(unit);
    Surface groove = Extruded(profile);
    for (Vec3& point : groove.points)
    {
      point = point * unit;
    }
    Canvas canvas(width, height);
    ViewerScene scene = SceneBefore(std::move(groove), { 0, 0, 5 * unit });
    scene.up = { 0, 1, 0 };
    const Pair pair = DrawBoth(canvas, scene);
    const double bottom = LeftAt(pair, 100, 75), wall = LeftAt(pair, 104, 75),
                 beside = LeftAt(pair, 130, 75);
    EXPECT_LT(bottom, 0.55);
    EXPECT_LT(bottom, wall - 0.05);
    EXPECT_LT(wall, 0.95);
    EXPECT_GT(beside, 0.97);
  }
  std::vector<std::array<double, 2>> ridge = profile;
  ridge[2][1] = 0.3;
  Canvas canvas(width, height);
  const Pair pair = DrawBoth(canvas, SceneBefore(Extruded(ridge), { 0, 0, 5 }));
  EXPECT_GT(LeftAt(pair, 100, 75), 0.97);
  EXPECT_LT(LeftAt(pair, 108, 75), 0.9); // the foot of the ridge
}

// Near parts do not darken distant parts behind them, or the background, not even at outlines.
TEST(GlesOcclusion, OnlyWhatIsNearDarkens)
{
  const Surface two =
    Joined(Extruded({ { -1, 0 }, { 1, 0 } }), Extruded({ { -0.2, 3 }, { 0.2, 3 } }));
  Canvas canvas(width, height);
  const Pair pair = DrawBoth(canvas, SceneBefore(two, { 0, 0, 8 }));
  EXPECT_NE(pair.plain[0],
    pair.plain[3 * (75 * width + 100)]); // the picture has background
  EXPECT_LE(Compare(pair.plain, pair.occluded).largest, 3);
}

// There are no dark dots on a near part, and no bright dots on what is behind it.
TEST(GlesOcclusion, EdgesOfNearPartsAreClean)
{
  Canvas canvas(width, height);
  ViewerScene scene = SceneBefore(DepthStep(0.12), { 0, 0, 5 });
  scene.up = UpOfDepthStep();
  const Pair pair = DrawBoth(canvas, scene);
  ExpectCleanEdge(width, height, [&](int x, int y) { return LeftAt(pair, x, y); });
}

// Where a groove runs into the outline, none of the background's pixels is darkened.
TEST(GlesOcclusion, TheBackgroundStaysAsItIs)
{
  const ViewerScene scene = SceneBefore(
    Extruded({ { -1, 0 }, { -0.2, 0 }, { 0, -0.6 }, { 0.2, 0 }, { 1, 0 } }), { 0, 0, 12 });
  Canvas canvas(width, height);
  canvas.renderer->SetBackground({ 0, 0, 0 }, { 0, 0, 0 });
  const Image black = canvas.Draw(scene);
  canvas.renderer->SetBackground({ 1, 1, 1 }, { 1, 1, 1 });
  const Pair pair = DrawBoth(canvas, scene);
  std::size_t around = 0, darker = 0;
  for (std::size_t i = 0; i < black.size(); ++i)
  {
    const bool isBackground = black[i] == 0 && pair.plain[i] == 255;
    around += isBackground ? 1 : 0;
    darker += pair.occluded[i] + 20 < pair.plain[i] ? 1 : 0;
    EXPECT_TRUE(!isBackground || pair.occluded[i] == 255) << i;
  }
  EXPECT_GT(around, black.size() / 4);
  EXPECT_GT(darker, 100U);
}

TEST(GlesOcclusion, FollowsSizesAndSurvivesALostContext)
{
  const ViewerScene scene = SceneOf(BumpySphere(40));
  Canvas canvas(width, height);
  const Pair pair = DrawBoth(canvas, scene);
  EXPECT_GT(Compare(pair.plain, pair.occluded).mean, 0.3);
  for (const Viewport& other :
    { Viewport{ 64, 48, 1 }, Viewport{ 1, 1, 1 }, Viewport{ 2, 149, 1 } })
  {
    ASSERT_TRUE(canvas.renderer->Draw(scene, other));
  }
  EXPECT_EQ(canvas.Draw(scene), pair.occluded);
  // The context is not really lost, so the forgotten objects stay in it until it is destroyed.
  canvas.renderer->Forget();
  EXPECT_EQ(canvas.Draw(scene), pair.occluded);
}

TEST(GlesOcclusion, NothingIsDrawnWithoutATriangle)
{
  ViewerScene scene = SceneOf(Surface());
  scene.box = {};
  Canvas canvas(width, height);
  const Pair pair = DrawBoth(canvas, scene);
  EXPECT_EQ(pair.plain, pair.occluded);
}

}
}
