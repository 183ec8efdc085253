// SPDX-License-Identifier: BSD-3-Clause
// A surface with grooves and ridges along y, for tests of drawn relief.
#pragma once

#include "filters/core/drawing/Surface.h"

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace kdstream::test
{

// Extrudes a line of points (x, z), with rising x, along y from -2 to 2. From +z its front is seen.
inline Surface Extruded(const std::vector<std::array<double, 2>>& line)
{
  Surface surface;
  for (const auto& [x, z] : line)
  {
    for (const double y : { -2.0, 2.0 })
    {
      surface.sources.push_back(
        { Resolution::Level(7), MakeKey(0, static_cast<std::uint32_t>(surface.points.size())) });
      surface.points.push_back({ x, y, z });
    }
  }
  for (VertexId i = 0; i + 3 < surface.points.size(); i += 2)
  {
    surface.triangles.push_back({ i, i + 2, i + 1 });
    surface.triangles.push_back({ i + 1, i + 2, i + 3 });
  }
  return surface;
}

// Joins both to one surface.
inline Surface Joined(Surface a, const Surface& b)
{
  const auto first = static_cast<VertexId>(a.points.size());
  for (const Triangle& t : b.triangles)
  {
    a.triangles.push_back({ t[0] + first, t[1] + first, t[2] + first });
  }
  a.points.insert(a.points.end(), b.points.begin(), b.points.end());
  a.sources.insert(a.sources.end(), b.sources.begin(), b.sources.end());
  return a;
}

// Adds a strip behind an eye at (0, 0, 5). The strip is invisible, but puts the eye inside the
// surface's box: the near plane is then as near as possible, and one step of the depth buffer is as
// long as a pixel.
inline Surface AroundTheEye(Surface surface)
{
  return Joined(std::move(surface), Extruded({ { -1, 5.2 }, { 1, 5.2 } }));
}

}
