// SPDX-License-Identifier: BSD-3-Clause
// The camera fits a box, follows fingers, and stays valid whatever the fingers do.
#include "viewer/session/Camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

using namespace kdstream;

namespace
{

Box TestBox()
{
  Box box;
  box.Add(Vec3{ 100, 200, -50 });
  box.Add(Vec3{ 103, 206, -46 });
  return box;
}

Camera Fitted(int width, int height)
{
  Camera camera;
  camera.SetViewport({ width, height, 1 });
  camera.FitTo(TestBox());
  return camera;
}

// The pixel of a point, the inverse of RayOf.
std::array<double, 2> Project(const Camera& camera, const Vec3& point)
{
  const Vec3 v = point - camera.Eye();
  const double depth = Dot(v, camera.Forward());
  const double scale = camera.GetViewport().height / (2 * Camera::tangentOfHalfAngle * depth);
  return { camera.GetViewport().width * 0.5 + Dot(v, camera.Right()) * scale,
    camera.GetViewport().height * 0.5 - Dot(v, camera.Up()) * scale };
}

double DistanceToLine(const Ray& ray, const Vec3& point)
{
  return Length(Cross(point - ray.origin, ray.direction));
}

TEST(TestCamera, FitsTheBoxInPortraitAndLandscape)
{
  for (const auto& [width, height] : { std::pair{ 1280, 720 }, { 720, 1280 }, { 500, 500 } })
  {
    Camera camera = Fitted(width, height);
    EXPECT_EQ(camera.Focal(), (Vec3{ 101.5, 203, -48 }));
    // All corners are visible, and the box fills one side of the window except for a margin.
    std::array<double, 2> lo{ 1e9, 1e9 }, hi{ -1e9, -1e9 };
    const Box box = TestBox();
    for (unsigned corner = 0; corner < 8; ++corner)
    {
      const auto pixel =
        Project(camera, { corner & 1 ? box.hi[0] : box.lo[0], corner & 2 ? box.hi[1] : box.lo[1],
                          corner & 4 ? box.hi[2] : box.lo[2] });
      for (std::size_t k = 0; k < 2; ++k)
      {
        lo[k] = std::min(lo[k], pixel[k]);
        hi[k] = std::max(hi[k], pixel[k]);
      }
    }
    EXPECT_TRUE(lo[0] >= 0 && hi[0] <= width && lo[1] >= 0 && hi[1] <= height);
    EXPECT_GT(std::max((hi[0] - lo[0]) / width, (hi[1] - lo[1]) / height), 0.9);
  }
}

TEST(TestCamera, OddBoxesStillGiveACamera)
{
  Camera camera;
  camera.FitTo(Box{});
  EXPECT_GT(camera.Distance(), 0);
  Box point;
  point.Add(Vec3{ 3, 3, 3 });
  camera.FitTo(point);
  EXPECT_EQ(camera.Focal(), (Vec3{ 3, 3, 3 }));
  EXPECT_TRUE(std::isfinite(camera.Distance()) && camera.Distance() > 0);
}

TEST(TestCamera, RotationKeepsFocalPointAndDistanceAndFollowsTheFinger)
{
  Camera camera = Fitted(800, 600);
  const double distance = camera.Distance();
  // The point of the ball under the finger follows the finger to the right.
  camera.Rotate(400, 300, 420, 300);
  EXPECT_LT(camera.Eye()[0], camera.Focal()[0]);
  EXPECT_DOUBLE_EQ(camera.Eye()[1], camera.Focal()[1]);
  camera.Rotate(420, 300, 400, 300);
  EXPECT_NEAR(camera.Eye()[0], camera.Focal()[0], 1e-12 * distance);
  camera.Rotate(400, 300, 400, 330); // down: the eye goes up
  EXPECT_GT(camera.Eye()[1], camera.Focal()[1]);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> pixel(-5000, 5000);
  for (int i = 0; i < 10000; ++i)
  {
    camera.Rotate(pixel(random), pixel(random), pixel(random), pixel(random));
  }
  EXPECT_NEAR(Length(camera.Eye() - camera.Focal()), distance, 1e-9 * distance);
  EXPECT_NEAR(Length(camera.Up()), 1, 1e-12);
  EXPECT_NEAR(Dot(camera.Up(), camera.Forward()), 0, 1e-12);
}

TEST(TestCamera, PanMovesTheFocalPlaneWithTheFinger)
{
  Camera camera = Fitted(800, 600);
  camera.Rotate(100, 100, 300, 250);
  const Vec3 point = camera.Focal();
  camera.Pan(37, -21);
  const auto pixel = Project(camera, point);
  EXPECT_NEAR(pixel[0], 437, 1e-6);
  EXPECT_NEAR(pixel[1], 279, 1e-6);
  for (int i = 0; i < 100; ++i)
  {
    camera.Pan(500, 300);
  }
  const auto corner = Project(camera, TestBox().lo);
  EXPECT_LT(corner[0], 800) << "some of the box stays on the screen";
}

TEST(TestCamera, ZoomKeepsThePointUnderThePixel)
{
  std::mt19937 random(5);
  std::uniform_real_distribution<double> x(200, 600), y(150, 450), factor(0.7, 1.6);
  for (int i = 0; i < 200; ++i)
  {
    Camera camera = Fitted(800, 600);
    camera.Rotate(x(random), y(random), x(random), y(random));
    const double px = x(random), py = y(random), f = factor(random);
    const Ray ray = camera.RayOf(px, py);
    const double along = camera.Distance() / Dot(ray.direction, camera.Forward());
    const Vec3 point = ray.origin + ray.direction * along;
    const double scale = camera.PixelsPerUnit();
    camera.Zoom(f, px, py);
    EXPECT_NEAR(camera.PixelsPerUnit(), scale * f, 1e-9 * scale);
    const auto pixel = Project(camera, point);
    EXPECT_NEAR(pixel[0], px, 1e-6);
    EXPECT_NEAR(pixel[1], py, 1e-6);
  }
}

TEST(TestCamera, ZoomStaysWithinItsLimits)
{
  Camera camera = Fitted(800, 600);
  const double radius = Length(TestBox().hi - TestBox().lo) / 2;
  for (int i = 0; i < 200; ++i)
  {
    camera.Zoom(3, 10, 10);
  }
  EXPECT_NEAR(camera.Distance(), 1e-4 * radius, 1e-12);
  for (int i = 0; i < 200; ++i)
  {
    camera.Zoom(0.1, 10, 10);
  }
  EXPECT_NEAR(camera.Distance(), 20 * radius, 1e-6);
  camera.Zoom(0, 1, 1);
  camera.Zoom(-1, 1, 1);
  camera.Zoom(std::nan(""), 1, 1);
  EXPECT_NEAR(camera.Distance(), 20 * radius, 1e-6);
}

TEST(TestCamera, FocusingChangesNoPicture)
{
  Camera camera = Fitted(800, 600);
  camera.Rotate(100, 100, 200, 300);
  const Vec3 eye = camera.Eye(), up = camera.Up(), corner = TestBox().hi;
  const auto before = Project(camera, corner);
  camera.FocusAtDepthOf(corner);
  EXPECT_NEAR(Dot(corner - eye, camera.Forward()), camera.Distance(), 1e-9);
  EXPECT_NEAR(Length(camera.Eye() - eye), 0, 1e-9);
  EXPECT_EQ(camera.Up(), up);
  EXPECT_NEAR(Project(camera, corner)[0], before[0], 1e-6);
  const Camera kept = camera;
  camera.FocusAtDepthOf(eye - camera.Forward()); // behind the eye
  EXPECT_EQ(camera.Focal(), kept.Focal());
}

TEST(TestCamera, UprightTurnsAboutUpAndStopsAboveAndBelow)
{
  Camera camera = Fitted(800, 600);
  camera.SetTurning(Turning::Upright);
  Camera free = Fitted(800, 600);
  camera.Rotate(400, 300, 405, 300);
  free.Rotate(400, 300, 405, 300);
  EXPECT_LT(Length(camera.Eye() - free.Eye()), 1e-4 * camera.Distance()) << "as fast as the ball";
  camera.Rotate(0, 0, 1234, 0);
  EXPECT_EQ(camera.Eye()[1], camera.Focal()[1]) << "across: the eye keeps its height";
  EXPECT_NEAR(Dot(camera.Up(), { 0, 1, 0 }), 1, 1e-12);
  camera.Rotate(0, 0, 0, 100);
  EXPECT_GT(camera.Eye()[1], camera.Focal()[1]) << "down: the eye goes up";
  for (const double way : { 5000.0, -5000.0, 300.0, -1e9 })
  {
    camera.Rotate(0, 0, 0, way);
    EXPECT_NEAR(camera.Right()[1], 0, 1e-12);
    EXPECT_GE(camera.Up()[1], -1e-12) << "never upside down";
  }
  EXPECT_NEAR(camera.Forward()[1], 1, 1e-12) << "from straight below";
}

TEST(TestCamera, AWholeTurnComesBack)
{
  Camera camera = Fitted(600, 600);
  camera.SetTurning(Turning::Upright);
  const Vec3 eye = camera.Eye();
  const double turn = 2 * std::acos(-1.0) * 300; // pixels
  camera.Rotate(0, 0, turn, 0);
  EXPECT_LT(Length(camera.Eye() - eye), 1e-7 * camera.Distance());
  for (int i = 0; i < 1000; ++i)
  {
    camera.Rotate(0, 0, turn / 1000, 0);
  }
  EXPECT_LT(Length(camera.Eye() - eye), 1e-7 * camera.Distance()) << "in steps or at once";
}

TEST(TestCamera, UprightLevelsTheHorizonAndKeepsTheView)
{
  std::mt19937 random(11);
  std::uniform_real_distribution<double> pixel(0, 800);
  for (int i = 0; i < 200; ++i)
  {
    Camera camera = Fitted(800, 600);
    camera.SetUp({ 0, 0, 1 });
    camera.Rotate(pixel(random), pixel(random), pixel(random), pixel(random));
    camera.Rotate(pixel(random), pixel(random), pixel(random), pixel(random));
    const Camera before = camera;
    camera.SetTurning(Turning::Upright);
    EXPECT_LT(Length(camera.Eye() - before.Eye()), 1e-12 * 1000);
    EXPECT_LT(Length(camera.Forward() - before.Forward()), 1e-12);
    EXPECT_NEAR(camera.Right()[2], 0, 1e-12);
    EXPECT_GE(camera.Up()[2], 0);
  }
}

TEST(TestCamera, RollTurnsThePictureAboutThePixel)
{
  Camera camera = Fitted(800, 600);
  const Ray ray = camera.RayOf(500, 200);
  const double along = camera.Distance() / Dot(ray.direction, camera.Forward());
  const Vec3 pivot = ray.origin + ray.direction * along;
  const Vec3 right = pivot + camera.Right(); // a clockwise roll moves a point on the right down
  const Camera before = camera;
  camera.Roll(0.8, 0.6, 500, 200);
  EXPECT_NEAR(Project(camera, pivot)[0], 500, 1e-6);
  EXPECT_NEAR(Project(camera, pivot)[1], 200, 1e-6);
  const double way = Project(before, right)[0] - 500;
  EXPECT_NEAR(Project(camera, right)[0], 500 + 0.8 * way, 1e-6);
  EXPECT_NEAR(Project(camera, right)[1], 200 + 0.6 * way, 1e-6);
  Camera upright = before;
  upright.SetTurning(Turning::Upright);
  const Camera level = upright;
  upright.Roll(0.8, 0.6, 500, 200);
  EXPECT_EQ(upright, level);
}

TEST(TestCamera, LooksFromAnySide)
{
  EXPECT_EQ(LookingFrom({ 0, 0, 1 }, { 0, 1, 0 }), Quaternion{});
  std::mt19937 random(3);
  std::normal_distribution<double> any;
  const auto direction = [&] { return Normalized({ any(random), any(random), any(random) }); };
  for (int i = 0; i < 1000; ++i)
  {
    const Vec3 up = direction(), view = i % 10 == 0 ? up * (i % 20 == 0 ? 1 : -1) : direction();
    const Quaternion turn = LookingFrom(view, up);
    EXPECT_LT(Length(turn.Rotate({ 0, 0, 1 }) - view), 1e-12);
    EXPECT_NEAR(Dot(turn.Rotate({ 1, 0, 0 }), up), 0, 1e-12);
    EXPECT_GE(Dot(turn.Rotate({ 0, 1, 0 }), up), -1e-12);
  }
}

TEST(TestCamera, RaysGoThroughTheirPixels)
{
  Camera camera = Fitted(640, 960);
  camera.Rotate(10, 700, 300, 40);
  std::mt19937 random(2);
  for (int i = 0; i < 100; ++i)
  {
    const double x = static_cast<double>(random() % 640), y = static_cast<double>(random() % 960);
    const Ray ray = camera.RayOf(x, y);
    EXPECT_NEAR(Length(ray.direction), 1, 1e-12);
    const auto pixel = Project(camera, ray.origin + ray.direction * 3);
    EXPECT_NEAR(pixel[0], x, 1e-6);
    EXPECT_NEAR(pixel[1], y, 1e-6);
  }
  EXPECT_LT(DistanceToLine(camera.RayOf(320, 480), camera.Focal()), 1e-9);
}

}
