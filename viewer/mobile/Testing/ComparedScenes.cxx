// SPDX-License-Identifier: BSD-3-Clause
// The scenes that both renderers draw: see ComparedScenes.h.
#include "viewer/mobile/Testing/ComparedScenes.h"

#include "filters/meshio/MeshReader.h"
#include "viewer/session/Geometry.h"
#include "viewer/session/Testing/MemoryServer.h"
#include "viewer/session/appearance/RakingLight.h"
#include "viewer/session/section/ShownSection.h"

#include <cmath>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <utility>

namespace kdstream::test
{
namespace
{

// The user turns the torus, comes nearer and taps. Then the region around the tap is shown as the
// original, and the rest as a coarser level.
ViewerScene WalkOnTorus(kdstream::testing::MemoryServer server, int width, int height)
{
  SessionOptions options;
  options.turning = Turning::Free;
  options.detail = DetailMode::Level;
  options.policy.tolerance = 4;
  ViewerSession session(options);
  session.Resize({ width, height, 1 });
  if (!session.SelectModel("torus"))
  {
    throw std::runtime_error("the torus cannot be selected");
  }
  server.Serve(session);
  session.EnterFullScreen();
  server.Serve(session);
  const double x = width * 0.5, y = height * 0.5;
  session.HandleTouches({ 1.0, { { 1, x, y } } });
  session.HandleTouches({ 1.1, { { 1, x + 20, y + 60 } } });
  session.HandleTouches({ 1.2, {} });
  session.Zoom(1.3, x, y);
  server.Serve(session);
  // Taps at several places, until one is on the ring.
  for (double at = 0.95; at > 0.5 && !session.GetStatus().region; at -= 0.05)
  {
    for (int tap = 0; tap < 2; ++tap)
    {
      session.HandleTouches({ 10.0 - at * 5 + tap * 0.1, { { 1, width * at, y } } });
      session.HandleTouches({ 10.05 - at * 5 + tap * 0.1, {} });
    }
    server.Serve(session);
  }
  if (!session.GetStatus().region)
  {
    throw std::runtime_error("no tap hit the torus");
  }
  return session.Scene();
}

ViewerScene WalkOnTorus(const Mesh& torus, int width, int height)
{
  return WalkOnTorus(kdstream::testing::MemoryServer(torus, 128, 2), width, height);
}

// The region is textured, with seams between its partitions.
ViewerScene WalkOnTexturedTorus(const Mesh& torus, int width, int height)
{
  kdstream::testing::MemoryServer server(torus, 128, 2);
  server.AddTiles(128);
  ViewerScene scene = WalkOnTorus(std::move(server), width, height);
  if (scene.tiles->empty())
  {
    throw std::runtime_error("no textures have come");
  }
  return scene;
}

// The points of a coloured torus, without its triangles.
Mesh AsCloud(Mesh torus, bool withNormals)
{
  torus.triangles.clear();
  if (!withNormals)
  {
    torus.attributes.clear();
  }
  return torus;
}

// Removes the half that is nearer to the eye, so that the inner side of the other half is visible.
ViewerScene Opened(ViewerScene scene)
{
  Surface half = scene.surface->Whole();
  const Vec3 back = scene.eye - scene.focal;
  std::erase_if(half.triangles,
    [&](const Triangle& t) { return Dot(half.points[t[0]] - scene.focal, back) > 0.0; });
  scene.surface = std::make_shared<DrawnSurface>(std::move(half));
  return scene;
}

// Cuts the torus obliquely, so that the half towards the eye is removed, and the solid is capped.
ViewerScene Cut(ViewerScene scene)
{
  ShownSection section;
  section.Reset(scene.box);
  section.SetAlong("view", scene.eye - scene.focal + Vec3{ 0.2, -0.3, 0.1 });
  section.Follow(*scene.surface, scene.surfaceVersion, true);
  scene.section = section.Plane();
  scene.cap = section.Cap();
  scene.capVersion = section.CapVersion();
  return scene;
}

// Lights the scene with two lights from the sides, and makes ridges lighter.
ViewerScene Raked(ViewerScene scene)
{
  scene.lighting =
    LightingOf(RakingLight{ { -0.95, 0.1, 1.1 }, LightSource{ 0.5, -0.6, 0.5 }, 0.6 });
  return scene;
}

Result<Mesh> ReadDragon()
{
  Mesh mesh;
  auto reader = MeshReader::Open(KDSTREAM_DRAGON);
  KDSTREAM_TRY(reader);
  for (const auto& read : { (*reader)->ReadVertices(mesh, ~std::size_t{ 0 }),
         (*reader)->ReadTriangles(mesh, ~std::size_t{ 0 }) })
  {
    KDSTREAM_TRY(read);
  }
  return mesh;
}

// The whole original, with each vertex in its partition, seen from the left.
ViewerScene LookAtDragon(int width, int height)
{
  const Result<Mesh> mesh = ReadDragon();
  if (!mesh)
  {
    throw std::runtime_error(mesh.GetError().message);
  }
  const auto tree = BuildKdTree(mesh->points, {});
  if (!tree)
  {
    throw std::runtime_error(tree.GetError().message);
  }
  Surface surface;
  surface.points = mesh->points;
  surface.triangles = mesh->triangles;
  for (const std::uint32_t partition : CellOfVertex(*tree, tree->depths.partition))
  {
    surface.sources.push_back({ Resolution::Original(), MakeKey(partition, 0) });
  }
  Camera camera;
  camera.SetViewport({ width, height, 1 });
  camera.FitTo(tree->boxes[1]);
  camera.Rotate(width * 0.5, height * 0.5, width * 0.6, height * 0.55);
  ViewerScene scene;
  scene.surface = std::make_shared<DrawnSurface>(std::move(surface));
  scene.surfaceVersion = 1;
  scene.box = tree->boxes[1];
  scene.eye = camera.Eye();
  scene.focal = camera.Focal();
  scene.up = camera.Up();
  scene.orientation = camera.Orientation();
  scene.depths = tree->depths;
  return scene;
}

// Adds an array of numbers: on which side a point is, as a class, or its height.
Mesh WithNumbers(Mesh mesh, bool classes)
{
  Attribute& numbers = mesh.attributes.emplace_back(Attribute{
    { classes ? "classification" : "height",
      classes ? AttributeType::UInt8 : AttributeType::Float32, AttributeAssociation::Point, 1 },
    {} });
  numbers.values.resize(mesh.points.size() * numbers.TupleSize());
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
  {
    const Vec3& p = mesh.points[i];
    numbers.Set(i, 0, classes ? 2 + (p[0] > 0 ? 1 : 0) + (p[1] > 0 ? 2 : 0) : p[0] + p[2]);
  }
  return mesh;
}

Coloring ByNumbers(bool classes)
{
  Coloring coloring(SurfaceColoring::Attribute);
  coloring.attribute = classes ? "classification" : "height";
  coloring.low = -0.5;
  coloring.high = 0.75;
  coloring.hasClasses = coloring.isLas = classes;
  return coloring;
}

}

std::vector<std::uint8_t> PatternOf(const TextureTile& tile)
{
  std::vector<std::uint8_t> texels;
  texels.reserve(std::size_t{ 3 } * tile.width * tile.height);
  for (std::uint32_t y = 0; y < tile.height; ++y)
  {
    for (std::uint32_t x = 0; x < tile.width; ++x)
    {
      const auto wave = [](std::uint32_t t, double length)
      { return static_cast<std::uint8_t>(128 + 100 * std::sin(t / length)); };
      texels.insert(texels.end(), { wave(x, 2), wave(y, 3), wave(x + y, 5) });
    }
  }
  return texels;
}

bool HasDragon()
{
  return std::filesystem::exists(KDSTREAM_DRAGON);
}

std::vector<ComparedScene> MakeComparedScenes()
{
  const Mesh plain = kdstream::testing::MakeTorus(200, 80);
  Mesh colored = plain;
  kdstream::testing::AddVertexColors(colored);
  const ViewerScene portrait = WalkOnTorus(plain, 300, 450);
  const ViewerScene landscape = WalkOnTorus(plain, 450, 300);
  ViewerScene wide = landscape;
  wide.viewAngle = 1.4;
  wide.eye = wide.focal + (wide.eye - wide.focal) * 0.5;
  std::vector<ComparedScene> scenes{
    { "Torus", 300, 450, SurfaceColoring::Stone, portrait },
    { "TorusPartitions", 300, 450, SurfaceColoring::Partition, portrait },
    { "TorusResolutions", 450, 300, SurfaceColoring::Resolution, landscape },
    { "TorusOpened", 300, 450, SurfaceColoring::Stone, Opened(portrait) },
    { "TorusCut", 300, 450, SurfaceColoring::Stone, Cut(portrait) },
    { "TorusRaked", 450, 300, SurfaceColoring::Stone, Raked(landscape) },
    { "TorusWide", 450, 300, SurfaceColoring::Stone, wide },
    { "TorusColors", 300, 450, SurfaceColoring::Own, WalkOnTorus(colored, 300, 450) },
    { "Textured", 300, 450, SurfaceColoring::Own, WalkOnTexturedTorus(colored, 300, 450) },
    { "TorusNumbers", 300, 450, ByNumbers(false),
      WalkOnTorus(WithNumbers(plain, false), 300, 450) },
    { "CloudClasses", 300, 450, ByNumbers(true),
      WalkOnTorus(AsCloud(WithNumbers(plain, true), true), 300, 450) },
    { "Cloud", 300, 450, SurfaceColoring::Own, WalkOnTorus(AsCloud(colored, true), 300, 450) },
    { "CloudCut", 300, 450, SurfaceColoring::Own,
      Cut(WalkOnTorus(AsCloud(colored, true), 300, 450)) },
    { "CloudPlain", 450, 300, SurfaceColoring::Own,
      WalkOnTorus(AsCloud(colored, false), 450, 300) },
  };
  if (HasDragon())
  {
    const ViewerScene dragon = LookAtDragon(450, 300);
    scenes.push_back({ "Dragon", 450, 300, SurfaceColoring::Stone, dragon });
    scenes.push_back({ "DragonCut", 450, 300, SurfaceColoring::Stone, Raked(Cut(dragon)) });
    scenes.push_back({ "DragonPartitions", 450, 300, SurfaceColoring::Partition, dragon });
  }
  return scenes;
}

}
