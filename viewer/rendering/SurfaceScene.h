// Draws one surface in a VTK renderer. Step "draw" of the README's picture: the surface is
// DrawSurface's.
//
// The model stands like a piece in a museum: stone before a soft gradient, lit by a key light, a
// fill light and a headlight that all follow the camera.
#pragma once

#include "filters/core/KdTree.h"
#include "filters/core/Result.h"
#include "filters/core/Surface.h"
#include "viewer/rendering/Picture.h"

#include <vtkNew.h>

#include <cstdint>
#include <optional>
#include <vector>

class vtkActor;

class vtkPolyData;
class vtkPolyDataMapper;
class vtkRenderer;

namespace kdstream
{

class CloudShading;

enum class SurfaceColoring
{
  Stone,     // one neutral material
  Partition, // a colour a partition; below the stitch depth vertices have none, and stay stone
  Resolution // a colour a resolution
};

struct SceneStyle
{
  SurfaceColoring coloring = SurfaceColoring::Stone;
  bool flat = false;      // a normal a triangle instead of one a vertex
  float pointSize = 0.0f; // pixels, for point clouds; 0: so that neighbours touch
};

// Where one looks from, in the model's coordinates.
struct SceneCamera
{
  Vec3 eye{ 0.0, 0.0, 1.0 };
  Vec3 focal{ 0.0, 0.0, 0.0 };
  Vec3 up{ 0.0, 1.0, 0.0 };
  double verticalFieldOfView = 0.5; // radians, above 0 and below pi
};

// A renderer with one surface, which may be replaced while the camera stays.
// Threads: one at a time, that of the window.
class SurfaceScene
{
public:
  SurfaceScene();
  ~SurfaceScene();
  SurfaceScene(const SurfaceScene&) = delete;
  SurfaceScene& operator=(const SurfaceScene&) = delete;

  // For vtkRenderWindow::AddRenderer. It and its actor stay the same for the scene's life.
  vtkRenderer& Renderer() { return *this->SceneRenderer; }

  // Replaces what is drawn. Triangles are drawn with normals weighted by area; where a surface has
  // none, its points. center: a point near the surface; coordinates relative to it become floats,
  // so that far-away origins cost no precision. depths: those of the surface's cut, for the
  // colouring by partition. O(points + triangles). The surface is not kept. Errors, which leave the
  // scene as it was: InvalidInput for a coordinate that is not finite relative to center, an index
  // out of range, or sources that are not one a point; LimitExceeded above 2^31 - 1 points or
  // corners.
  Status Update(const Surface& surface, const TreeDepths& depths, const Vec3& center);

  void SetStyle(const SceneStyle& style);

  // Near and far planes are found from the surface, now and at each Update.
  // Errors: InvalidArgument for a value that is not finite, an eye at the focal point, an up
  // direction along the line of sight, or a field of view out of range.
  Status SetCamera(const SceneCamera& camera);

private:
  void ApplyCamera();
  void ApplyColors();
  void ShadeAsCloud(bool isCloud);
  void ApplyPointSize();

  vtkNew<vtkRenderer> SceneRenderer;
  vtkNew<vtkActor> Actor;
  vtkNew<vtkPolyDataMapper> Mapper;
  vtkNew<vtkPolyData> Drawn;
  vtkNew<CloudShading> PointShading;

  SceneStyle Style;
  SceneCamera Camera;
  Vec3 Center{ 0.0, 0.0, 0.0 };
  Box Bounds; // of the drawn points, relative to Center
  // One entry a drawn cell (triangle, or point of a cloud).
  std::vector<std::optional<std::uint32_t>> CellPartitions;
  std::vector<Resolution> CellResolutions;
  unsigned long PointSizeObserver = 0;
};

}
