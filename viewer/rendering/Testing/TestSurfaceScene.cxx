// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/CutWalk.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/core/drawing/DrawnSurface.h"
#include "viewer/rendering/ScenePart.h"
#include "viewer/rendering/Testing/RenderTools.h"

#include "viewer/session/Geometry.h"
#include "viewer/session/appearance/Palette.h"

#include <vtkActorCollection.h>
#include <vtkCamera.h>
#include <vtkRenderer.h>

#include <limits>
#include <map>
#include <numbers>
#include <random>
#include <set>

namespace kdstream::test
{
namespace
{

constexpr int side = 200;

Stage MakeStage()
{
  return Stage(WindowBackend::OsMesa, side, side);
}

// A sphere of radius 1 without bumps.
Surface SmoothSphere()
{
  Surface sphere = BumpySphere(60);
  for (Vec3& p : sphere.points)
  {
    const double length = std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    p = { p[0] / length, p[1] / length, p[2] / length };
  }
  return sphere;
}

// Updates and draws the scene; the eye is a little above and to the right of the center.
WindowPicture Draw(const Stage& stage, const Surface& surface, const Vec3& center = { 0, 0, 0 })
{
  const Status status = stage.scene->Update(surface, depths, center);
  EXPECT_TRUE(status) << (status ? "" : status.GetError().message);
  EXPECT_TRUE(stage.scene->SetCamera(CameraAt(center)));
  return stage.Draw();
}

// What the stage shows without a surface.
WindowPicture Background()
{
  return Draw(MakeStage(), Surface{});
}

std::set<vtkActor*> ActorsOf(SurfaceScene& scene)
{
  std::set<vtkActor*> actors;
  vtkActorCollection* all = scene.Renderer().GetActors();
  all->InitTraversal();
  while (vtkActor* actor = all->GetNextActor())
  {
    actors.insert(actor);
  }
  return actors;
}

// The hue of a pixel in steps of 10 degrees; -1 if it is almost grey.
int HueStep(const std::array<int, 3>& pixel)
{
  const int hi = std::max({ pixel[0], pixel[1], pixel[2] });
  const int lo = std::min({ pixel[0], pixel[1], pixel[2] });
  if (hi - lo < hi / 5)
  {
    return -1;
  }
  const double range = hi - lo;
  double sextant = 0.0;
  if (hi == pixel[0])
  {
    sextant = (pixel[1] - pixel[2]) / range;
  }
  else
  {
    sextant =
      hi == pixel[1] ? 2.0 + (pixel[2] - pixel[0]) / range : 4.0 + (pixel[0] - pixel[1]) / range;
  }
  return static_cast<int>(std::floor((sextant < 0.0 ? sextant + 6.0 : sextant) * 6.0));
}

// The hues that each cover at least a hundredth of the picture.
std::set<int> Hues(const WindowPicture& picture)
{
  std::map<int, int> counts;
  for (int y = 0; y < picture.height; ++y)
  {
    for (int x = 0; x < picture.width; ++x)
    {
      ++counts[HueStep(PixelAt(picture, x, y))];
    }
  }
  std::set<int> hues;
  for (const auto& [hue, count] : counts)
  {
    if (hue >= 0 && count * 100 >= picture.width * picture.height)
    {
      hues.insert(hue);
    }
  }
  return hues;
}

// Counts runs of neighbouring hues as one hue, because tinted lights spread a colour a little.
std::size_t DistinctHues(const std::set<int>& hues)
{
  std::size_t runs = 0;
  for (const int hue : hues)
  {
    runs += hues.count((hue + 35) % 36) == 0 ? 1 : 0;
  }
  return runs;
}

TEST(SurfaceScene, StandsBeforeASoftGradient)
{
  const WindowPicture picture = Background();
  for (int y = 0; y + 1 < side; ++y)
  {
    const double step = Brightness(PixelAt(picture, 7, y + 1)) - Brightness(PixelAt(picture, 7, y));
    EXPECT_GE(step, -1.0);
    EXPECT_LE(step, 2.0);
  }
  EXPECT_GT(BrightnessAround(picture, 0.5, 0.97, 3), 20 + BrightnessAround(picture, 0.5, 0.03, 3));
  EXPECT_NEAR(BrightnessAround(picture, 0.1, 0.5, 5), BrightnessAround(picture, 0.9, 0.5, 5), 1.0);
}

TEST(SurfaceScene, LightsFromAboveLeft)
{
  const WindowPicture picture = Draw(MakeStage(), SmoothSphere());
  const double lit = BrightnessAround(picture, 0.4, 0.35, 4);
  const double middle = BrightnessAround(picture, 0.55, 0.6, 4);
  const double dark = BrightnessAround(picture, 0.68, 0.75, 4);
  EXPECT_GT(lit, middle + 10);
  EXPECT_GT(middle, dark + 10);
  EXPECT_GT(lit, 150);
  EXPECT_LT(lit, 250);
  EXPECT_GT(dark, 25);
}

TEST(SurfaceScene, LightsFollowTheCamera)
{
  const Stage stage = MakeStage();
  const WindowPicture picture = Draw(stage, SmoothSphere());
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 6; ++i)
  {
    Vec3 eye{ normal(random), normal(random), normal(random) };
    const double scale = std::hypot(1.25, 1.0, 4.0) / std::hypot(eye[0], eye[1], eye[2]);
    eye = { eye[0] * scale, eye[1] * scale, eye[2] * scale };
    ASSERT_TRUE(stage.scene->SetCamera({ eye, { 0, 0, 0 }, { 0.1, 1, 0.2 }, 0.5 }));
    const WindowPicture turned = stage.Draw();
    for (const auto& [x, y] : { std::pair{ 0.4, 0.35 }, { 0.5, 0.5 }, { 0.68, 0.75 } })
    {
      EXPECT_NEAR(BrightnessAround(turned, x, y, 4), BrightnessAround(picture, x, y, 4), 4.0);
    }
  }
}

TEST(SurfaceScene, SurvivesHugeOffsets)
{
  const WindowPicture picture = Draw(MakeStage(), BumpySphere(60));
  for (const Vec3& offset : { Vec3{ 4e6, 4e6, 4e6 }, Vec3{ -4e6, 5e5, 0.0 } })
  {
    EXPECT_EQ(Compare(Draw(MakeStage(), BumpySphere(60, offset), offset), picture).pixels, 0u);
  }
}

TEST(SurfaceScene, DoesNotDependOnTheUnit)
{
  const WindowPicture picture = Draw(MakeStage(), BumpySphere(40));
  for (const double unit : { 0x1p-24, 0x1p24 })
  {
    Surface scaled = BumpySphere(40);
    for (Vec3& p : scaled.points)
    {
      p = { p[0] * unit, p[1] * unit, p[2] * unit };
    }
    const Stage stage = MakeStage();
    ASSERT_TRUE(stage.scene->Update(scaled, depths, { 0, 0, 0 }));
    SceneCamera camera = CameraAt({ 0, 0, 0 });
    camera.eye = { camera.eye[0] * unit, camera.eye[1] * unit, camera.eye[2] * unit };
    ASSERT_TRUE(stage.scene->SetCamera(camera));
    EXPECT_LE(Compare(stage.Draw(), picture).largest, 2) << unit;
  }
}

TEST(SurfaceScene, ColorsByPartition)
{
  const Stage stage = MakeStage();
  Draw(stage, BumpySphere(60));
  EXPECT_EQ(DistinctHues(Hues(stage.Draw())), 0u);
  SceneStyle style;
  style.coloring = SurfaceColoring::Partition;
  stage.scene->SetStyle(style);
  // There are eight octants, of which an eye on an axis sees four.
  EXPECT_GE(DistinctHues(Hues(Draw(stage, BumpySphere(60)))), 4u);
  std::set<int> all;
  for (const double z : { -4.0, 4.0 })
  {
    ASSERT_TRUE(stage.scene->SetCamera({ { 0, 0, z }, { 0, 0, 0 }, { 0, 1, 0 }, 0.5 }));
    const std::set<int> hues = Hues(stage.Draw());
    EXPECT_EQ(DistinctHues(hues), 4u);
    all.insert(hues.begin(), hues.end());
  }
  EXPECT_GE(DistinctHues(all), 7u);
  stage.scene->SetStyle({});
  EXPECT_EQ(DistinctHues(Hues(stage.Draw())), 0u);
}

TEST(SurfaceScene, ColorsByResolution)
{
  // The left half has the finest level and the partitions' numbers; the right half has a level
  // without partitions.
  Surface sphere = BumpySphere(60);
  for (std::size_t i = 0; i < sphere.points.size(); ++i)
  {
    const bool left = sphere.points[i][0] < 0.0;
    sphere.sources[i].resolution = Resolution::Level(left ? 7 : 3);
  }
  const Stage stage = MakeStage();
  SceneStyle style;
  style.coloring = SurfaceColoring::Resolution;
  stage.scene->SetStyle(style);
  EXPECT_EQ(DistinctHues(Hues(Draw(stage, sphere))), 2u);
  style.coloring = SurfaceColoring::Partition;
  stage.scene->SetStyle(style);
  const WindowPicture byPartition = stage.Draw();
  EXPECT_EQ(HueStep(PixelAt(byPartition, 150, 100)), -1);
  EXPECT_NE(HueStep(PixelAt(byPartition, 50, 100)), -1);
}

TEST(SurfaceScene, DrawsFlatTrianglesOnRequest)
{
  const Stage stage = MakeStage();
  const WindowPicture smooth = Draw(stage, BumpySphere(6));
  SceneStyle style;
  style.flat = true;
  stage.scene->SetStyle(style);
  const WindowPicture flat = stage.Draw();
  EXPECT_GT(Compare(smooth, flat).pixels, static_cast<std::size_t>(side * side / 10));
  const auto same = [](const WindowPicture& picture)
  {
    int count = 0;
    for (int x = side / 4; x < 3 * side / 4; ++x)
    {
      count += PixelAt(picture, x, side / 2) == PixelAt(picture, x + 1, side / 2) ? 1 : 0;
    }
    return count;
  };
  EXPECT_GT(same(flat), same(smooth));
}

// The brightness of a triangle that faces the eye and whose corners have this normal, in view
// coordinates: x right, y up, z to the eye.
double BrightnessBy(const Vec3& normal)
{
  const Stage stage = MakeStage();
  Surface triangle = BumpySphere(6);
  Draw(stage, triangle);
  vtkCamera* camera = stage.scene->Renderer().GetActiveCamera();
  const Vec3 toEye = Normalized(
    Vec3{ camera->GetPosition()[0], camera->GetPosition()[1], camera->GetPosition()[2] } -
    Vec3{ camera->GetFocalPoint()[0], camera->GetFocalPoint()[1], camera->GetFocalPoint()[2] });
  const Vec3 right = Normalized(Cross({ 0, 1, 0 }, toEye));
  const Vec3 up = Cross(toEye, right);
  for (vtkActor* actor : ActorsOf(*stage.scene))
  {
    actor->VisibilityOff();
  }
  triangle.points = { right * -1.0 - up, right - up, up };
  triangle.triangles = { { 0, 1, 2 } };
  triangle.sources.resize(3);
  const Vec3 turned = right * normal[0] + up * normal[1] + toEye * normal[2];
  const std::array<float, 3> corner{ static_cast<float>(turned[0]), static_cast<float>(turned[1]),
    static_cast<float>(turned[2]) };
  ScenePart part;
  part.Show(triangle, { corner, corner, corner }, depths, {}, {});
  stage.scene->Renderer().AddActor(&part.Actor());
  return BrightnessAround(stage.Draw(), 0.5, 0.5, 3);
}

// At an outline, interpolated normals face away from the eye, by much if the surface is coarse.
// Shaded parts must not be lit like the other side there.
TEST(SurfaceScene, HasNoBrightSliversAtDarkOutlines)
{
  const double shade = BrightnessBy(Normalized({ 0.7, -0.7, 0.1 }));
  const double light = BrightnessBy(Normalized({ -0.7, 0.7, 0.1 }));
  EXPECT_GT(light, 2 * shade);
  for (const double away : { 0.1, 0.3, 0.5, 0.7 })
  {
    const double across = std::sqrt((1 - away * away) / 2);
    EXPECT_NEAR(BrightnessBy({ across, -across, -away }), shade, 12) << away;
    EXPECT_NEAR(BrightnessBy({ -across, across, -away }), light, 12) << away;
  }
  // A normal that points straight away belongs to a folded triangle, which is lit like its other
  // side.
  EXPECT_NEAR(BrightnessBy({ 0, 0, -1 }), BrightnessBy({ 0, 0, 1 }), 1);
}

TEST(SurfaceScene, DrawsCloudsAsPoints)
{
  // From far and near, with many or few points, they cover the ball on which they lie.
  for (const std::uint32_t rows : { 20, 60, 200 })
  {
    Surface cloud = BumpySphere(rows);
    cloud.triangles.clear();
    const Stage stage = MakeStage();
    const WindowPicture background = Background();
    for (const double scale : { 1.0, 2.5 })
    {
      ASSERT_TRUE(stage.scene->Update(cloud, depths, { 0, 0, 0 }));
      SceneCamera camera = CameraAt({ 0, 0, 0 });
      camera.eye = { camera.eye[0] * scale, camera.eye[1] * scale, camera.eye[2] * scale };
      ASSERT_TRUE(stage.scene->SetCamera(camera));
      const std::size_t drawn = Compare(stage.Draw(), background).pixels;
      ASSERT_TRUE(stage.scene->Update(BumpySphere(rows), depths, { 0, 0, 0 }));
      const std::size_t solid = Compare(stage.Draw(), background).pixels;
      EXPECT_GT(drawn, solid * 9 / 10) << rows << " " << scale;
      EXPECT_LT(drawn, solid * 14 / 10) << rows << " " << scale;
    }
  }
}

// Counts the pixels of the middle row that have a hue.
int HuesInTheMiddle(const WindowPicture& picture)
{
  int count = 0;
  for (int x = 0; x < side; ++x)
  {
    count += HueStep(PixelAt(picture, x, side / 2)) >= 0 ? 1 : 0;
  }
  return count;
}

TEST(SurfaceScene, DrawsPointsRoundAndAsLargeAsTheyAreSeen)
{
  // Two points at a distance of 0.25: the radius of a splat is 0.82 times that.
  Surface pair;
  pair.points = { { -0.125, 0, 0 }, { 0.125, 0, 0 } };
  pair.sources.assign(2, { Resolution::Original(), 0 });
  SceneStyle style;
  style.coloring = SurfaceColoring::Partition;
  const Stage stage = MakeStage();
  stage.scene->SetStyle(style);
  ASSERT_TRUE(stage.scene->Update(pair, depths, { 0, 0, 0 }));
  for (const double distance : { 4.0, 8.0, 16.0 })
  {
    ASSERT_TRUE(stage.scene->SetCamera({ { 0, 0, distance }, { 0, 0, 0 }, { 0, 1, 0 }, 0.4 }));
    const double pixels = side / (2 * std::tan(0.2) * distance); // per unit of length
    EXPECT_NEAR(HuesInTheMiddle(stage.Draw()), (0.25 + 2 * 0.205) * pixels, 2) << distance;
  }
  // The right splat is round: the corners of the square around it are empty.
  ASSERT_TRUE(stage.scene->SetCamera({ { 0, 0, 4 }, { 0, 0, 0 }, { 0, 1, 0 }, 0.4 }));
  const double pixels = side / (2 * std::tan(0.2) * 4);
  const WindowPicture near = stage.Draw();
  const auto at = [&](double x, double y)
  {
    return HueStep(PixelAt(
      near, static_cast<int>(side / 2 + x * pixels), static_cast<int>(side / 2 + y * pixels)));
  };
  EXPECT_GE(at(0.125 + 0.17, 0), 0);
  EXPECT_GE(at(0.125 + 0.12, 0.12), 0);
  EXPECT_LT(at(0.125 + 0.16, 0.16), 0);
}

Surface PointsOfASquare()
{
  Surface cloud;
  for (int y = -100; y <= 100; ++y)
  {
    for (int x = -100; x <= 100; ++x)
    {
      cloud.points.push_back({ x * 0.02, y * 0.02, 0.0 });
      cloud.sources.emplace_back();
    }
  }
  return cloud;
}

Attribute OnEveryPoint(const Surface& surface, AttributeInfo info, const std::vector<double>& value)
{
  Attribute array{ std::move(info), {} };
  array.values.resize(surface.points.size() * array.TupleSize());
  for (std::size_t i = 0; i < surface.points.size(); ++i)
  {
    for (std::size_t k = 0; k < value.size(); ++k)
    {
      array.Set(i, k, value[k]);
    }
  }
  return array;
}

// Both sides are lit; sides that face away from the lights are darker.
TEST(SurfaceScene, LightsCloudsByTheirNormals)
{
  const auto brightness = [](const Vec3& normal)
  {
    Surface cloud = PointsOfASquare();
    cloud.attributes.push_back(
      OnEveryPoint(cloud, { "Normals", AttributeType::Float32, AttributeAssociation::Point, 3 },
        { normal[0], normal[1], normal[2] }));
    const Stage stage = MakeStage();
    EXPECT_TRUE(stage.scene->Update(cloud, depths, { 0, 0, 0 }));
    EXPECT_TRUE(stage.scene->SetCamera({ { 0, 0, 6 }, { 0, 0, 0 }, { 0, 1, 0 }, 0.4 }));
    return BrightnessAround(stage.Draw(), 0.5, 0.5, 5);
  };
  const double front = brightness({ 0, 0, 1 });
  EXPECT_NEAR(brightness({ 0, 0, -1 }), front, 1e-9);
  EXPECT_NEAR(brightness({ 0, 0, 1000 }), front, 1e-9);
  EXPECT_LT(brightness({ 0.7, -0.7, 0.1 }), 0.7 * front);
}

TEST(SurfaceScene, ShowsTheModelsOwnColors)
{
  for (const bool isCloud : { false, true })
  {
    for (const std::uint8_t components : { std::uint8_t{ 3 }, std::uint8_t{ 4 } })
    {
      Surface surface = BumpySphere(60);
      if (isCloud)
      {
        surface.triangles.clear();
      }
      surface.attributes.push_back(OnEveryPoint(surface,
        { components == 3 ? "RGB" : "RGBA", AttributeType::UInt8, AttributeAssociation::Point,
          components },
        { 20, 60, 200 }));
      const Stage stage = MakeStage();
      const auto own = PixelAt(Draw(stage, surface), side / 2, side / 2);
      EXPECT_GT(own[2], 2 * own[1]) << isCloud;
      EXPECT_GT(own[1], own[0]) << isCloud;
      SceneStyle style;
      style.coloring = SurfaceColoring::Stone;
      stage.scene->SetStyle(style);
      const auto stone = PixelAt(stage.Draw(), side / 2, side / 2);
      EXPECT_GT(stone[0], stone[2]) << isCloud;
      style.coloring = SurfaceColoring::Own;
      stage.scene->SetStyle(style);
      EXPECT_EQ(PixelAt(stage.Draw(), side / 2, side / 2), own);
    }
  }
}

TEST(SurfaceScene, DrawsCloudsAlikeWhateverDraws)
{
  const Surface cloud = PointsOfASquare();
  const Stage stage = MakeStage();
  ASSERT_TRUE(stage.scene->Update(cloud, depths, { 0, 0, 0 }));
  const WindowPicture picture = stage.Draw();
  for (const WindowBackend backend : { WindowBackend::Egl, WindowBackend::OsMesa })
  {
    Stage other(backend, side, side);
    ASSERT_TRUE(other.scene->Update(cloud, depths, { 0, 0, 0 }));
    EXPECT_EQ(Compare(other.Draw(), picture).pixels, 0u);
    for (const auto& [width, height] : { std::pair{ 1, 1 }, { 3, 90 }, { 90, 4 }, { 5, 5 } })
    {
      other.window->SetSize(width, height);
      other.Draw();
    }
    other.Draw();
    // Either the scene or the window may be destroyed first, while a cloud is shown.
    backend == WindowBackend::Egl ? other.scene.reset() : void(other.window = nullptr);
  }
}

TEST(SurfaceScene, ReplacesItsSurface)
{
  const Stage stage = MakeStage();
  const vtkRenderer* renderer = &stage.scene->Renderer();
  const WindowPicture coarse = Draw(stage, BumpySphere(8));
  const vtkActor* actor = stage.scene->Renderer().GetActors()->GetLastActor();
  const WindowPicture fine = Draw(stage, BumpySphere(60));
  EXPECT_GT(Compare(coarse, fine).pixels, 1000u);
  Surface cloud = BumpySphere(30);
  cloud.triangles.clear();
  Draw(stage, cloud);
  EXPECT_EQ(Compare(Draw(stage, BumpySphere(8)), coarse).pixels, 0u);
  EXPECT_EQ(Compare(Draw(stage, Surface{}), Background()).pixels, 0u);
  EXPECT_EQ(Compare(Draw(stage, BumpySphere(60)), fine).pixels, 0u);
  EXPECT_EQ(&stage.scene->Renderer(), renderer);
  EXPECT_EQ(stage.scene->Renderer().GetActors()->GetNumberOfItems(), 1);
  EXPECT_EQ(stage.scene->Renderer().GetActors()->GetLastActor(), actor);
}

// A series of cuts: actors of unchanged parts are kept, and the picture is the same as that of a
// new scene that has drawn only the last cut.
TEST(SurfaceScene, DrawsWhatDiffersAsAllAnew)
{
  const auto model = fixtures::MakeModel(fixtures::DisplacedSphere(4), { 60, {}, 8 }, {}, {}, 2);
  fixtures::CutWalk walk(*model, 11);
  SurfaceParts parts;
  PartNormals normals;
  const Stage stage = MakeStage();
  int kept = 0;
  for (unsigned step = 0; step < 40; ++step, walk.Step())
  {
    ASSERT_TRUE(parts.GoTo(walk.Now(), model->Lookup()));
    normals.GoTo(parts.Parts());
    const DrawnSurface surface(parts.Parts(), normals.Of());
    const std::set<vtkActor*> before = ActorsOf(*stage.scene);
    ASSERT_TRUE(stage.scene->Update(surface, model->tree.depths, { 0, 0, 0 }));
    for (vtkActor* actor : ActorsOf(*stage.scene))
    {
      kept += before.count(actor) > 0 ? 1 : 0;
    }
    ASSERT_TRUE(stage.scene->SetCamera(CameraAt({ 0, 0, 0 })));
    const WindowPicture picture = stage.Draw();
    const Stage fresh = MakeStage();
    ASSERT_TRUE(fresh.scene->Update(surface, model->tree.depths, { 0, 0, 0 }));
    ASSERT_TRUE(fresh.scene->SetCamera(CameraAt({ 0, 0, 0 })));
    ASSERT_EQ(Compare(fresh.Draw(), picture).pixels, 0u) << "step " << step;
    ASSERT_EQ(ActorsOf(*fresh.scene).size(), ActorsOf(*stage.scene).size());
  }
  EXPECT_GT(kept, 100);
}

TEST(SurfaceScene, KeepsTheCameraWhenTheCenterMoves)
{
  const Stage stage = MakeStage();
  const WindowPicture picture = Draw(stage, BumpySphere(40));
  ASSERT_TRUE(stage.scene->Update(BumpySphere(40), depths, { 8, -16, 32 }));
  // Floats round differently relative to another center, so samples at an edge may change sides.
  EXPECT_LT(Compare(stage.Draw(), picture, 3).pixels, 10u);
}

TEST(SurfaceScene, RefusesBadSurfaces)
{
  const Stage stage = MakeStage();
  const WindowPicture picture = Draw(stage, BumpySphere(20));
  const double huge = std::numeric_limits<double>::max();
  for (const double value : { std::numeric_limits<double>::quiet_NaN(),
         std::numeric_limits<double>::infinity(), huge, -huge, 1e39 })
  {
    Surface bad = BumpySphere(20);
    bad.points[17][1] = value;
    const Status status = stage.scene->Update(bad, depths, { 0, 0, 0 });
    ASSERT_FALSE(status) << value;
    EXPECT_EQ(status.GetError().code, ErrorCode::InvalidInput);
    EXPECT_NE(status.GetError().message.find("point 17"), std::string::npos);
  }
  Surface bad = BumpySphere(20);
  bad.triangles[5][2] = static_cast<VertexId>(bad.points.size());
  const Status index = stage.scene->Update(bad, depths, { 0, 0, 0 });
  ASSERT_FALSE(index);
  EXPECT_NE(index.GetError().message.find("triangle 5"), std::string::npos);
  bad = BumpySphere(20);
  bad.sources.pop_back();
  EXPECT_FALSE(stage.scene->Update(bad, depths, { 0, 0, 0 }));
  EXPECT_FALSE(stage.scene->Update(
    BumpySphere(20), depths, { 0, std::numeric_limits<double>::quiet_NaN(), 0 }));
  EXPECT_EQ(Compare(stage.Draw(), picture).pixels, 0u);
}

TEST(SurfaceScene, RefusesBadCameras)
{
  const Stage stage = MakeStage();
  const WindowPicture picture = Draw(stage, BumpySphere(20));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const SceneCamera& bad : {
         SceneCamera{ { nan, 0, 1 }, { 0, 0, 0 }, { 0, 1, 0 }, 0.5 },
         SceneCamera{ { 0, 0, 1 }, { 0, nan, 0 }, { 0, 1, 0 }, 0.5 },
         SceneCamera{ { 0, 0, 1 }, { 0, 0, 0 }, { 0, 1, nan }, 0.5 },
         SceneCamera{ { 1e308, 0, 0 }, { -1e308, 0, 0 }, { 0, 1, 0 }, 0.5 },
         SceneCamera{ { 3, 2, 1 }, { 3, 2, 1 }, { 0, 1, 0 }, 0.5 },
         SceneCamera{ { 0, 0, 1 }, { 0, 0, 0 }, { 0, 0, 0 }, 0.5 },
         SceneCamera{ { 0, 0, 1 }, { 0, 0, 0 }, { 0, 0, -7 }, 0.5 },
         SceneCamera{ { 0, 0, 1 }, { 0, 0, 0 }, { 0, 1, 0 }, 0.0 },
         SceneCamera{ { 0, 0, 1 }, { 0, 0, 0 }, { 0, 1, 0 }, nan },
         SceneCamera{ { 0, 0, 1 }, { 0, 0, 0 }, { 0, 1, 0 }, std::numbers::pi },
       })
  {
    const Status status = stage.scene->SetCamera(bad);
    ASSERT_FALSE(status);
    EXPECT_EQ(status.GetError().code, ErrorCode::InvalidArgument);
    EXPECT_EQ(status.GetError().message.rfind("camera: ", 0), 0u);
  }
  EXPECT_EQ(Compare(stage.Draw(), picture).pixels, 0u);
}

// The first and last row in which the middle column differs from the background: the upper and
// lower edge of the sphere.
std::pair<int, int> Extent(const WindowPicture& picture, const WindowPicture& background)
{
  int first = side;
  int last = -1;
  for (int y = 0; y < side; ++y)
  {
    const auto pixel = PixelAt(picture, side / 2, y);
    if (std::abs(Brightness(pixel) - Brightness(PixelAt(background, side / 2, y))) > 4.0)
    {
      first = std::min(first, y);
      last = std::max(last, y);
    }
  }
  return { first, last };
}

TEST(SurfaceScene, HasTheFieldOfViewAskedFor)
{
  const Stage stage = MakeStage();
  ASSERT_TRUE(stage.scene->Update(SmoothSphere(), depths, { 0, 0, 0 }));
  const WindowPicture background = Background();
  for (const auto& [distance, view] :
    { std::pair{ 4.0, 0.7 }, { 10.0, 0.3 }, { 1.5, 1.8 }, { 1000.0, 0.003 } })
  {
    ASSERT_TRUE(stage.scene->SetCamera({ { 0, 0, distance }, { 0, 0, 0 }, { 0, 1, 0 }, view }));
    const auto [first, last] = Extent(stage.Draw(), background);
    const double radius = std::tan(std::asin(1.0 / distance)) / std::tan(view / 2) * side / 2;
    EXPECT_NEAR(last - first + 1, 2.0 * radius, 3.0) << distance;
    EXPECT_NEAR(first + last + 1, side, 3.0) << distance;
  }
}

TEST(SurfaceScene, TurnsUpUp)
{
  // A ball that is off the focal point, in the direction of "up".
  Surface ball = SmoothSphere();
  for (Vec3& p : ball.points)
  {
    p = { 0.2 * p[0] + 0.6, 0.2 * p[1], 0.2 * p[2] };
  }
  const Stage stage = MakeStage();
  ASSERT_TRUE(stage.scene->Update(ball, depths, { 0, 0, 0 }));
  ASSERT_TRUE(stage.scene->SetCamera({ { 0, 0, 4 }, { 0, 0, 0 }, { 1, 0, 0.5 }, 0.5 }));
  const auto [first, last] = Extent(stage.Draw(), Background());
  EXPECT_GT(first, 0);
  EXPECT_LT(last, side / 2);
}

TEST(SurfaceScene, CutsNothingOff)
{
  const Stage stage = MakeStage();
  ASSERT_TRUE(stage.scene->Update(SmoothSphere(), depths, { 0, 0, 0 }));
  const WindowPicture background = Background();
  const auto clippingRange = [&]
  {
    const double* range = stage.scene->Renderer().GetActiveCamera()->GetClippingRange();
    return std::pair{ range[0], range[1] };
  };
  // From outside, the near and far planes are close to the surface, and the whole surface is
  // between them.
  for (const double distance : { 1.001, 2.0, 50.0, 1e6 })
  {
    ASSERT_TRUE(stage.scene->SetCamera({ { 0, 0, distance }, { 0, 0, 0 }, { 0, 1, 0 }, 0.1 }));
    const auto [nearPlane, farPlane] = clippingRange();
    EXPECT_GT(nearPlane, 0.0);
    EXPECT_LE(nearPlane, distance - 1.0 + 1e-3);
    EXPECT_GE(farPlane, distance + 1.0);
    EXPECT_LE(farPlane, (distance + 1.0) * 1.01 + 0.1);
  }
  // From inside, the sphere's inner side fills the picture.
  ASSERT_TRUE(stage.scene->SetCamera({ { 0, 0, 0 }, { 0, 0, -1 }, { 0, 1, 0 }, 1.5 }));
  const WindowPicture inside = stage.Draw();
  EXPECT_EQ(Compare(inside, background).pixels, static_cast<std::size_t>(side * side));
  // Looking away shows nothing, and VTK reports no error.
  ASSERT_TRUE(stage.scene->SetCamera({ { 0, 0, 4 }, { 0, 0, 8 }, { 0, 1, 0 }, 0.5 }));
  EXPECT_EQ(Compare(stage.Draw(), background).pixels, 0u);
  // A plane that is seen face on has no extent along the line of sight.
  Surface plane;
  plane.points = { { -1, -1, 0 }, { 1, -1, 0 }, { 1, 1, 0 }, { -1, 1, 0 } };
  plane.sources.resize(4);
  plane.triangles = { { 0, 1, 2 }, { 0, 2, 3 } };
  ASSERT_TRUE(stage.scene->Update(plane, depths, { 0, 0, 0 }));
  ASSERT_TRUE(stage.scene->SetCamera({ { 0, 0, 4 }, { 0, 0, 0 }, { 0, 1, 0 }, 0.3 }));
  EXPECT_EQ(Compare(stage.Draw(), background).pixels, static_cast<std::size_t>(side * side));
  // A single point has no extent at all.
  Surface point;
  point.points = { { 0, 0, 0 } };
  point.sources.resize(1);
  ASSERT_TRUE(stage.scene->Update(point, depths, { 0, 0, 0 }));
  EXPECT_GE(Compare(stage.Draw(), background).pixels, 4u);
}

}
}
