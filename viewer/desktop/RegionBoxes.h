// SPDX-License-Identifier: BSD-3-Clause
// The boxes of a region's partitions, the picked one's in another colour (paper, Fig. 9).
#pragma once

#include "filters/core/Types.h"

#include <vtkNew.h>

#include <vector>

class vtkActor;
class vtkRenderer;

namespace kdstream
{

// Width of their lines, points.
inline constexpr double boxLineWidth = 1.5;

class RegionBoxes
{
public:
  explicit RegionBoxes(vtkRenderer& renderer);

  // Shows these, the picked one first; none hides them. center: what the renderer's coordinates are
  // relative to.
  void Show(const std::vector<Box>& boxes, const Vec3& center, double lineWidth);

private:
  vtkNew<vtkActor> Actor;
  std::vector<Box> Shown;
  Vec3 Center{};
};

}
