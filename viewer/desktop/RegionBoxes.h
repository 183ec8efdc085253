// SPDX-License-Identifier: BSD-3-Clause
// The boxes of a region's partitions; the picked partition's box has another colour (paper, Fig.
// 9).
#pragma once

#include "filters/core/Types.h"

#include <vtkNew.h>

#include <vector>

class vtkActor;
class vtkRenderer;

namespace kdstream
{

// Width of the boxes' lines, points.
inline constexpr double boxLineWidth = 1.5;

// The boxes have a renderer of their own, which uses the depths of the model's renderer and draws
// after it. If they were in the model's own renderer, SceneOcclusion (viewer/rendering), which runs
// last there, would take them for surface, and darken the surface beside them.
class RegionBoxes
{
public:
  explicit RegionBoxes(vtkRenderer& model);

  // For vtkRenderWindow::AddRenderer, after the model's.
  vtkRenderer& Renderer() { return *this->Over; }

  // Shows these boxes; the first is that of the picked partition. If `boxes` is empty, nothing is
  // shown. center: the origin of the renderer's coordinates.
  void Show(const std::vector<Box>& boxes, const Vec3& center, double lineWidth);

private:
  vtkRenderer& Model;
  vtkNew<vtkRenderer> Over;
  vtkNew<vtkActor> Actor;
  std::vector<Box> Shown;
  Vec3 Center{};
};

}
