// SPDX-License-Identifier: BSD-3-Clause
// What every renderer decides in the same way about a scene: what can be drawn, the clipping
// planes, the colours, and the normals for lighting. Step "render" of the pipeline picture.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/drawing/DrawnSurface.h"
#include "filters/core/tree/KdTree.h"
#include "viewer/session/appearance/Palette.h"
#include "viewer/session/appearance/VertexNormals.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace kdstream
{

// The camera, in the model's coordinates.
struct SceneCamera
{
  Vec3 eye{ 0.0, 0.0, 1.0 };
  Vec3 focal{ 0.0, 0.0, 0.0 };
  Vec3 up{ 0.0, 1.0, 0.0 };
  double verticalFieldOfView = 0.5; // radians, above 0 and below pi
};

// Checks that `surface` can be drawn with floats relative to `center`. O(points + triangles).
// Errors: InvalidInput for a coordinate that is not finite relative to center, an index out of
// range, or sources or point arrays that do not have one value for each point; LimitExceeded above
// 2^31 - 1 points or corners.
Status CheckSurface(const Surface& surface, const Vec3& center);

// Errors: InvalidArgument for a value that is not finite, an eye at the focal point, an up
// direction along the line of sight, or a field of view out of range.
Status CheckCamera(const SceneCamera& camera);

// The box of the surface's points, relative to `center`.
Box BoundsAround(const Surface& surface, const Vec3& center);
// The bounds, enlarged by `margin` on every side; empty bounds stay empty.
Box Enlarged(const Box& bounds, double margin);

// About the length of edges where triangles are smallest: the mean length of some edges of each
// part, and of these means the smallest; 0 without triangles. O(parts).
double FacetLength(const DrawnSurface& surface);
double FacetLength(const Surface& surface);

// Distances from the eye along the line of sight, 0 < nearest < farthest, between which everything
// of `bounds` lies that is in front of the eye; around the focal point if bounds are empty.
// REQUIRES: the eye is not at the focal point.
struct ClippingPlanes
{
  double nearest = 0.0;
  double farthest = 0.0;
};
ClippingPlanes PlanesAround(const Box& bounds, const Vec3& eye, const Vec3& focal);

// The model's own colours, one for each point: its first array in the role of colours; null if
// there is none. Light scales these bytes as it scales the stone's colour: as sRGB values, without
// conversion to linear light, as VTK does too. A fourth byte (alpha) is ignored: blending would
// require drawing from back to front.
const Attribute* OwnColors(const Surface& surface);
// Whether any part has colours of its own.
bool HasOwnColors(const DrawnSurface& surface);
// REQUIRES: colors are OwnColors of a surface that has the point.
Color OwnColor(const Attribute& colors, std::size_t point);

// The unit normals for lighting the points. For a surface with triangles: ComputeVertexNormals. For
// a cloud: its own normals, which may face either side; (0, 0, 0) for a point without one; empty if
// it has none at all.
UnitNormals NormalsOf(const Surface& surface);

// The inputs for the colour of a vertex or a triangle.
struct ColorSource
{
  std::optional<std::uint32_t> partition; // none coarser than S: clusters span several
  Resolution resolution;
};
ColorSource ColorSourceOf(const Surface::Source& vertex, const TreeDepths& depths);
// The colour source of a triangle across a border: the lowest partition, which owns the triangle,
// and the finest resolution that it touches. So a triangle's colour is always that of one of its
// corners.
ColorSource Together(const ColorSource& a, const ColorSource& b);
Color ColorOf(const ColorSource& source, SurfaceColoring coloring);

}
