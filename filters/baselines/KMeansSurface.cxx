// SPDX-License-Identifier: BSD-3-Clause
#include "filters/baselines/KMeansSurface.h"

#include "filters/core/Extent.h"
#include "filters/core/Weld.h"

#include <algorithm>

namespace kdstream
{

Result<KMeansSurface> MakeKMeansSurface(
  std::span<const Vec3> points, std::span<const Triangle> triangles)
{
  const Box box = BoxOfPoints(points);
  KDSTREAM_TRY(CheckExtent(box));
  double side = 0;
  for (std::size_t k = 0; k < 3; ++k)
  {
    side = std::max(side, box.hi[k] - box.lo[k]);
  }
  KMeansSurface surface;
  surface.place = FirstCoincident(points, Coincidence::ValueEqual);
  surface.points.reserve(points.size());
  for (const Vec3& p : points)
  {
    Vec3 scaled{};
    for (std::size_t k = 0; k < 3; ++k)
    {
      scaled[k] = side > 0 ? (p[k] - box.lo[k]) / side : 0;
    }
    surface.points.push_back(scaled);
  }
  surface.triangles.reserve(triangles.size());
  for (const Triangle& t : triangles)
  {
    surface.triangles.push_back({ surface.place[t[0]], surface.place[t[1]], surface.place[t[2]] });
  }
  return surface;
}

}
