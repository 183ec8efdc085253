// SPDX-License-Identifier: BSD-3-Clause
// How a renderer sees a model, from its camera's matrices. Steps:
// 1. find which part of the picture the window draws now (all of it, or a tile)
// 2. find the rays through the corners of the whole picture, in the model's coordinates
// 3. make the symmetric view that contains these rays.
#include "viewer/actor/RendererView.h"

#include "viewer/session/Geometry.h"

#include <vtkCamera.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace kdstream
{
namespace
{

// For a parallel projection, the eye is put at this number of picture heights from the model.
constexpr double farAway = 1e4;

// The side of a window without a size, in pixels.
constexpr int defaultSide = 300;

// The size of the picture in pixels, and which part of it is drawn now, in fractions of the
// picture.
struct PictureShare
{
  std::array<double, 2> size{};
  std::array<double, 2> lo{}, hi{};
};

PictureShare ShareOf(vtkRenderer& renderer)
{
  vtkRenderWindow& window = *renderer.GetRenderWindow();
  const int* const size = window.GetSize(); // of all tiles
  const double* const viewport = renderer.GetViewport();
  double tile[4];
  window.GetTileViewport(tile);
  PictureShare share;
  for (std::size_t k = 0; k < 2; ++k)
  {
    const double extent = viewport[k + 2] - viewport[k];
    share.size[k] = std::round(extent * (size[k] > 0 ? size[k] : defaultSide));
    share.lo[k] = (std::clamp(tile[k], viewport[k], viewport[k + 2]) - viewport[k]) / extent;
    share.hi[k] = (std::clamp(tile[k + 2], viewport[k], viewport[k + 2]) - viewport[k]) / extent;
  }
  return share;
}

Vec3 Transformed(vtkMatrix4x4& matrix, const std::array<double, 4>& point)
{
  std::array<double, 4> out;
  matrix.MultiplyPoint(point.data(), out.data());
  return Vec3{ out[0], out[1], out[2] } * (1 / out[3]);
}

// The length of the model's unit in eye coordinates, along the axis where it is shortest.
double LeastScale(vtkMatrix4x4& eyeFromModel)
{
  double least = 0;
  for (int column = 0; column < 3; ++column)
  {
    const double length = std::hypot(eyeFromModel.GetElement(0, column),
      eyeFromModel.GetElement(1, column), eyeFromModel.GetElement(2, column));
    least = column == 0 ? length : std::min(least, length);
  }
  return least;
}

SurfaceActors::Sight SightOf(
  vtkMatrix4x4& projection, vtkCamera& camera, double height, double scale)
{
  SurfaceActors::Sight sight;
  sight.isParallel = projection.GetElement(3, 2) == 0;
  sight.tangent = 1 / std::hypot(projection.GetElement(1, 0), projection.GetElement(1, 1));
  sight.height = static_cast<int>(height);
  sight.scale = scale;
  // The planes are the depths that the matrix maps to -1 and 1, because a camera's clipping range
  // has no meaning if the projection is explicit.
  const double a = projection.GetElement(2, 2);
  const double b = projection.GetElement(2, 3);
  sight.planes = sight.isParallel ? ClippingPlanes{ (b + 1) / a, (b - 1) / a }
                                  : ClippingPlanes{ b / (a - 1), b / (a + 1) };
  if (!(sight.planes.nearest < sight.planes.farthest && std::isfinite(sight.planes.farthest)))
  {
    sight.planes = { camera.GetClippingRange()[0], camera.GetClippingRange()[1] };
  }
  return sight;
}

}

std::optional<RendererView> ViewOf(vtkRenderer& renderer, vtkMatrix4x4& placed)
{
  vtkCamera& camera = *renderer.GetActiveCamera();
  const PictureShare share = ShareOf(renderer);
  const double width = share.size[0] * (share.hi[0] - share.lo[0]);
  const double height = share.size[1] * (share.hi[1] - share.lo[1]);
  if (!(width >= 1 && height >= 1))
  {
    return std::nullopt;
  }
  vtkNew<vtkMatrix4x4> projection, eyeFromModel, modelFromClip, modelFromWorld;
  projection->DeepCopy(camera.GetProjectionTransformMatrix(width / height, -1, 1));
  vtkMatrix4x4::Multiply4x4(camera.GetModelViewTransformMatrix(), &placed, eyeFromModel);
  vtkMatrix4x4::Multiply4x4(projection, eyeFromModel, modelFromClip);
  vtkMatrix4x4::Multiply4x4(camera.GetModelTransformMatrix(), &placed, modelFromWorld);
  if (modelFromClip->Determinant() == 0 || modelFromWorld->Determinant() == 0)
  {
    return std::nullopt;
  }
  modelFromClip->Invert();
  modelFromWorld->Invert();

  RendererView view;
  view.sight = SightOf(*projection, camera, height, LeastScale(*eyeFromModel));
  // The ray through a place in the whole picture, (0, 0) to (1, 1): its first point and direction.
  const auto ray = [&](double x, double y)
  {
    const double inTileX = 2 * (x - share.lo[0]) / (share.hi[0] - share.lo[0]) - 1;
    const double inTileY = 2 * (y - share.lo[1]) / (share.hi[1] - share.lo[1]) - 1;
    const Vec3 begin = Transformed(*modelFromClip, { inTileX, inTileY, -1, 1 });
    const Vec3 end = Transformed(*modelFromClip, { inTileX, inTileY, 1, 1 });
    return std::pair(begin, Normalized(end - begin));
  };
  const auto [middle, sight] = ray(0.5, 0.5);
  // The point where the ray meets a plane at right angles to the line of sight. In perspective the
  // plane is at distance 1 from the eye, which is the origin; in a parallel projection it is
  // anywhere.
  const auto place = [&, sight = sight](double x, double y)
  {
    const auto [begin, direction] = ray(x, y);
    return view.sight.isParallel ? begin : direction * (1 / Dot(direction, sight));
  };
  const Vec3 center = place(0.5, 0.5);
  const Vec3 upwards = place(0.5, 1) - place(0.5, 0);
  const Vec3 up = Normalized(upwards - sight * Dot(upwards, sight));
  const Vec3 right = Cross(sight, up);
  double halfWidth = 0, halfHeight = 0;
  for (const auto& [x, y] : { std::pair(0, 0), { 0, 1 }, { 1, 0 }, { 1, 1 } })
  {
    const Vec3 corner = place(x, y) - center;
    halfWidth = std::max(halfWidth, std::abs(Dot(corner, right)));
    halfHeight = std::max(halfHeight, std::abs(Dot(corner, up)));
  }
  const double pixels = share.size[1] / Dot(upwards, up); // per unit of length
  constexpr double most = 1e6;
  view.width = static_cast<int>(std::clamp(std::round(2 * halfWidth * pixels), 1.0, most));
  view.height = static_cast<int>(std::clamp(std::round(2 * halfHeight * pixels), 1.0, most));

  double focal[3];
  camera.GetFocalPoint(focal);
  const Vec3 wanted = Transformed(*modelFromWorld, { focal[0], focal[1], focal[2], 1 });
  if (view.sight.isParallel)
  {
    view.camera.focal = middle + sight * Dot(wanted - middle, sight);
    view.camera.eye = view.camera.focal - sight * (farAway * halfHeight);
  }
  else
  {
    view.camera.eye = Transformed(*modelFromClip, { 0, 0, 1, 0 });
    const double distance = Dot(wanted - view.camera.eye, sight);
    view.camera.focal = distance > 0 ? view.camera.eye + sight * distance : middle;
  }
  view.camera.up = up;
  view.camera.verticalFieldOfView = 2 * std::atan(view.sight.isParallel ? 1 / farAway : halfHeight);
  return view;
}

}
