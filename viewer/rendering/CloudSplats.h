// SPDX-License-Identifier: BSD-3-Clause
// Draws the points of a cloud as round splats, by VTK's shaders. Internal to viewer/rendering.
//
// VTK draws all points of an actor as squares of one size. So all squares get the size of the
// largest visible splat, and each point discards the pixels outside its own circle. The circle has
// the splat's radius on the screen. Its rim is bent away from the eye, so that neighbours meet
// halfway. Points with normals are lit on the visible side. Points without normals are drawn as
// shallow domes, darker with the distance. All this is as in viewer/mobile/GlesShaders.h.
// darker with the distance: all as in viewer/mobile/GlesShaders.h.
#pragma once

#include "viewer/session/appearance/SceneRules.h"

class vtkActor;
class vtkPolyDataMapper;

namespace kdstream
{

// The name of the point array of radii: floats in the model's unit. A cloud also needs point
// normals, because VTK does not light points without them; (0, 0, 0) stands for no normal.
inline constexpr const char* splatRadiusArray = "SplatRadius";

// Makes the actor draw points as splats; DrawNoSplats makes it draw surfaces again. isLit:
// SplatSight::isLit.
void DrawSplats(vtkActor& actor, vtkPolyDataMapper& mapper, bool isLit);
void DrawNoSplats(vtkActor& actor, vtkPolyDataMapper& mapper);

// How a picture sees a cloud; this determines the splats' sizes.
struct SplatSight
{
  ClippingPlanes planes;   // in a parallel projection they may be behind the eye
  bool isParallel = false; // a projection without perspective
  double tangent = 1;      // half the picture's height at distance 1; if parallel, at any distance
  int height = 1;          // of the picture, pixels
  double scale = 1;        // length of the model's unit, in units of the planes
  bool isLit = true;       // false: the shader has no light, and VTK gives it no normals
};

// Call this before each picture. largestRadius: the largest radius of a point.
void AimSplats(vtkActor& actor, double largestRadius, const SplatSight& sight);

}
