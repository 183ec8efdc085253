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

// From now on the actor draws such points; or it draws surfaces again.
void DrawSplats(vtkActor& actor, vtkPolyDataMapper& mapper);
void DrawNoSplats(vtkActor& actor, vtkPolyDataMapper& mapper);

// Before each picture. largestRadius: of the points. tangent: of half the vertical field of view.
// height: of the picture, pixels.
void AimSplats(
  vtkActor& actor, const ClippingPlanes& planes, double largestRadius, double tangent, int height);

}
