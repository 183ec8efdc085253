// SPDX-License-Identifier: BSD-3-Clause
// The phone's renderer with bad input, lost contexts and repeated draws.
#include "Testing/Fixtures/CutWalk.h"
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/core/drawing/DrawnSurface.h"
#include "viewer/mobile/Testing/GlesTools.h"

#include <EGL/egl.h>
#include <GLES3/gl3.h>

#include <limits>
#include <string>

namespace
{

// The driver is made to report these instead of the truth.
GLenum pretendedError = GL_NO_ERROR;
bool pretendShadersFail = false;

template <class Function>
Function RealFunction(const char* name)
{
  return reinterpret_cast<Function>(eglGetProcAddress(name));
}

}

// Takes precedence over the library's function, to pretend errors that no driver can be made to
// report.
extern "C" GLenum glGetError()
{
  static const auto real = RealFunction<decltype(&glGetError)>("glGetError");
  return pretendedError != GL_NO_ERROR ? pretendedError : real();
}
extern "C" void glGetShaderiv(GLuint shader, GLenum name, GLint* value)
{
  static const auto real = RealFunction<decltype(&glGetShaderiv)>("glGetShaderiv");
  real(shader, name, value);
  *value = pretendShadersFail ? GL_FALSE : *value;
}

namespace kdstream::test
{
namespace
{

constexpr int side = 120;

// The number of buffers in the context, without deleted ones.
int CountBuffers()
{
  int count = 0;
  for (GLuint name = 1; name < 1000; ++name)
  {
    count += glIsBuffer(name) ? 1 : 0;
  }
  return count;
}

TEST(GlesRenderer, NeedsAContext)
{
  eglBindAPI(EGL_OPENGL_ES_API);
  ASSERT_EQ(eglGetCurrentContext(), EGL_NO_CONTEXT);
  const auto renderer = GlesRenderer::Make();
  EXPECT_TRUE(fixtures::FailsAt(renderer, ErrorCode::Unsupported));
}

// Geomorphs: at first the picture is that of the earlier surface, at the end that of the new one,
// and in between it is neither. Afterwards nothing of the geomorph is left.
TEST(GlesRenderer, MorphsFromTheSurfaceBefore)
{
  const auto model = fixtures::MakeModel(fixtures::DisplacedSphere(4), { 60, {}, 8 }, {}, {}, 2);
  const TreeDepths& depths = model->tree.depths;
  Cut cut{ depths, Resolution::Level(depths.finest - 1) };
  SurfaceParts parts;
  parts.Follow(true);
  PartNormals normals;
  Canvas canvas(side, side);
  ViewerScene scene = SceneOf(Surface{}, 1);
  scene.box = model->tree.boxes[1];
  scene.depths = depths;
  const auto show = [&](double morphed)
  {
    canvas.renderer->SetMorphed(morphed);
    return canvas.Draw(scene);
  };
  const auto goOn = [&]
  {
    const auto before = scene.surface;
    ASSERT_TRUE(parts.GoTo(cut, model->Lookup()));
    normals.GoTo(parts.Parts());
    ++scene.surfaceVersion;
    scene.surface =
      std::make_shared<const DrawnSurface>(parts.Parts(), normals.Of(), *before, parts.Parents());
  };
  goOn();
  EXPECT_FALSE(scene.surface->HasGeomorphs()); // there was no surface to morph from
  const Image before = show(1);
  const std::size_t partitions = std::size_t{ 1 } << depths.partition;
  for (std::uint32_t partition = 0; partition < partitions; partition += 2)
  {
    cut.active.push_back(PieceOfPartition(Resolution::Original(), partition, depths));
  }
  goOn();
  ASSERT_TRUE(scene.surface->HasGeomorphs());
  const Image first = show(0), middle = show(0.5);
  const int morphing = CountBuffers();
  const std::size_t morphingBytes = canvas.renderer->GraphicsBytes();
  const Image last = show(1);
  const int arrived = CountBuffers();
  EXPECT_GT(Compare(last, before).mean, 20 * Compare(first, before).mean);
  EXPECT_GT(Compare(middle, before).mean, 5 * Compare(first, before).mean);
  EXPECT_GT(Compare(middle, last).mean, 5 * Compare(first, before).mean);
  Canvas fresh(side, side);
  EXPECT_EQ(Compare(fresh.Draw(scene), last).pixels, 0u);
  EXPECT_GT(morphing, arrived);
  EXPECT_EQ(CountBuffers(), arrived);
  EXPECT_GT(morphingBytes, canvas.renderer->GraphicsBytes());
  EXPECT_EQ(canvas.renderer->GraphicsBytes(), fresh.renderer->GraphicsBytes());
}

// As Draw documents: 16 bytes per vertex, 4 more with colours, 6 per triangle; and the textures of
// ambient occlusion, with half the picture's sides.
TEST(GlesRenderer, ReportsHowMuchItHolds)
{
  const Surface sphere = BumpySphere(24);
  const std::size_t points = sphere.points.size(), triangles = sphere.triangles.size();
  Canvas canvas(side, side);
  EXPECT_EQ(canvas.renderer->GraphicsBytes(), 0u);
  ViewerScene scene = SceneOf(sphere, 1);
  canvas.Draw(scene);
  EXPECT_EQ(canvas.renderer->GraphicsBytes(), 16 * points + 6 * triangles);
  canvas.renderer->SetColoring(SurfaceColoring::Resolution);
  canvas.Draw(scene);
  EXPECT_EQ(canvas.renderer->GraphicsBytes(), 20 * points + 6 * triangles);
  canvas.renderer->SetColoring(SurfaceColoring::Own);
  canvas.renderer->SetOcclusion(true);
  canvas.Draw(scene);
  EXPECT_EQ(canvas.renderer->GraphicsBytes(), 16 * points + 6 * triangles + 6 * side * side / 4);
  canvas.renderer->Forget();
  EXPECT_EQ(canvas.renderer->GraphicsBytes(), 0u);
}

// Draws a series of cuts, of which only the differences are uploaded. The picture is the same as
// that of a renderer that has drawn only the last cut, and nothing is left of earlier cuts.
TEST(GlesRenderer, DrawsWhatDiffersAsAllAnew)
{
  const auto model = fixtures::MakeModel(fixtures::DisplacedSphere(4), { 60, {}, 8 }, {}, {}, 2);
  fixtures::CutWalk walk(*model, 11);
  SurfaceParts parts;
  PartNormals normals;
  Canvas kept(side, side);
  for (std::uint64_t step = 1; step <= 60; ++step, walk.Step())
  {
    ASSERT_TRUE(parts.GoTo(walk.Now(), model->Lookup()));
    normals.GoTo(parts.Parts());
    ViewerScene scene = SceneOf(Surface{}, step);
    scene.surface = std::make_shared<const DrawnSurface>(parts.Parts(), normals.Of());
    scene.box = model->tree.boxes[1];
    scene.depths = model->tree.depths;
    const auto coloring = step % 20 < 10 ? SurfaceColoring::Stone : SurfaceColoring::Partition;
    kept.renderer->SetColoring(coloring);
    const Image picture = kept.Draw(scene);
    const int buffers = CountBuffers();
    Canvas fresh(side, side);
    fresh.renderer->SetColoring(coloring);
    ASSERT_EQ(Compare(fresh.Draw(scene), picture).pixels, 0u) << "step " << step;
    ASSERT_EQ(CountBuffers(), buffers) << "step " << step;
  }
}

TEST(GlesRenderer, DrawsTheSameAgain)
{
  Canvas canvas(side, side);
  const ViewerScene scene = SceneOf(BumpySphere(30));
  const Image first = canvas.Draw(scene);
  EXPECT_EQ(Compare(canvas.Draw(scene), first).pixels, 0u);
  const Image nothing = canvas.Draw(SceneOf(Surface{}, 2));
  EXPECT_GT(Compare(nothing, first).pixels, first.size() / 3 / 6);
  EXPECT_EQ(Compare(canvas.Draw(SceneOf(BumpySphere(30), 3)), first).pixels, 0u);
}

TEST(GlesRenderer, UploadsAnotherSurfaceOnlyForAnotherVersion)
{
  Canvas canvas(side, side);
  const Image sphere = canvas.Draw(SceneOf(BumpySphere(30), 1));
  ViewerScene other = SceneOf(BumpySphere(4), 1);
  EXPECT_EQ(Compare(canvas.Draw(other), sphere).pixels, 0u);
  other.surfaceVersion = 2;
  EXPECT_GT(Compare(canvas.Draw(other), sphere).pixels, 0u);
}

TEST(GlesRenderer, FreesWhatItReplaces)
{
  Canvas canvas(side, side);
  canvas.Draw(SceneOf(BumpySphere(201), 1));
  EXPECT_EQ(CountBuffers(), 4); // two chunks of vertices and indices
  canvas.renderer->SetColoring(SurfaceColoring::Partition);
  canvas.Draw(SceneOf(BumpySphere(201), 1));
  EXPECT_EQ(CountBuffers(), 6);
  canvas.Draw(SceneOf(BumpySphere(20), 2));
  EXPECT_EQ(CountBuffers(), 3);
  Surface cloud = BumpySphere(20);
  cloud.triangles.clear();
  canvas.Draw(SceneOf(cloud, 3));
  EXPECT_EQ(CountBuffers(), 3); // vertices, colours, radii
  canvas.Draw(SceneOf(Surface{}, 4));
  EXPECT_EQ(CountBuffers(), 0);
  canvas.Draw(SceneOf(BumpySphere(20), 5));
  canvas.renderer.reset();
  EXPECT_EQ(CountBuffers(), 0);
}

TEST(GlesRenderer, ChangesItsColoring)
{
  Canvas canvas(side, side);
  const ViewerScene scene = SceneOf(BumpySphere(30));
  const Image stone = canvas.Draw(scene);
  canvas.renderer->SetColoring(SurfaceColoring::Partition);
  const Image partitions = canvas.Draw(scene);
  canvas.renderer->SetColoring(SurfaceColoring::Resolution);
  const Image resolutions = canvas.Draw(scene);
  EXPECT_GT(Compare(partitions, stone).mean, 5.0);
  EXPECT_GT(Compare(resolutions, stone).mean, 5.0);
  EXPECT_GT(Compare(resolutions, partitions).mean, 5.0);
  canvas.renderer->SetColoring(SurfaceColoring::Stone);
  EXPECT_EQ(Compare(canvas.Draw(scene), stone).pixels, 0u);
}

TEST(GlesRenderer, DrawsAnewInANewContext)
{
  const ViewerScene scene = SceneOf(BumpySphere(30));
  for (const auto coloring : { SurfaceColoring::Stone, SurfaceColoring::Resolution })
  {
    Canvas canvas(side, side);
    canvas.renderer->SetColoring(coloring);
    const Image before = canvas.Draw(scene);
    // The context is destroyed with everything in it.
    canvas.target.reset();
    canvas.renderer->Forget();
    const Status without = canvas.renderer->Draw(scene, { side, side, 1 });
    EXPECT_TRUE(fixtures::FailsAt(without, ErrorCode::Unsupported));
    canvas.target = std::move(*EglOffscreen::Make(side, side));
    EXPECT_EQ(Compare(canvas.Draw(scene), before).pixels, 0u);
    EXPECT_EQ(CountBuffers(), coloring == SurfaceColoring::Stone ? 2 : 3);
  }
}

TEST(GlesRenderer, KeepsItsPictureWhereASurfaceIsBad)
{
  Canvas canvas(side, side);
  const Image good = canvas.Draw(SceneOf(BumpySphere(20), 1));
  std::uint64_t version = 1;
  const auto refuses = [&](const Surface& bad, const std::string& message)
  {
    ViewerScene scene = SceneOf(BumpySphere(20), ++version);
    scene.surface = std::make_shared<const DrawnSurface>(bad);
    for (int again = 0; again < 2; ++again)
    {
      const Status status = canvas.Try(scene);
      ASSERT_FALSE(status) << message;
      EXPECT_EQ(status.GetError().code, ErrorCode::InvalidInput);
      EXPECT_NE(status.GetError().message.find(message), std::string::npos)
        << status.GetError().message;
      EXPECT_EQ(Compare(canvas.Read(), good).pixels, 0u) << message;
    }
  };
  for (const double value : { std::numeric_limits<double>::quiet_NaN(),
         std::numeric_limits<double>::infinity(), 1e300, -1e39 })
  {
    Surface bad = BumpySphere(20);
    bad.points[17][1] = value;
    refuses(bad, "point 17 cannot be drawn");
  }
  Surface bad = BumpySphere(20);
  bad.triangles[5][2] = static_cast<VertexId>(bad.points.size());
  refuses(bad, "triangle 5 has a vertex that does not exist");
  bad = BumpySphere(20);
  bad.triangles[6][0] = noVertex;
  refuses(bad, "triangle 6 has a vertex that does not exist");
  bad = BumpySphere(20);
  bad.sources.pop_back();
  refuses(bad, "sources for");
  bad = BumpySphere(20);
  bad.points.clear();
  bad.sources.clear();
  refuses(bad, "triangle 0 has a vertex that does not exist");
  EXPECT_EQ(Compare(canvas.Draw(SceneOf(BumpySphere(20), ++version)), good).pixels, 0u);
}

TEST(GlesRenderer, RefusesBadCamerasAndPictures)
{
  Canvas canvas(side, side);
  const ViewerScene good = SceneOf(BumpySphere(20));
  ViewerScene bad = good;
  bad.eye = bad.focal;
  EXPECT_TRUE(fixtures::FailsAt(canvas.Try(bad), ErrorCode::InvalidArgument, "the eye"));
  bad = good;
  bad.eye[2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(fixtures::FailsAt(canvas.Try(bad), ErrorCode::InvalidArgument, "coordinate"));
  bad = good;
  bad.up = bad.eye - bad.focal;
  EXPECT_TRUE(fixtures::FailsAt(canvas.Try(bad), ErrorCode::InvalidArgument, "camera: up "));
  bad = good;
  bad.viewAngle = 4.0;
  EXPECT_TRUE(fixtures::FailsAt(canvas.Try(bad), ErrorCode::InvalidArgument, "field of view"));
  for (const Viewport& viewport : { Viewport{ 0, 10, 1 }, Viewport{ 10, -1, 1 } })
  {
    const Status status = canvas.renderer->Draw(good, viewport);
    ASSERT_FALSE(status);
    EXPECT_EQ(status.GetError().code, ErrorCode::InvalidArgument);
  }
}

TEST(GlesRenderer, SaysThatTheGraphicsMemoryIsFull)
{
  Canvas canvas(side, side);
  const Image nothing = canvas.Draw(SceneOf(Surface{}, 1));
  const Image sphere = canvas.Draw(SceneOf(BumpySphere(20), 2));
  pretendedError = GL_OUT_OF_MEMORY;
  Status status = canvas.Try(SceneOf(BumpySphere(201), 3));
  pretendedError = GL_NO_ERROR;
  for (int again = 0; again < 2; ++again)
  {
    ASSERT_TRUE(fixtures::FailsAt(status, ErrorCode::LimitExceeded, "80402 points"));
    EXPECT_TRUE(fixtures::FailsAt(status, ErrorCode::LimitExceeded, "160800 triangles"));
    EXPECT_EQ(Compare(canvas.Read(), nothing).pixels, 0u);
    EXPECT_EQ(CountBuffers(), 0);
    status = canvas.Try(SceneOf(BumpySphere(201), 3)); // uploading is not tried again
  }
  EXPECT_EQ(Compare(canvas.Draw(SceneOf(BumpySphere(20), 4)), sphere).pixels, 0u);
}

TEST(GlesRenderer, SaysThatAShaderIsRefused)
{
  const auto target = EglOffscreen::Make(side, side);
  ASSERT_TRUE(target);
  pretendShadersFail = true;
  const auto renderer = GlesRenderer::Make();
  pretendShadersFail = false;
  ASSERT_FALSE(renderer);
  EXPECT_EQ(renderer.GetError().code, ErrorCode::Unsupported);
  EXPECT_EQ(
    renderer.GetError().message.rfind("OpenGL ES: the background's shader does not compile: ", 0),
    0u)
    << renderer.GetError().message;
}

// Points in the same place, triangles without an area, coordinates of any size.
TEST(GlesRenderer, DrawsDegenerateSurfaces)
{
  Canvas canvas(side, side);
  const Image nothing = canvas.Draw(SceneOf(Surface{}, 1));
  Surface point;
  point.points.assign(3, Vec3{ 1, 2, 3 });
  point.sources.resize(3);
  EXPECT_GE(Compare(canvas.Draw(SceneOf(point, 2)), nothing).pixels, 4u); // 2 by 2
  point.triangles = { { 0, 1, 2 }, { 0, 0, 0 } };
  EXPECT_EQ(Compare(canvas.Draw(SceneOf(point, 3)), nothing).pixels, 0u);
  // The normals of a triangle and of its mirror image cancel out.
  Surface both;
  both.points = { { -1, -1, 0 }, { 1, -1, 0 }, { 0, 1, 0 } };
  both.sources.resize(3);
  both.triangles = { { 0, 1, 2 }, { 0, 2, 1 } };
  const Image cancelled = canvas.Draw(SceneOf(both, 4));
  both.triangles.pop_back();
  EXPECT_LE(Compare(cancelled, canvas.Draw(SceneOf(both, 5))).mean, 6.0);
  EXPECT_GT(Compare(cancelled, nothing).mean, 8.0);
}

TEST(GlesRenderer, DoesNotDependOnTheUnit)
{
  Canvas canvas(side, side);
  const Image usual = canvas.Draw(SceneOf(BumpySphere(30), 1));
  std::uint64_t version = 1;
  for (const double unit : { 0x1p-60, 0x1p-24, 0x1p24, 0x1p100 })
  {
    Surface sphere = BumpySphere(30);
    for (Vec3& p : sphere.points)
    {
      p = p * unit;
    }
    ViewerScene scene = SceneOf(sphere, ++version);
    scene.eye = scene.focal + (scene.eye - scene.focal) * unit;
    EXPECT_EQ(Compare(canvas.Draw(scene), usual).pixels, 0u) << unit;
  }
}

// The lights move with the camera: turning the model and the camera together changes nothing.
TEST(GlesRenderer, LightsFollowTheCamera)
{
  Canvas canvas(side, side);
  ViewerScene scene = SceneOf(BumpySphere(30), 1);
  const Image before = canvas.Draw(scene);
  Surface turned = scene.surface->Whole();
  const auto turn = [](const Vec3& p) { return Vec3{ p[2], p[0], p[1] }; };
  for (Vec3& p : turned.points)
  {
    p = turn(p);
  }
  scene = SceneOf(turned, 2);
  scene.eye = scene.focal + turn({ 1.5, 1.2, 4.8 });
  scene.up = turn({ 0, 1, 0 });
  EXPECT_LE(Compare(canvas.Draw(scene), before, 2).pixels, 20u);
}

// Other code may leave the context in any state, because the renderer sets everything that it
// needs.
TEST(GlesRenderer, ExpectsNothingOfTheContext)
{
  Canvas canvas(side, side);
  const ViewerScene scene = SceneOf(BumpySphere(20));
  const Image before = canvas.Draw(scene);
  glEnable(GL_CULL_FACE);
  glCullFace(GL_FRONT);
  glEnable(GL_BLEND);
  glClearDepthf(0.0f);
  glClear(GL_DEPTH_BUFFER_BIT);
  glDepthMask(GL_FALSE);
  glDepthFunc(GL_NEVER);
  glEnable(GL_SCISSOR_TEST);
  glScissor(0, 0, 1, 1);
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  glViewport(0, 0, 3, 3);
  glUseProgram(0);
  EXPECT_EQ(Compare(canvas.Draw(scene), before).pixels, 0u);
}

TEST(EglOffscreen, RefusesImpossiblePictures)
{
  for (const auto& [width, height] : { std::pair{ 0, 10 }, { 10, -3 } })
  {
    const auto made = EglOffscreen::Make(width, height);
    ASSERT_FALSE(made);
    EXPECT_EQ(made.GetError().code, ErrorCode::InvalidArgument);
  }
  const auto huge = EglOffscreen::Make(1 << 30, 10);
  ASSERT_FALSE(huge);
  EXPECT_EQ(huge.GetError().code, ErrorCode::Unsupported);
  EXPECT_NE(huge.GetError().message.find("sides are at most"), std::string::npos);
}

TEST(EglOffscreen, LivesBesideOthers)
{
  Canvas small(side, side);
  Canvas wide(2 * side, side);
  const ViewerScene scene = SceneOf(BumpySphere(20));
  const Image first = small.Draw(scene);
  EXPECT_EQ(wide.Draw(scene).size(), 2 * first.size());
  EXPECT_EQ(Compare(small.Draw(scene), first).pixels, 0u);
}

// CMake runs this separately, in an environment in which EGL has no driver.
TEST(WithoutEgl, DISABLED_SaysWhatIsMissing)
{
  const auto made = EglOffscreen::Make(side, side);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.GetError().code, ErrorCode::NotFound);
  EXPECT_EQ(made.GetError().message.rfind("EGL: ", 0), 0u) << made.GetError().message;
}

}
}
