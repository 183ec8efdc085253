// SPDX-License-Identifier: BSD-3-Clause
// The points of a cloud as round splats, by VTK's shaders. Internal to viewer/rendering.
//
// VTK draws all points of an actor as squares of one size. So all get the size of the largest splat
// in sight, and each discards what lies outside its own circle. That is as large as its radius
// appears, and bent away from the eye at its rim, so that neighbours meet halfway. Points are lit
// by their normals, on the side that is seen; without normals as shallow domes, darker the farther
// away: all as in viewer/mobile/GlesShaders.h.
#pragma once

#include "viewer/session/look/SceneRules.h"

class vtkActor;
class vtkPolyDataMapper;

namespace kdstream
{

// The point array of the radii, floats in the model's unit. A cloud also has point normals: VTK
// lights no points without; (0, 0, 0) is none.
inline constexpr const char* splatRadiusArray = "SplatRadius";

// From now on the actor draws such points; or it draws surfaces again. isLit: SplatSight::isLit.
void DrawSplats(vtkActor& actor, vtkPolyDataMapper& mapper, bool isLit);
void DrawNoSplats(vtkActor& actor, vtkPolyDataMapper& mapper);

// Where a picture is taken from.
struct SplatSight
{
  ClippingPlanes planes;   // of a parallel projection they may lie behind the eye
  bool isParallel = false; // a projection without perspective
  double tangent = 1;      // half the picture's height, at distance 1; in parallel anywhere
  int height = 1;          // of the picture, pixels
  double scale = 1;        // how long the model's unit is in those of the planes
  bool isLit = true;       // false: the shader has no light, and VTK gives it no normals
};

// Before each picture. largestRadius: of the points.
void AimSplats(vtkActor& actor, double largestRadius, const SplatSight& sight);

}
