// SPDX-License-Identifier: BSD-3-Clause
// The points of a cloud as round splats, by VTK's shaders. Internal to viewer/rendering.
//
// VTK draws all points of an actor as squares of one size. So all get the size of the largest
// visible splat, and each discards the pixels outside its own circle. The circle has the splat's
// radius on the screen, and is bent away from the eye at its rim, so that neighbours meet halfway.
// With normals points are lit on the visible side; without normals they are drawn as shallow domes,
// darker with the distance: all as in viewer/mobile/GlesShaders.h.
#pragma once

#include "viewer/session/appearance/SceneRules.h"

class vtkActor;
class vtkPolyDataMapper;

namespace kdstream
{

// The point array of the radii, floats in the model's unit. A cloud also has point normals, because
// VTK does not light points without them; (0, 0, 0) stands for no normal.
inline constexpr const char* splatRadiusArray = "SplatRadius";

// From now on the actor draws points; or it draws surfaces again. isLit: SplatSight::isLit.
void DrawSplats(vtkActor& actor, vtkPolyDataMapper& mapper, bool isLit);
void DrawNoSplats(vtkActor& actor, vtkPolyDataMapper& mapper);

// How a picture sees a cloud, for its splats.
struct SplatSight
{
  ClippingPlanes planes;   // in a parallel projection they may be behind the eye
  bool isParallel = false; // a projection without perspective
  double tangent = 1;      // half the picture's height, at distance 1; in parallel anywhere
  int height = 1;          // of the picture, pixels
  double scale = 1;        // length of the model's unit, in units of the planes
  bool isLit = true;       // false: the shader has no light, and VTK gives it no normals
};

// Before each picture. largestRadius: of the points.
void AimSplats(vtkActor& actor, double largestRadius, const SplatSight& sight);

}
