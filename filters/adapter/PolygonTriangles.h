// SPDX-License-Identifier: BSD-3-Clause
// A polygon as triangles, for the VTK filters, which have its points at hand.
#pragma once

#include "filters/core/Types.h"

#include <vtkPoints.h>

#include <span>
#include <vector>

namespace kdstream
{

// Appends the count - 2 triangles of a polygon, oriented as it is: a fan around its first point if
// it is convex, else by cutting ears (vtkPolygon); the fan too if it has no inside (it crosses
// itself, or lies in a line). Nothing for fewer than three points.
// REQUIRES: the ids are points of `points`, below 2^32 - 1.
// O(count), O(count^2) for a concave one.
void AppendPolygon(
  std::span<const vtkIdType> polygon, vtkPoints& points, std::vector<Triangle>& triangles);

}
